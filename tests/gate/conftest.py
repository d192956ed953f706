"""Cells, findings and outcomes made by hand."""

from dataclasses import dataclass, replace
from typing import ClassVar

import pytest

from facade import (
    MEASURES,
    PROBLEMS,
    SCHEMES,
    Cell,
    CellResult,
    Origin,
    Policy,
    Registered,
    Registry,
    outcomes,
    problem_spec,
)
from sdaeverify import SDE, Claim, Scheme, Settings, Step
from sdaeverify.gate.gated import Gated
from sdaeverify.measuring import Finding, Measure, Reason, Verdict

SHARP = Claim(measure="sharp", value=1.0, source="made up")
WEAKER = Claim(measure="sharp", value=0.5, source="made up")
UNCLAIMED = {Verdict.ERROR, Verdict.NOT_RUN, Verdict.OUT_OF_SCOPE, Verdict.NOT_APPLICABLE}
NASTY = 'a<b>&"\n::error::x\x00\x1b[31m|`%0A'


@dataclass(frozen=True)
class Plain(Scheme):
    kind: str = "plain"

    name: ClassVar[str] = "plain"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (SHARP,)

    def step(self, problem, state, t, h, noise):
        return Step(state)


@dataclass(frozen=True)
class Fussy(Plain):
    name: ClassVar[str] = "fussy"
    claims: ClassVar[tuple] = (WEAKER, replace(SHARP, when=frozenset({"additive-noise"})))


class Sharp(Measure):
    name = "sharp"


class Blunt(Measure):
    name = "blunt"


def problem(components=1, traits=(), **fields):
    return SDE(
        drift=lambda t, x: 0 * x,
        diffusion=lambda t, x: 0 * x[:, None] + 1,
        start=[1.0] * components,
        noise_dim=1,
        horizon=1.0,
        source="made up",
        traits=frozenset(traits),
        **fields,
    )


def line() -> SDE:
    return problem()


def added() -> SDE:
    return problem(traits={"additive-noise"})


def plane() -> SDE:
    return problem(2)


def registered(schemes=(Plain(), Fussy()), families=(line, added, plane), distribution="pack"):
    """Return a registry of these schemes and problems, and the measures sharp and blunt."""
    origin = Origin("test", distribution, "1", "module")
    named = {}
    for scheme in schemes:
        named.setdefault(scheme.name, []).append(scheme)
    return Registry(
        {
            SCHEMES: {name: Registered(name, tuple(variants), origin) for name, variants in named.items()},
            PROBLEMS: {family.__name__: Registered(family.__name__, (family,), origin) for family in families},
            MEASURES: {measure.name: Registered(measure.name, (measure,), origin) for measure in (Blunt(), Sharp())},
        }
    )


def result(verdict, *, scheme=Plain(), quantity="x", claim=SHARP, reason="because", **fields):
    """Return the result of a cell with one finding."""
    claim = None if verdict in UNCLAIMED else claim
    finding = Finding(quantity=quantity, verdict=verdict, reason=Reason(reason), claim=claim, **fields)
    return CellResult(Cell(scheme, problem_spec(line), Sharp()), (finding,), paths=256, seconds=0.5)


def gated(*results, policy=None, **fields):
    """Return a gate that came to its end with these results."""
    policy = policy or Policy()
    return Gated(tuple(outcomes(results, policy)), policy, Settings(), **fields)


@pytest.fixture
def everything():
    """Return one result of each verdict, with names and texts that are hard to show."""
    odd = Plain(NASTY)
    return [result(verdict, scheme=odd, quantity=f"x{NASTY}", reason=NASTY) for verdict in Verdict]
