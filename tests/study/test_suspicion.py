"""What one look speaks against is not cleared by a later one whose interval is only wider."""

from dataclasses import dataclass, replace
from math import inf

import pytest

from sdaeverify import Claim
from sdaeverify.measuring import Finding, Judgement, Kind, LevelFinding, Reason, Verdict
from study.test_guards import SETTINGS, Told, run

CLAIM = Claim(measure="told", value=1.0, margin=0.2, source="test")
DOUBT = Reason("paths do not show what is claimed", Kind.GUARD).then(Reason("more would decide", Kind.MORE_PATHS))


def order(estimate: float, half: float, verdict: Verdict = Verdict.VERIFIED) -> Finding:
    """Return a finding on an order with its interval; an inconclusive one asks for more paths."""
    interval = {"estimate": estimate, "low": estimate - half, "high": estimate + half}
    found = Finding(quantity="x", verdict=verdict, claim=CLAIM, tier=1, **interval)
    return found if verdict is Verdict.VERIFIED else replace(found, tier=3, settled=False, reason=DOUBT)


@dataclass(frozen=True, eq=False)
class Looks(Told):
    """A measure that says one thing at the first look on the levels of guards, and another one at later looks."""

    later: Finding | None = None

    def judge(self, evidence):
        """Return what is said of so many paths."""
        found = self.said if evidence.paths < 1000 else self.later
        levels = range(int(evidence.tally.maxima["levels"][0]))
        return Judgement((found,), tuple(LevelFinding("x", level, 0.0) for level in levels))


SUSPECTS = order(0.6, 0.15, Verdict.INCONCLUSIVE)


@pytest.mark.parametrize(
    ("later", "verdict"),
    [
        (order(0.6, 0.3), Verdict.INCONCLUSIVE),
        (order(0.6, inf), Verdict.INCONCLUSIVE),
        (order(0.95, 0.3), Verdict.VERIFIED),
        (order(0.7, 0.11), Verdict.VERIFIED),
    ],
    ids=["wider", "without bound", "moved up", "narrower, and up to the claim"],
)
def test_suspicion_ends_with_the_estimate_and_not_with_the_width(later: Finding, verdict: Verdict) -> None:
    """A look that suspects an order is cleared by an estimate near the claim alone."""
    (result,) = run(Looks(SUSPECTS, later=later), settings=replace(SETTINGS, first_levels=SETTINGS.levels))

    assert result.findings[0].verdict is verdict


def test_interval_that_was_wide_from_the_start_is_no_suspicion() -> None:
    """A first look that does not exclude the claim is no evidence against it later."""
    wide = order(0.6, 0.3, Verdict.INCONCLUSIVE)
    (result,) = run(Looks(wide, later=order(0.6, 0.3)), settings=replace(SETTINGS, first_levels=SETTINGS.levels))

    assert result.findings[0].verdict is Verdict.VERIFIED
