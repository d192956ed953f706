"""Whether the law of single steps is the equation's, in every stretch of a run and whatever noise a step declares."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from facade import (
    LAW,
    MALA,
    SCREENING,
    Entry,
    EulerMaruyama,
    LawResolution,
    MilsteinAreas,
    Strong,
    Task,
    Weak,
    departure,
    double_well,
    gbm,
    noncommuting,
    problem_spec,
    run_block,
    step_law,
    step_resolution,
)
from sdaeverify import SDE, Array, Claim, Increment, Scheme, Settings, Step
from sdaeverify.measuring import Evidence, Tally, unpacked

CLAIMS = tuple(Claim(measure=name, value=value, source="made up") for name, value in (("strong", 0.5), ("weak", 1.0)))
# What factor the drift and the noise of a step at state x and time t have.
Factors = Callable[[Array, float], tuple[Any, Any]]


@dataclass(frozen=True)
class Factored(Scheme):
    """Euler-Maruyama with a wrong factor at drift and noise."""

    factors: Factors = lambda x, t: (1.0, 1.0)

    name: ClassVar[str] = "factored"
    form: ClassVar[type] = SDE
    claims: ClassVar = CLAIMS

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        x, (drift, strength) = state, self.factors(state, t)
        return Step(x + h * drift * problem.drift(t, x) + strength * problem.diffused(t, x, noise.dW))


class SignOnly(EulerMaruyama):
    """Euler-Maruyama that is driven by sqrt(h) times the sign of the increment: right in law."""

    name: ClassVar[str] = "sign-only"
    discontinuous_in_noise: ClassVar[bool] = True

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        return super().step(problem, state, t, h, noise._replace(dW=np.sqrt(h) * np.sign(noise.dW)))


def test_a_step_that_jumps_rightly_is_let_pass() -> None:
    """What is rejected by fewer and fewer steps is no error of the limit."""
    assert not departure(MALA(), double_well())
    law = step_law(MALA(), double_well())
    assert law is not None
    assert law.points > 500
    assert law.rate_error < 1e-3


def test_a_step_for_which_nodes_are_no_rule_is_let_pass() -> None:
    """Signs of the increments have variance 1, and not so at nodes one of which is 0: two rules do not agree."""
    assert not departure(SignOnly(), gbm())


def test_resolution_is_above_what_was_not_seen() -> None:
    """An error below what is asked of is larger than none, and no larger than the resolution that is told."""
    for size in (1e-5, 3e-5):
        law = step_law(Factored(lambda x, t, size=size: (1.0, 1.0 + size)), gbm())
        assert law is not None
        assert not law.departure
        assert size <= law.rate_error * 1.01 + 1e-12


def test_areas_are_given_to_steps_that_use_them() -> None:
    """Milstein's scheme with areas follows the equation."""
    law = step_law(MilsteinAreas(), noncommuting())
    assert law is not None
    assert not law.departure


def test_resolution_is_evidence_of_strong_and_weak_cells() -> None:
    """Whoever judges can ask at how many times steps were compared, and how sharply: no gap is larger than that."""
    scheme, problem = EulerMaruyama(), gbm()
    task = Task(problem_spec(gbm), (Entry(scheme, (Strong(), Weak())),), Settings(), screened=True)
    (found_on_scheme,) = run_block(task, SCREENING)
    for tally in found_on_scheme.probes:
        found = unpacked(LAW, LawResolution, tally)
        assert found is not None
        law = step_law(scheme, problem)
        assert law is not None
        gaps = np.diff([0.0, *np.unique(law.t), problem.horizon])
        assert found.times == 32
        assert 0.0 < found.rate_error < 1e-4
        resolution = step_resolution(Evidence(scheme, problem, problem, Settings(), tally, Tally()))
        assert gaps.max() < resolution < 0.15
