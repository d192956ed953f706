"""Schemes that claim nothing of paths are held to the law of dx = S dW, and to all of it."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from averaged_noise import LeimkuhlerMatthews
from facade import H, StochasticTheta, double_well, exactness_violation, law_error, ou, violation
from sdaeverify import SDE, Array, Claim, DelaySDAE, DelayState, Increment, Scheme, Step, verify

WEAK = (Claim(measure="weak", value=1.0, source="made up"),)
STRONG = (Claim(measure="strong", value=0.5, source="made up"),)
NOISE = np.array([[0.7, -0.3], [0.2, 0.9]])


@dataclass(frozen=True)
class Kicked(Scheme):
    """Euler-Maruyama with the noise of a rule."""

    rule: Any

    name: ClassVar[str] = "kicked"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = WEAK

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        kick = problem.diffused(t, state, self.rule(noise.dW))
        return Step(state + h * problem.drift(t, state) + kick)


class StronglyKicked(Kicked):
    """The same with a claim about its paths."""

    name: ClassVar[str] = "strongly-kicked"
    claims: ClassVar[tuple[Claim, ...]] = STRONG


class StrongLeimkuhlerMatthews(LeimkuhlerMatthews):
    """The method with a claim about its paths."""

    name: ClassVar[str] = "strong-leimkuhler-matthews"
    claims: ClassVar[tuple[Claim, ...]] = STRONG


@pytest.mark.sweep
@pytest.mark.parametrize("problem", [ou(), double_well()])
def test_a_scheme_that_is_right_in_law_alone_is_let_pass(problem: SDE) -> None:
    """The method of Leimkuhler and Matthews is half an increment off on each path, and claims nothing of paths."""
    assert violation(LeimkuhlerMatthews(), problem) == ""


def test_claims_about_paths_are_held_to_paths() -> None:
    """The same method with a strong order is refuted."""
    assert "after 8 steps" in exactness_violation(StrongLeimkuhlerMatthews())


@pytest.mark.parametrize("strength", [1.005, 0.995, 2.0])
def test_a_wrong_variance_is_refuted_by_law(strength: float) -> None:
    """One per cent of the variance is seen, although the first step lacks three quarters of its own."""
    text = exactness_violation(LeimkuhlerMatthews(strength))

    assert f"the covariance after many steps is off by {abs(strength**2 - 1.0):.1g}" in text
    assert "on dx = S dW" in text


EQUAL = {
    "swapped": lambda dW: dW[::-1],
    "reflected": lambda dW: -dW,
    "one reflected": lambda dW: dW * [[1.0], [-1.0]],
}
UNLIKE = {
    "used twice": lambda dW: np.broadcast_to(dW[:1], dW.shape),
    "forgotten": lambda dW: 0.0 * dW,
    "in part": lambda dW: dW * [[1.0], [0.99]],
}


@pytest.mark.parametrize("rule", EQUAL)
def test_noise_of_the_same_law_is_let_pass(rule: str) -> None:
    """S dW has the law of S O dW with an orthogonal O; a scheme with a claim about paths has to know which it is."""
    assert exactness_violation(Kicked(EQUAL[rule])) == ""
    assert "after 8 steps" in exactness_violation(StronglyKicked(EQUAL[rule]))


@pytest.mark.parametrize("rule", UNLIKE)
def test_noise_of_another_law_is_refuted(rule: str) -> None:
    """Every entry of the covariance counts."""
    assert "the covariance after many steps is off by" in exactness_violation(Kicked(UNLIKE[rule]))


def test_the_law_of_a_linear_run_is_known_without_sampling() -> None:
    """With half the noise the covariance grows by a quarter, to rounding; nothing is known of |dW|."""
    trivial = SDE.trivial_problems()[2][0]

    half, unknown = (law_error(Kicked(rule), trivial, H) for rule in (lambda dW: 0.5 * dW, np.abs))

    assert half is not None
    covariance = NOISE @ NOISE.T
    expected = 0.75 * np.abs(covariance).max() / np.diag(covariance).max()
    assert half.share == pytest.approx(expected, rel=1e-12)
    assert half.quantity == "the covariance"
    assert unknown is None


def test_areas_are_noise_as_well() -> None:
    """A weak scheme that adds H, of variance h/12, has too much variance by a twelfth."""

    class Areas(Kicked):
        noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})

        def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
            """Make one step."""
            return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW + noise.H))

    trivial = SDE.trivial_problems()[2][0]

    found = law_error(Areas(None), trivial, H)

    assert found is not None
    covariance = NOISE @ NOISE.T
    expected = np.abs(covariance).max() / np.diag(covariance).max() / 12.0
    assert found.share == pytest.approx(expected, rel=1e-12)


@dataclass(frozen=True)
class Delayed(StochasticTheta):
    """The theta method with noise turned round or too strong, and no claim about its paths."""

    factor: float = -1.0

    name: ClassVar[str] = "planted-delayed-law"
    form: ClassVar[tuple[type[DelaySDAE], ...]] = (DelaySDAE,)
    claims: ClassVar[tuple[Claim, ...]] = WEAK

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Those of weak order."""
        return self.claims

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=self.factor * noise.dW))


@pytest.mark.long
def test_delay_equations_have_a_law_as_well() -> None:
    """With a delay, too, -W is as good as W in law, and one per cent of the variance is seen."""
    assert exactness_violation(Delayed(0.5)) == ""
    assert "the covariance after many steps is off by 0.01" in exactness_violation(Delayed(0.5, factor=1.005))


@pytest.mark.long
def test_what_is_right_in_law_is_verified_and_what_is_wrong_refuted() -> None:
    """On the Ornstein-Uhlenbeck process its weak order is found by moments, its memory being part of the state."""
    verdicts = verify(
        [LeimkuhlerMatthews(), LeimkuhlerMatthews(1.005)], "ou", "weak", paths=200, block=200, max_looks=1
    ).verdicts.set_index("scheme")

    right, wrong = verdicts.loc["leimkuhler-matthews"], verdicts.loc["leimkuhler-matthews[strength=1.005]"]
    assert set(right.verdict) == {"verified"}
    assert right.reason.str.startswith("Weak order 1.00 at T by moment equations").all()
    assert wrong.verdict == "refuted"
    assert "the covariance after many steps is off by 0.01" in wrong.reason
