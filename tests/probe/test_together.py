"""Steps of many times and sizes in one call: the same bits as one by one, whatever a step makes of arrays."""

from typing import Any

import numpy as np
import pytest

from facade import PathBatch, odd_step
from facade import together as in_few_calls
from probe.weak_cells import equation, euler, scheme
from sdaeverify import SDE, Array, Increment, Step
from sdaeverify.probing import OneStep

MOVING = equation(lambda t, x: 0.5 * x + np.sin(t), lambda t, x: 0.6 * x[:, None], [1.0])
STILL = equation(lambda t, x: 0.5 * x, lambda t, x: 0.6 * x[:, None], [1.0])
COUNT, PATHS = 24, 3
# The first batch, the last and one in between are made alone, beside the call with arrays.
CALLS = 4


def offset(of: Any) -> Any:
    """Return an Euler step that is off by what a function makes of t and h."""

    def rule(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
        return euler(p, x, t, h, n) + 1e-3 * of(t, h)

    return rule


def branching(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
    return euler(p, x, t, h, n) if h < 0.01 else x


def calling_float(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
    return euler(p, x, float(t), float(h), n)


def failing(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
    if np.ndim(h):
        raise RuntimeError("h is a float")
    return euler(p, x, t, h, n)


ALONE = {
    "the largest time": offset(lambda t, h: np.max(t)),
    "the mean size": offset(lambda t, h: np.mean(h)),
    "the smallest size": offset(lambda t, h: np.min(h)),
    "whether any step is short": offset(lambda t, h: np.any(np.less(h, 1e-2))),
    "whether all are": offset(lambda t, h: np.all(np.less(h, 1e-2))),
    "a branch": branching,
    "a float": calling_float,
    "an error on arrays": failing,
}


def batches() -> list[PathBatch]:
    """Return batches of many times and sizes."""
    rng = np.random.default_rng(1)
    sizes = np.geomspace(0.1, 1e-4, COUNT).tolist()
    return [
        PathBatch(
            rng.uniform(0.5, 2.0, (1, PATHS)), place / COUNT, h, Increment(rng.normal(size=(1, PATHS)) * h**0.5, None)
        )
        for place, h in enumerate(sizes)
    ]


class Counted:
    """A map that counts its calls."""

    def __init__(self, step: OneStep) -> None:
        self.step, self.calls = step, 0

    def __call__(self, x: Array, t: Any, h: Any, noise: Increment) -> Step:
        self.calls += 1
        return self.step.make(x, t, h, noise)


def bits(step: Step) -> bytes:
    return np.ascontiguousarray(step.state).tobytes()


def test_arithmetic_on_arrays_is_asked_in_few_calls():
    """A step that is arithmetic goes to the same place to the last bit, in four calls."""
    counted = Counted(OneStep(scheme(euler), MOVING))
    found = [*in_few_calls(counted, batches())]

    assert counted.calls == CALLS
    assert [bits(made) for made in found] == [bits(counted.step.make(*each)) for each in batches()]


@pytest.mark.parametrize("rule", ALONE.values(), ids=ALONE)
def test_a_step_that_looks_at_all_times_or_sizes_is_made_one_by_one(rule):
    """What a step makes of one time and one size counts, not what it makes of all of them."""
    counted = Counted(OneStep(scheme(rule), MOVING))
    found = [*in_few_calls(counted, batches())]

    assert counted.calls > COUNT
    assert [bits(made) for made in found] == [bits(counted.step.make(*each)) for each in batches()]


def test_what_a_step_raises_passes_through():
    """An error is that of the batch it was made of."""

    def late(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
        if np.any(np.greater(t, 0.5)):
            raise ValueError("too late")
        return euler(p, x, t, h, n)

    with pytest.raises(ValueError, match="too late"):
        [*in_few_calls(OneStep(scheme(late), MOVING).make, batches())]


def test_paths_of_a_call_are_bounded():
    """Batches that are long themselves are made one by one."""
    long = [PathBatch(np.ones((1, 5000)), 0.1 * n, 0.1, Increment(np.zeros((1, 5000)), None)) for n in range(6)]
    counted = Counted(OneStep(scheme(euler), MOVING))

    assert len([*in_few_calls(counted, long)]) == counted.calls == 6


@pytest.mark.parametrize("rule", [euler, branching], ids=["arrays", "a branch"])
def test_a_row_of_steps_is_judged_alike(rule):
    """A step that takes no arrays is unlike its neighbours where one that takes them is."""

    def odd(p: SDE, x: Array, t: Any, h: float, n: Increment) -> Array:
        return rule(p, x, t, h, n) + (np.abs(t - 0.5) < 0.004) * 1e-3

    assert odd_step(OneStep(scheme(odd), STILL)) == pytest.approx(0.5, abs=0.01)
    assert odd_step(OneStep(scheme(rule), STILL)) is None
