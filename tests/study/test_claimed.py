"""Which cells put a claim to the test."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from facade import Cell, claims_of, problem_spec, promises_of
from sdaeverify import SDE, Claim, Scheme
from sdaeverify.measuring import Measure, Verdict

EVERYWHERE = Claim(measure="sharp", value=0.5, source="made up")
ADDITIVE = Claim(measure="sharp", value=1.0, source="made up", when=frozenset({"additive-noise"}))
OTHER = Claim(measure="blunt", value=1.0, source="made up")


@dataclass(frozen=True)
class Careful(Scheme):
    name: ClassVar[str] = "careful"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (EVERYWHERE, ADDITIVE, OTHER)


class Sharp(Measure):
    name = "sharp"


def flat(additive=True) -> SDE:
    traits = frozenset({"additive-noise"}) if additive else frozenset()
    return SDE(
        drift=lambda t, x: 0 * x,
        diffusion=lambda t, x: np.ones((1, 1, x.shape[1])),
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="made up",
        traits=traits,
    )


CELL = Cell(Careful(), problem_spec(flat), Sharp())


def test_promises_of_a_cell():
    """The promises of a cell are the claims that name its measure."""
    assert promises_of(CELL) == (EVERYWHERE, ADDITIVE)


@pytest.mark.parametrize(("additive", "claims"), [(True, (EVERYWHERE, ADDITIVE)), (False, (EVERYWHERE,))])
def test_claims_in_scope(additive, claims):
    """Claims are put to the test where the problem has the traits they ask for."""
    assert claims_of(replace(CELL, seen=flat(additive=additive))) == claims


def test_cells_that_cannot_be_run():
    """A cell that does not apply tests nothing; in one that is in error any claim might have been tested."""
    assert claims_of(replace(CELL, verdict=Verdict.NOT_APPLICABLE)) == ()
    assert claims_of(replace(CELL, verdict=Verdict.ERROR)) == (EVERYWHERE, ADDITIVE)
