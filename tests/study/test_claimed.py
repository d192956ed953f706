"""Which cells put a claim to the test."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from facade import Cell, claims_of, problem_spec, promises_of
from sdaeverify import SDE, Claim, Scheme
from sdaeverify.measuring import Measure, Verdict

EVERYWHERE = Claim(measure="sharp", value=0.5, source="made up")
ADDITIVE = Claim(measure="sharp", value=1.0, source="made up", when=frozenset({"additive-noise"}))
OTHER = Claim(measure="blunt", value=1.0, source="made up")


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


@pytest.mark.parametrize(
    ("known", "claims"),
    [
        ({"seen": flat()}, (EVERYWHERE, ADDITIVE)),
        ({"seen": flat(additive=False)}, (EVERYWHERE,)),
        ({"verdict": Verdict.NOT_APPLICABLE}, ()),
        ({"verdict": Verdict.ERROR}, (EVERYWHERE, ADDITIVE)),
    ],
    ids=["in scope", "without the trait", "not applicable", "error"],
)
def test_claims_of_a_cell(known, claims):
    """Claims of its measure are put to the test where the problem has their traits; all might be in an error."""
    assert promises_of(CELL) == (EVERYWHERE, ADDITIVE)
    assert claims_of(replace(CELL, **known)) == claims
