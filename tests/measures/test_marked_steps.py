"""A scheme that marks each step as truncated, or each path as failed, is told that its order was never seen."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from sdaeverify import SDE, Claim, Scheme, Step, verify

CLAIMS = tuple(
    Claim(measure=measure, value=value, source="test")
    for measure, value in (("strong", 0.5), ("weak", 1.0), ("invariant", 1.0))
)


@dataclass(frozen=True)
class MarkedEuler(Scheme):
    """Euler-Maruyama, a part of the drift and a field of the step that marks every path."""

    drift: float = 1.0
    mark: str = ""

    name: ClassVar[str] = "marked-euler"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = CLAIMS
    source: ClassVar[str] = "test"

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Any) -> Step:
        """Make one step."""
        x = state + self.drift * h * problem.drift(t, state) + problem.diffused(t, state, noise.dW)
        every = np.ones(state.shape[1], dtype=bool)
        return Step(x, **({self.mark: every} if self.mark else {}))


def found(scheme, measure):
    """Return the verdicts on `ou` with their reasons."""
    verdicts = verify([scheme], "ou", measure, paths=256).verdicts
    return list(zip(verdicts["verdict"], verdicts["reason"], strict=True))


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize("mark", ["truncated", "failed"])
@pytest.mark.parametrize("measure", ["strong", "weak", "invariant"])
def test_marks_on_every_step_leave_a_claim_open_and_the_reason_says_that_no_order_was_seen(mark, measure):
    """The step itself is right, and verified without the mark."""
    verdicts = found(MarkedEuler(mark=mark), measure)

    assert verdicts
    for verdict, reason in verdicts:
        assert verdict == "inconclusive"
        assert "no order can be observed" in reason


@pytest.mark.parametrize(
    "measure", ["strong", *(pytest.param(name, marks=pytest.mark.long) for name in ("weak", "invariant"))]
)
def test_without_marks_the_right_step_is_verified_and_a_wrong_drift_refuted(measure):
    """What is marked alone decides whether an order is seen."""
    assert {verdict for verdict, _ in found(MarkedEuler(), measure)} >= {"verified"}
    assert {verdict for verdict, _ in found(MarkedEuler(drift=1.1), measure)} >= {"refuted"}
