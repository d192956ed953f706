"""Findings and cells of planted bugs and of correct schemes, made by hand."""

from dataclasses import dataclass
from typing import ClassVar

import pytest

from facade import MEASURES, PROBLEMS, SCHEMES, Cell, CellResult, Origin, Planted, Registered, Registry, problem_spec
from sdaeverify import SDE, Claim, Scheme
from sdaeverify.measuring import Finding, Measure, Reason, Verdict

HERE = Origin("test", "", "", __file__)
CLAIM = Claim(measure="sharp", value=1.0, source="made up")


class Good(Scheme):
    name: ClassVar[str] = "good"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (CLAIM,)

    def step(self, problem, state, t, h, noise):
        raise NotImplementedError


@dataclass(frozen=True)
class Bad(Good):
    kind: str = "plain"

    name: ClassVar[str] = "planted-bad"


class Sharp(Measure):
    name = "sharp"


class Blunt(Measure):
    name = "blunt"


def line(a: float = 1.0) -> SDE:
    return SDE(
        drift=lambda t, x: a * x,
        diffusion=lambda t, x: x[:, None],
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="made up",
    )


def curve() -> SDE:
    return line()


def bug(kind="plain", problem="line", equivalent=""):
    return Planted(bug=f"a {kind} bug", scheme=Bad(kind), problem=problem, equivalent=equivalent)


@pytest.fixture
def registry_of():
    """Make a registry of the scheme good, the problems line and curve, two measures and some planted bugs."""

    def make(*bugs):
        return Registry(
            {
                SCHEMES: {"good": Registered("good", (Good(),), HERE)},
                PROBLEMS: {family.__name__: Registered(family.__name__, (family,), HERE) for family in (line, curve)},
                MEASURES: {
                    measure.name: Registered(measure.name, (measure,), HERE) for measure in (Blunt(), Sharp())
                },
                "sdaeverify_planted": {b.label: Registered(b.label, (b,), HERE) for b in bugs},
            }
        )

    return make


@pytest.fixture
def result_of():
    """Make the result of a cell of the measure sharp with one finding on the claim."""

    def make(scheme, verdict, tier=1, problem=line, measure=None):
        claim = None if verdict in {Verdict.NOT_APPLICABLE, Verdict.ERROR} else CLAIM
        finding = Finding(
            quantity="x", verdict=verdict, reason=Reason(f"{verdict} by tier {tier}"), claim=claim, tier=tier
        )
        return CellResult(Cell(scheme, problem_spec(problem), measure or Sharp()), (finding,), seconds=0.5)

    return make
