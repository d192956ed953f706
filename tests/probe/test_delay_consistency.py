"""Consistency of one step given its past, Definition 3.1."""

from typing import Any, ClassVar

import numpy as np
import pytest

from facade import (
    DelayConsistency,
    StochasticTheta,
    average_given_past,
    consistency_order,
    delay_consistency,
    delay_ou,
    delay_test,
    half_steps,
    local_strong,
    remove_delay,
    strong_orders,
    why_not_delay_consistency,
)
from sdaeverify import THREE_POINT, DelaySDAE, Scheme, Step
from sdaeverify.probe.step.nodes import product_rule
from sdaeverify.probing import OneStep


def forced(noises: int = 1, horizon: float = 2.0) -> DelaySDAE:
    """Return dx = sin(3 t) dt + sum dW, with a delay that does not matter."""
    return DelaySDAE(
        drift=lambda t, x, v, y: np.sin(3.0 * t) + 0.0 * x,
        diffusion=lambda t, x, v, y: np.ones((1, noises, 1)),
        delay=horizon / 2.0,
        history=lambda t: [1.0],
        noise_dim=noises,
        horizon=horizon,
        source="test",
    )


class Midpoint(Scheme):
    """The drift in the middle of the step."""

    name: ClassVar[str] = "midpoint"
    form: ClassVar[type] = DelaySDAE
    source: ClassVar[str] = "test"

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Any) -> Step:
        """Make one step."""
        drift = problem.drift(t + 0.5 * h, state.x, noise.lagged, state.y)
        return Step(state._replace(x=state.x + h * drift + noise.dW.sum(axis=0)))


class WithAreas(Midpoint):
    """A scheme that uses H."""

    name: ClassVar[str] = "with-areas"
    noise: ClassVar[frozenset] = frozenset({"dW", "H"})


class OfAtoms(Midpoint):
    """A scheme with a discrete law."""

    name: ClassVar[str] = "of-atoms"
    law: ClassVar = THREE_POINT


@pytest.mark.sweep
@pytest.mark.parametrize("name", ["I", "II", "IV"])
@pytest.mark.parametrize("theta", [0.0, 1.0])
def test_the_theta_method_is_consistent_of_order_one_half(name: str, theta: float) -> None:
    """Theorem 3.1."""
    order = consistency_order(delay_consistency(StochasticTheta(theta=theta), delay_test(name)))
    assert order == pytest.approx(0.5, abs=0.03)


def test_the_past_alone_limits_it_where_noise_is_additive() -> None:
    """Given its past a step is off by h^(3/2) in the mean; over the past, too, it is of order 1."""
    scheme, problem = StochasticTheta(theta=0.0), delay_ou()
    record = delay_consistency(scheme, problem)
    assert consistency_order(record) == pytest.approx(0.5, abs=0.01)
    last = np.log(record.mean.max(axis=0)[-2:])
    assert np.diff(last) / np.diff(np.log(record.h[-2:])) == pytest.approx(1.5, abs=0.01)
    assert strong_orders(local_strong(*remove_delay(scheme, problem)))[0].order == pytest.approx(1.0, abs=0.01)


def test_an_inconsistent_step_has_order_zero_or_less() -> None:
    """Defects of order h, which steps add up to order 0."""
    h = 2.0 ** -np.arange(4.0, 11.0)
    sizes = np.ones((3, 1)) * h
    record = DelayConsistency(h, sizes, sizes, np.ones((3, len(h))))
    assert consistency_order(record) == pytest.approx(0.0, abs=1e-12)


def test_half_steps_begin_one_after_the_other() -> None:
    """The midpoint rule has order 3 in one step: its order is 2, which no other time of the second half gives."""
    record = delay_consistency(Midpoint(), forced())

    assert consistency_order(record) == pytest.approx(2.0, abs=0.01)
    assert record.mean == pytest.approx(record.rms)
    # One step minus two half steps is h^3 f''/32, and f'' is 9 sin(3 t).
    time, h = OneStep(*remove_delay(Midpoint(), forced())).time + forced().delay, record.h[-1]
    assert record.rms[0, -1] == pytest.approx(9.0 * abs(np.sin(3.0 * time)) * h**3 / 32.0, rel=0.05)


def test_step_sizes_are_parts_of_the_unit_of_time() -> None:
    """Of a shorter one on a shorter horizon."""
    long, short = (delay_consistency(Midpoint(), forced(horizon=horizon)).h for horizon in (2.0, 0.25))

    assert short[0] < long[0]
    assert np.diff(np.log2(long)) == pytest.approx(np.diff(np.log2(short)))


@pytest.mark.parametrize("noises", [1, 2])
def test_means_are_over_the_present_noise_alone(noises: int) -> None:
    """What depends on the past stays, an odd part of the present noise vanishes, and a square has its mean."""
    whole = half_steps(2 * noises, 3 if noises == 2 else 5, rule=product_rule)
    now, past = np.split(whole.first.dW, 2)
    value = past[0] + 2.0 * now[-1] + now[0] ** 2

    means, shares = average_given_past(value[None, None], whole.whole.weights, noises)

    assert shares.sum() == pytest.approx(1.0)
    assert len(shares) ** 2 == len(value)
    assert (means @ shares).item() == pytest.approx(0.5)
    assert ((means[0, 0] - 0.5) ** 2 @ shares).item() == pytest.approx(0.5)


def test_noise_other_than_few_brownian_motions_has_no_nodes() -> None:
    """A rule for the past and the present of three motions would have half a million."""
    assert [why_not_delay_consistency(Midpoint(), forced(noises)) for noises in (1, 2)] == ["", ""]
    assert "too many dimensions" in why_not_delay_consistency(Midpoint(), forced(3))
    for scheme in (WithAreas(), OfAtoms()):
        assert "with Brownian increments only" in why_not_delay_consistency(scheme, forced())
