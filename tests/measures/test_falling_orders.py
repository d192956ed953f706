"""An order that short steps have lost is not taken for one that still rises to the claim."""

from typing import ClassVar

import numpy as np
import pytest

from facade import EulerMaruyama, HeunAdditive, Milstein
from sdaeverify import SDE, Array, Increment, Scheme, Step, verify
from sdaeverify.measuring import Verdict


class ShortEuler(Milstein):
    """Milstein's scheme, which makes Euler's step if h is below a bound."""

    name: ClassVar[str] = "short-euler"
    below: ClassVar[float] = 1e-4

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; h may be an array over paths."""
        right, wrong = (scheme.step(problem, state, t, h, noise).state for scheme in (super(), EulerMaruyama()))
        return Step(np.where(np.asarray(h) < self.below, wrong, right))


class NeverEuler(ShortEuler):
    """Milstein's scheme."""

    name: ClassVar[str] = "never-euler"
    below: ClassVar[float] = 0.0


@pytest.mark.parametrize(("scheme", "verdict"), [(ShortEuler(), None), (NeverEuler(), Verdict.VERIFIED)])
def test_an_order_that_falls_at_short_steps_is_not_verified_by_paths(scheme: Scheme, verdict: Verdict | None) -> None:
    """One step has the order 1 down to h = 1e-4 and 1/2 below; paths have longer steps."""
    table = verify([scheme], "gbm", "strong", paths=1024).verdicts
    found = set(table[(table.scheme == scheme.name) & (table.claim != "")].verdict)

    assert found == {verdict} if verdict else Verdict.VERIFIED not in found


class ShortHeun(HeunAdditive):
    """Heun's scheme for additive noise, which makes Euler's step if h is below a bound."""

    name: ClassVar[str] = "short-heun"
    below: ClassVar[float] = 1e-2

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; h may be an array over paths."""
        right, wrong = (scheme.step(problem, state, t, h, noise).state for scheme in (super(), EulerMaruyama()))
        return Step(np.where(np.asarray(h) < self.below, wrong, right))


class NeverEulerHeun(ShortHeun):
    """Heun's scheme for additive noise."""

    name: ClassVar[str] = "never-euler-heun"
    below: ClassVar[float] = 0.0


@pytest.mark.parametrize(
    ("scheme", "verdict"), [(ShortHeun(), Verdict.INCONCLUSIVE), (NeverEulerHeun(), Verdict.VERIFIED)]
)
def test_an_order_of_stationary_means_has_to_hold_at_a_short_step(scheme: Scheme, verdict: Verdict) -> None:
    """The operator has step sizes down to 1/64, at which the order is 2, and one of 1/4096."""
    table = verify([scheme], "ou", "invariant", paths=1024).verdicts
    found = table[(table.scheme == scheme.name) & (table.claim != "")]

    assert set(found.verdict) == {verdict}
    falls = found.reason.str.contains("0.00024 the error of the stationary mean falls")
    assert falls.all() == (verdict is Verdict.INCONCLUSIVE)
