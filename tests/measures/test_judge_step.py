"""What one step alone says of claims on a problem: for hunts, without any path."""

import pytest

from facade import EulerMaruyama, Milstein, Strong, Weak, gbm, with_claims
from sdaeverify import Claim
from sdaeverify.measuring import Measure, Verdict


def judged(measure, scheme, *claims):
    """Return the findings of one step of a scheme with some claims on a geometric Brownian motion."""
    problem, claiming = gbm(), with_claims(scheme, *claims)
    return [*measure.judge_step(claiming, problem, claiming.view_of(problem))]


def claim(measure, order):
    """Return a claim of an order."""
    return Claim(measure=measure, value=order, source="a test")


@pytest.mark.parametrize(
    ("measure", "scheme", "order", "verdict"),
    [
        (Strong(), Milstein(), 1.0, Verdict.VERIFIED),
        (Strong(), EulerMaruyama(), 0.5, Verdict.VERIFIED),
        (Strong(), EulerMaruyama(), 1.0, Verdict.REFUTED),
        (Weak(), EulerMaruyama(), 1.0, Verdict.VERIFIED),
        (Weak(), EulerMaruyama(), 2.0, Verdict.REFUTED),
    ],
)
def test_one_step_judges_a_claimed_order(measure, scheme, order, verdict):
    """A right order is verified and one that is too high refuted, each beside the order of the step."""
    found = judged(measure, scheme, claim(measure.name, order))

    assert {each.verdict for each in found} == {verdict}
    assert all((each.estimate < order - measure.step_tolerance) is (verdict is Verdict.REFUTED) for each in found)


def test_nothing_is_said_without_a_claim():
    """An order that nobody claims has no finding, and a measure of paths has none at all."""
    assert judged(Strong(), Milstein()) == []
    assert [*Measure().judge_step(Milstein(), gbm(), gbm())] == []
