"""Times at which a step is probed: one where nothing depends on time, more where something does."""

from typing import Any

import numpy as np
import pytest

from facade import (
    judge_strong,
    judge_weak,
    local_strong,
    local_weak,
    strata,
    strong_orders,
    times,
    weak_order,
)
from probe.weak_cells import equation, euler, scheme
from sdaeverify import SDE, Array, Increment
from sdaeverify.measuring import Verdict
from sdaeverify.probing import OneStep, cloud

STILL = equation(lambda t, x: 0.5 * x, lambda t, x: 0.6 * x[:, None], [1.0])
MOVING = equation(lambda t, x: 0.5 * x + np.sin(t), lambda t, x: 0.6 * x[:, None], [1.0])


def late(p: SDE, x: Array, t: float, h: float, n: Increment, *, begin: float = 0.5, end: float = 2.0) -> Array:
    """Return an Euler step with one per cent too much drift for some of the time."""
    return euler(p, x, t, h, n) + (begin < t <= end) * 0.01 * h * x


def found(formula: Any, problem: SDE, **parameters: float) -> tuple[float, ...]:
    step = OneStep(scheme(formula, **parameters), problem)
    return tuple(moment.t for moment in times(step, cloud(problem, step.equation)) if moment.place is None)


@pytest.mark.parametrize(
    ("formula", "problem", "parameters", "inside"),
    [
        (late, STILL, {}, (0.5, 1.0)),
        (late, STILL, {"begin": 0.9}, (0.9, 1.0)),
        (late, STILL, {"begin": 0.61, "end": 0.67}, (0.61, 0.67)),
        (late, MOVING, {"begin": 0.61, "end": 0.67}, (0.61, 0.67)),
        (late, STILL, {"begin": 0.1, "end": 0.3}, (0.0, 0.1)),
    ],
    ids=["from half on", "at the end", "a window", "a window in a moving equation", "around the one time"],
)
def test_times(formula, problem, parameters, inside):
    """A time is taken at which the step is unlike the one near 0.2, wherever that is."""
    first, *others = found(formula, problem, **parameters)
    assert first == 26 / 128
    if inside[0] > 0.0:
        assert any(inside[0] < t <= inside[1] for t in others)
    assert 1 <= len(others) <= 2


@pytest.mark.parametrize(("problem", "count"), [(STILL, 1), (MOVING, 3)])
def test_times_of_a_right_step(problem, count):
    """One time is enough where nothing depends on it, and where something does, two more are taken."""
    assert len(found(euler, problem)) == count


@pytest.mark.parametrize("horizon", [0.3, 1.0, 16.0, 100.0])
def test_no_stretch_of_the_horizon_is_left_out(horizon):
    """Of a longer horizon there is a time in each of 32 parts; of a shorter one, they are a 32nd of it apart."""
    _, *others = strata(horizon)
    gaps = np.diff([0.0, *others, horizon])
    assert max(gaps) <= horizon / 16.0 + 1e-12


def test_a_right_step_is_verified_at_all_times():
    """Euler-Maruyama has its orders on an equation that depends on time."""
    right = scheme(euler)

    assert judge_strong(strong_orders(local_strong(right, MOVING))[-1], 0.5).verdict is Verdict.VERIFIED
    assert judge_weak(weak_order(local_weak(right, MOVING)), 1.0).verdict is Verdict.VERIFIED
