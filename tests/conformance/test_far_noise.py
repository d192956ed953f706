"""Whether a short step follows its noise, however rare and of however many motions."""

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
import pytest

from facade import (
    MALA,
    EulerMaruyama,
    delay_growing,
    double_well,
    four_motions,
    gbm,
    law_departure,
    load_registry,
    match,
    noise_departure,
    noncommuting,
    select_schemes,
)
from sdaeverify import SDE, THREE_POINT, Array, Claim, Increment, Law, Scheme, Step, verify

# What a step makes of its noise, in standard deviations, given the step size.
Heard = Callable[[Array, float], Array]


def hear(heard: Heard, noise: Increment, h: float) -> Increment:
    """Return noise with other increments."""
    return noise._replace(dW=np.sqrt(h) * heard(noise.dW / np.sqrt(h), h))


class Hearing(EulerMaruyama):
    """Euler-Maruyama driven by a function of its increments."""

    name: ClassVar[str] = "hearing"
    heard: ClassVar[Heard]
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source="made up"),
        Claim(measure="weak", value=1.0, source="made up"),
    )

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, hear(type(self).heard, noise, h))


class Discrete(Hearing):
    """The same with discrete increments."""

    name: ClassVar[str] = "discrete"
    law: ClassVar[Law] = THREE_POINT
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=1.0, source="made up"),)


def hearing(heard: Heard, base: type[Hearing] = Hearing) -> Scheme:
    """Return the scheme that is driven by a function of its increments."""
    return type("Heard", (base,), {"heard": staticmethod(heard)})()


def beyond(size: float, factor: float) -> Heard:
    """Return that increments beyond a size are multiplied with a factor."""
    return lambda xi, h: np.where(np.abs(xi) > size, factor, 1.0) * xi


def clipped(size: float) -> Heard:
    """Return that increments are clipped at a size."""
    return lambda xi, h: np.clip(xi, -size, size)


def clipped_by_h(p: float) -> Heard:
    """Return that increments are clipped at sqrt(2 p ln(1/h))."""
    return lambda xi, h: clipped(np.sqrt(-2.0 * p * np.log(h)))(xi, h)


def shortened_by_h(p: float) -> Heard:
    """Return that the vector of l increments is no longer than sqrt(l) + sqrt(2 p ln(1/h))."""

    def heard(xi: Array, h: float) -> Array:
        most = np.sqrt(len(xi)) + np.sqrt(-2.0 * p * np.log(h))
        return np.asarray(xi * np.minimum(1.0, most / np.linalg.norm(xi, axis=0)))

    return heard


def last_only(heard: Heard) -> Heard:
    """Return that the last motion alone is heard otherwise."""
    return lambda xi, h: np.concatenate([xi[:-1], heard(xi[-1:], h)])


def many(motions: int) -> SDE:
    """Return an equation in the plane with a column of noise for each motion."""
    angles = np.arange(motions)
    B = np.stack([np.cos(angles), np.sin(angles)])[..., None] / np.sqrt(motions)
    return SDE(
        drift=lambda t, x: -x,
        diffusion=lambda t, x: B * (1.0 + 0.1 * np.cos(x[:1])),
        start=[1.0, 0.5],
        noise_dim=motions,
        horizon=1.0,
        source="made up",
    )


WRONG = {
    "dropped from 2.5 on": beyond(2.5, 0.0),
    "dropped from 3.5 on": beyond(3.5, 0.0),
    "of the other sign from 2.5 on": beyond(2.5, -1.0),
    "1 per cent too large from 3 on": beyond(3.0, 1.01),
    "clipped at 2.5": clipped(2.5),
    "clipped at 4": clipped(4.0),
    # Drawn at random: a motion, a side, a size and a factor.
    "of the last motion, above 1.7, times 0.8": last_only(lambda xi, h: np.where(xi > 1.7, 0.8, 1.0) * xi),
    "between 0.4 and 0.6 times 1.02": lambda xi, h: np.where(np.abs(np.abs(xi) - 0.5) < 0.1, 1.02, 1.0) * xi,
}
RIGHT = {
    "all": lambda xi, h: xi,
    "clipped at sqrt(ln(1/h))": clipped_by_h(0.5),
    "clipped at sqrt(4 ln(1/h))": clipped_by_h(2.0),
    "no longer than sqrt(l) + sqrt(ln(1/h))": shortened_by_h(0.5),
    "tamed": lambda xi, h: xi / (1.0 + np.sqrt(h) * np.abs(xi)),
    "tamed slowly": lambda xi, h: xi / (1.0 + h**0.25 * xi**2),
}
PROBLEMS: dict[str, Any] = {
    "gbm": gbm,
    "noncommuting": noncommuting,
    "four": four_motions,
    "seven": lambda: many(7),
    "sixty": lambda: many(60),
}


def crossed(steps):
    """Return steps with problems: each step with one motion, the first with any number; the rest is long."""
    return [
        pytest.param(heard, problem, marks=() if problem == "gbm" or heard == next(iter(steps)) else pytest.mark.long)
        for heard in steps
        for problem in PROBLEMS
    ]


@pytest.mark.sweep
@pytest.mark.parametrize(("heard", "problem"), crossed(WRONG))
def test_noise_that_is_lost_at_some_size_is_found_for_any_number_of_motions(heard, problem):
    """The reason says from which size on, and at most 160 characters."""
    text = noise_departure(hearing(WRONG[heard]), PROBLEMS[problem](), paths=True)

    assert "of the noise at any h" in text
    assert len(text) <= 160


@pytest.mark.parametrize(("heard", "problem"), crossed(RIGHT))
def test_what_vanishes_with_the_step_size_is_let_pass(heard, problem):
    """Clipped at a bound that grows, or tamed: the largest difference from Euler's step falls."""
    assert noise_departure(hearing(RIGHT[heard]), PROBLEMS[problem](), paths=True) == ""


@pytest.mark.long
def test_nodes_of_one_size_do_not_show_what_is_lost():
    """From four motions on the rule of the step's law has all increments at the square root of 3."""
    wrong = hearing(beyond(2.5, 0.0))

    assert law_departure(wrong, four_motions()) == ""
    found = verify(wrong, "four-motions", ["strong", "weak"]).verdicts
    assert set(found.verdict) == {"refuted"}
    assert all("with noise of 2.5 to" in reason for reason in found.reason)


def test_a_claim_of_the_law_alone_is_held_to_the_law():
    """Signs of increments have the right mean squares, and dropped ones have not."""
    signs = hearing(lambda xi, h: np.sign(xi))
    flipped, dropped = (hearing(beyond(2.5, factor)) for factor in (-1.0, 0.0))

    for right in (flipped, signs):
        assert noise_departure(right, four_motions(), paths=False) == ""
        assert noise_departure(right, four_motions(), paths=True)
    assert noise_departure(dropped, four_motions(), paths=False)
    one_sided = hearing(lambda xi, h: np.where(xi > 2.5, -1.0, 1.0) * xi)
    assert noise_departure(one_sided, four_motions(), paths=False)


def test_discrete_increments_are_compared_at_their_values():
    """A right scheme is let pass; one that loses every fourth motion's larger value is not."""
    assert noise_departure(hearing(RIGHT["all"], Discrete), four_motions(), paths=False) == ""
    assert noise_departure(hearing(last_only(clipped(1.5)), Discrete), many(7), paths=False)


def test_steps_that_reject_less_and_less_are_let_pass():
    """A step that jumps as a function of its noise, but more rarely as h falls, loses none of it."""
    assert noise_departure(MALA(), double_well(), paths=True) == ""


def test_steps_with_a_delay_are_compared_without_it():
    """The noise of the past is one more motion each."""
    for heard, loses in ((RIGHT["all"], False), (WRONG["dropped from 2.5 on"], True)):
        (scheme,) = select_schemes(load_registry(), "stochastic-theta[theta=0]")
        wrong = _hearing_theta(scheme, heard)
        assert bool(noise_departure(wrong, match(wrong, delay_growing()).problem, paths=True)) is loses


def _hearing_theta(scheme: Scheme, heard: Heard) -> Scheme:
    def step(self, problem, state, t, h, noise):
        return super(kind, self).step(
            problem, state, t, h, noise._replace(dW=np.sqrt(h) * heard(noise.dW / np.sqrt(h), h))
        )

    kind = type("HearingTheta", (type(scheme),), {"name": "hearing-theta", "step": step})
    return kind(theta=0.0)
