"""Exactness with a delay: trivial delay equations are what they say, and wrong lagged values do not pass."""

from typing import ClassVar

import numpy as np
import pytest

from facade import (
    AnticipatingNoise,
    H,
    KeptAlgebraic,
    Mesh,
    OldLagAlgebraic,
    StochasticTheta,
    WrongLag,
    exactness_violation,
)
from sdaeverify import Claim, DelaySDAE, DelayState, Increment, Scheme, Step, Trivial
from sdaeverify.forms.delay.trivial_delays import LONG
from sdaeverify_schemes._euler_orders import STRONG_HALF

# Where each of the wrong readings is found: what leaves out a part of the unknown misses even what is at rest.
MOVING = "dx = c dt, y = x(t - tau)"
WHERE = {"behind": MOVING, "present": MOVING, "swapped": MOVING, "known": "dx = 0, y = x(t - tau)"}
EVERY = [trivial for variants in DelaySDAE.trivial_problems() for trivial in variants]


class PresentDrift(StochasticTheta):
    """The drift reads x in the place of the lagged x, y and the noise do not."""

    name: ClassVar[str] = "planted-present-drift"
    form: ClassVar[tuple[type[DelaySDAE], ...]] = (DelaySDAE,)
    claims: ClassVar[tuple[Claim, ...]] = STRONG_HALF

    def refuses(self, problem: DelaySDAE) -> str:
        """Refuse problems without y."""
        return "" if problem.constraints else "the problem has no algebraic component"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make an explicit step."""
        (x, y), lag = state, problem.lag(state.x, h, noise)
        new = x + h * problem.drift(t, x, x, y) + problem.diffused(t, x, lag.now, y, noise.dW)
        return Step(DelayState(new, problem.eliminated(t + h, new, lag.ahead(new))))


class OldOnTheMesh(StochasticTheta):
    """Where the delay is a whole number of steps, the lagged value of the step's begin is that of its end."""

    name: ClassVar[str] = "planted-old-on-the-mesh"
    form: ClassVar[tuple[type[DelaySDAE], ...]] = (DelaySDAE,)

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        m, delta = problem.mesh(h)
        return super().step(problem, state, t, h, noise if delta or not m else noise._replace(ahead=noise.lagged))


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize("reading", WHERE)
def test_wrong_lagged_values_at_the_end_are_found(reading: str) -> None:
    """On a line a lagged value is known, and y repeats it: another one is off by a fixed part of the motion."""
    assert exactness_violation(WrongLag(0.5, reading)).partition(" on ")[2].startswith(WHERE[reading])


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize(
    ("wrong", "equation"),
    [
        (KeptAlgebraic(), "dx = 0, y = x(t - tau) + s t"),
        (OldLagAlgebraic(), "dx = c dt, y = x(t - tau)"),
        (PresentDrift(), "dx = c dt, y = x(t - tau)"),
        (OldOnTheMesh(), "dx = c dt, y = x(t - tau)"),
    ],
)
def test_other_faults_are_named(wrong: Scheme, equation: str) -> None:
    """A wrong y and a wrong lagged value are found on the equation that shows them."""
    assert f"on {equation}" in exactness_violation(wrong)


class Forgetful(PresentDrift):
    """All coefficients and y read x in the place of the lagged x."""

    name: ClassVar[str] = "planted-forgetful"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make an explicit step."""
        x, y = state
        new = x + h * problem.drift(t, x, x, y) + problem.diffused(t, x, x, y, noise.dW)
        return Step(DelayState(new, problem.eliminated(t + h, new, new)))


class OldAtTheEnd(PresentDrift):
    """y at the end of an explicit step reads the lagged x of its begin."""

    name: ClassVar[str] = "planted-old-at-the-end"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make an explicit step."""
        (x, y), now = state, problem.lag(state.x, h, noise).now
        new = x + h * problem.drift(t, x, now, y) + problem.diffused(t, x, now, y, noise.dW)
        return Step(DelayState(new, problem.eliminated(t + h, new, now)))


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (Forgetful(), "; no step depends on x(t - tau), so that it solves an equation without delay"),
        (OldAtTheEnd(), "; no step depends on x(t + h - tau), which y at its end follows"),
        (PresentDrift(), "the solution moves by 0.11"),
        (OldLagAlgebraic(), "the solution moves by 0.11"),
    ],
)
def test_a_lagged_value_that_no_step_reads_is_named(wrong: Scheme, told: str) -> None:
    """The message of a step that reads the lagged values of begin and end has no such words."""
    assert exactness_violation(wrong).endswith(told)


class WrongOutput(PresentDrift):
    """x is right, and twice y is returned, which no step reads."""

    name: ClassVar[str] = "planted-wrong-output"

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make an explicit step."""
        x, lag = state.x, problem.lag(state.x, h, noise)
        y = problem.eliminated(t, x, lag.now)
        new = x + h * problem.drift(t, x, lag.now, y) + problem.diffused(t, x, lag.now, y, noise.dW)
        return Step(DelayState(new, 2.0 * problem.eliminated(t + h, new, lag.ahead(new))))


def test_the_component_that_is_wrong_is_named() -> None:
    """Components that are right to rounding are not in the message."""
    assert ": error 1 of y after 8 steps" in exactness_violation(WrongOutput())


@pytest.mark.parametrize("wrong", [WrongLag(0.5, "ahead"), AnticipatingNoise()])
def test_errors_that_vanish_with_the_step_are_let_pass(wrong: Scheme) -> None:
    """A lagged value of the step's end at its begin alone is a matter of order."""
    assert exactness_violation(wrong) == ""


@pytest.mark.parametrize("trivial", EVERY, ids=lambda trivial: trivial.name)
def test_trivial_delay_problems_are_solved_by_their_solution(trivial: Trivial) -> None:
    """Along the solution the constraint holds, and drift and noise are those of straight lines or of W."""
    problem, rng, paths = trivial.problem, np.random.default_rng(3), 4
    W = rng.standard_normal((problem.noise_dim, paths))
    t, noisy = 0.2, "dW" in trivial.name
    now = trivial.solution(t, W)
    past = trivial.solution(t - problem.delay, W)["x"]
    y = now.get("y", now["x"][:0])
    later = trivial.solution(t + 1.0, W)["x"]

    np.testing.assert_allclose(problem.drift(t, now["x"], past, y), later - now["x"], atol=1e-14)
    B = problem.diffusion(t, now["x"], past, y)
    step = trivial.solution(t, 2.0 * W)["x"] - now["x"]
    np.testing.assert_allclose(
        np.einsum("dlP,lP->dP", np.broadcast_to(B, (len(step), *W.shape)), W), step, atol=1e-14
    )
    assert noisy is bool(np.abs(step).max() > 0.0)
    for value, scale in problem.residuals({**now, "lagged": past, "t": np.full((1, paths), t)}).values():
        assert np.all(np.abs(value) <= 1e-15 * (1.0 + scale))
    for name, value in trivial.solution(0.0, 0.0 * W).items():
        np.testing.assert_allclose(value, problem.parts(problem.initial(paths))[name], rtol=1e-15)


def test_trivial_delays_lie_on_every_kind_of_mesh() -> None:
    """One reaches back over several steps, one to a mesh point, one over a part of a step; one is none, one stays."""
    kinds = {3: 0.3, 2: 0.0, 1: 0.7, 0: 0.0}
    for trivials, long in (([(each, H) for each in EVERY], 11), ([each.short_run for each in EVERY], 10957)):
        meshes = dict(Mesh.of(trivial.problem.delay, h) for trivial, h in trivials)
        assert meshes == pytest.approx({**kinds, long: Mesh.of(LONG, trivials[-1][1]).delta})
