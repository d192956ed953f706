"""The rules that a finding passes between its measure and the report: one tuple, `RULES`, in the order of events.

A rule is a guard, which bars verdicts, or a step, a pure function that counts tests or says what a run waits for.
Both are given the finding and its `Case`, which holds what is known apart from the evidence of the cell. A rule for
which the case has nothing leaves the finding as it is: code that learns something about a finding fills a field of a
case and applies all rules.

Guards take verdicts back, or forbid them for good. Only `correct_for_all_tests` gives a verdict, which the p-values
of the finding allow.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce
from math import inf, isnan
from typing import Any, NamedTuple

from ..contracts.finding import ONE_STEP, SAMPLED, Finding, Kind, Reason, Verdict
from .guard import DECIDE, REFUTE, VERIFY, Guard

FINER = "finer steps decide"


class Objection(NamedTuple):
    """Why a claim cannot be verified.

    Attributes
    ----------
    reason : str
    verdict : Verdict
        Inconclusive where the controls do not come out as they must; an error or not run where that is not known.
    """

    reason: str
    verdict: Verdict = Verdict.INCONCLUSIVE


class Case(NamedTuple):
    """What is known of a finding beside its cell's evidence; what is left out is not known, and changes nothing.

    Attributes
    ----------
    suspicion : str
        Why the problem is suspect where paths refute, or may over all tests of the run: a scheme that is known to be
        right is, or may be, refuted, too.
    objection : Objection or None
        Of the problem's controls to verifying the claim.
    end : Reason
        Where the problem loses its root, so that the solution ends.
    looks : int
        How often paths are looked at: each look is a test.
    finer : bool
        Whether finer levels are drawn for it.
    diverges : str
        Why the claim cannot hold in its sense: moments of the scheme tend to infinity, or it has no invariant law.
    elsewhere : str
        What another finding of the run on the same scheme and problem has shown to be wrong.
    stopped : str
        Why no further looks were taken.
    significant : frozenset of Verdict or None
        Which verdicts its p-values allow over all tests of the run; None before that is known.
    resolution : float
        Largest error of the limit, as part of the quantity's size, that somebody accepts to be overlooked.
    """

    suspicion: str = ""
    objection: Objection | None = None
    end: Reason = Reason()
    looks: int = 1
    finer: bool = False
    diverges: str = ""
    elsewhere: str = ""
    stopped: str = ""
    significant: frozenset[Verdict] | None = None
    resolution: float = inf


class Doubt(NamedTuple):
    """Why a guard bars a verdict of a finding.

    Attributes
    ----------
    reason : Reason or str
    verdict : Verdict
        Given in place of the barred one.
    settled : bool or None
        Whether more paths cannot change it; as before if None.
    added : bool
        Whether the reason is put behind that of the finding, not before it.
    """

    reason: Reason | str
    verdict: Verdict = Verdict.INCONCLUSIVE
    settled: bool | None = None
    added: bool = False


def doubt_problem(finding: Finding, case: Case) -> Doubt | None:  # noqa: ARG001
    """Return the suspicion that the problem is wrong: a positive control is refuted on it as well."""
    if not case.suspicion:
        return None
    return Doubt(f"the exact solution of the problem is in doubt: {case.suspicion}", Verdict.ERROR)


def doubt_discrimination(finding: Finding, case: Case) -> Doubt | None:
    """Return the objection of the controls: the problem does not tell orders apart."""
    if case.objection is None:
        return None
    reason, verdict = case.objection
    known = verdict is Verdict.INCONCLUSIVE
    return Doubt(reason if known else f"not verified: {reason}", verdict, not (known and finding.tier == SAMPLED))


def doubt_moments(finding: Finding, case: Case) -> Doubt | None:  # noqa: ARG001
    """Return why moments, or the invariant law, that the claim is about do not exist."""
    return Doubt(case.diverges) if case.diverges else None


def doubt_end(finding: Finding, case: Case) -> Doubt | None:
    """Return where the solution ends, unless paths refute the claim: they are compared up to there."""
    by_paths = finding.verdict is Verdict.REFUTED and finding.tier == SAMPLED
    if not case.end or by_paths or finding.verdict not in DECIDE:
        return None
    return Doubt("" if finding.reason.has(Kind.LOST_INDEX) else case.end, added=True)


def doubt_other_findings(finding: Finding, case: Case) -> Doubt | None:
    """Return what another finding on the same scheme and problem has shown to be wrong."""
    asked = finding.verdict in {Verdict.VERIFIED, Verdict.INCONCLUSIVE}
    return Doubt(f"not confirmed: {case.elsewhere}") if case.elsewhere and asked else None


def doubt_resolution(finding: Finding, case: Case) -> Doubt | None:
    """Return that an error of the size that the policy asks about would not have shown."""
    if finding.verdict is not Verdict.VERIFIED or not finding.resolution > case.resolution:
        return None
    text = "an error of {seen:.2g} of the size of the limit would not have shown, the policy allows {asked:g}"
    return Doubt(Reason(text, numbers={"seen": finding.resolution, "asked": case.resolution}))


def count_looks(finding: Finding, case: Case) -> Finding:
    """Put the p-values to as many tests as there are looks."""
    if case.looks == 1:
        return finding
    p_verified, p_refuted = (_of_looks(float(p), case.looks) for p in (finding.p_verified, finding.p_refuted))
    return forbid(replace(finding, p_verified=p_verified, p_refuted=p_refuted))


def wait_for_finer_levels(finding: Finding, case: Case) -> Finding:
    """Leave open what finer levels are drawn for."""
    return withhold(finding, FINER, settled=False) if case.finer else finding


def tell_stop(finding: Finding, case: Case) -> Finding:
    """Prepend the reason why sampling stopped to inconclusive findings."""
    cut = case.stopped and finding.verdict is Verdict.INCONCLUSIVE and not finding.settled
    return replace(finding, reason=Reason.of(case.stopped, finding.reason)) if cut else finding


def correct_for_all_tests(finding: Finding, case: Case) -> Finding:
    """Keep, take back or give the verdicts of paths by what is significant over all tests of the run."""
    if case.significant is None or finding.tier < SAMPLED or finding.verdict is Verdict.DIVERGED:
        return finding
    known = {Verdict.REFUTED: finding.p_refuted, Verdict.VERIFIED: finding.p_verified}
    if finding.verdict in known and (case.significant or isnan(known[finding.verdict])):
        return finding
    if finding.verdict in known:
        reason = Reason.of("not significant over all tests of this run", finding.reason)
        return replace(finding, verdict=Verdict.INCONCLUSIVE, reason=reason)
    if finding.verdict is not Verdict.INCONCLUSIVE or not case.significant:
        return finding
    verdict = Verdict.REFUTED if Verdict.REFUTED in case.significant else Verdict.VERIFIED
    reason = finding.reason.before(Kind.MORE_PATHS)
    if verdict is Verdict.VERIFIED:
        # What was not shown of the limit by itself is shown among all tests.
        reason = reason.without(Kind.LIMIT)
    reason = reason.then("significant over all tests of this run")
    return replace(finding, verdict=verdict, reason=reason)


PROBLEM = Guard(
    asks=doubt_problem,
    bars=REFUTE,
    tier=SAMPLED,
    reason="a scheme that is known to be right is refuted on the same problem",
    remedy="the truth of the problem is mended",
    planted="Euler-Maruyama with the truth of another noise",
)
DISCRIMINATION = Guard(
    asks=doubt_discrimination,
    bars=VERIFY,
    tier=None,
    reason="the controls of the problem do not come out as they must: it does not tell the order from a lower one",
    remedy="more paths, or finer levels, on which the negative control is refuted",
    planted="order 1/2 with small noise",
)
MOMENTS = Guard(
    asks=doubt_moments,
    bars=VERIFY,
    tier=None,
    reason="moments of the scheme grow without bound as h falls, so that the claim cannot hold in mean square",
    remedy="a claim in probability",
    planted="Euler-Maruyama with a cubic drift",
)
END = Guard(
    asks=doubt_end,
    bars=DECIDE,
    tier=ONE_STEP,
    reason="the solution ends where the problem loses its root, so that a run does not last",
    remedy="a shorter horizon",
    planted="a pole within the horizon",
)
OTHER_FINDINGS = Guard(
    asks=doubt_other_findings,
    bars=VERIFY,
    tier=None,
    reason="another finding on the same scheme and problem has shown a wrong limit that this one shares",
    remedy="",
    planted="a half-explicit step with a multiplier of the other sign",
)
RESOLUTION = Guard(
    asks=doubt_resolution,
    bars=VERIFY,
    tier=None,
    reason="an error of the size that the policy of a gate asks about would not have shown",
    remedy="more paths",
    planted="another noise, and a gate that asks for a hundredth",
)
Step = Callable[[Finding, Case], Finding]
# In the order of events: guards, and steps that count tests or say what a run waits for.
RULES: tuple[Guard | Step, ...] = (
    PROBLEM,
    DISCRIMINATION,
    MOMENTS,
    END,
    count_looks,
    wait_for_finer_levels,
    OTHER_FINDINGS,
    tell_stop,
    correct_for_all_tests,
    RESOLUTION,
)


def send(finding: Finding, case: Case) -> Finding:
    """Return the finding after all rules.

    Parameters
    ----------
    finding : Finding
    case : Case
        What is known of it now.
    """
    return reduce(lambda passed, rule: _decide(passed, case, rule), RULES, finding)


def _decide(finding: Finding, case: Case, rule: Guard | Step) -> Finding:
    """Return the finding after one rule: a guard with a doubt takes back a verdict that it bars, or forbids it."""
    if not isinstance(rule, Guard):
        return rule(finding, case)
    doubt: Doubt | None = rule.asks(finding, case)
    if doubt is None:
        return finding
    if finding.verdict not in rule.bars:
        return forbid(finding, *rule.bars)
    reason = finding.reason.then(doubt.reason) if doubt.added else Reason.of(doubt.reason, finding.reason)
    settled = finding.settled if doubt.settled is None else doubt.settled
    open_ = replace(finding, verdict=doubt.verdict, reason=reason, settled=settled)
    return forbid(open_, Verdict.VERIFIED, *rule.bars)


def withhold(finding: Finding, doubt: Reason | str, **changed: Any) -> Finding:
    """Return a finding as one that is not verified, and never will be, the doubt before its reason.

    Parameters
    ----------
    finding : Finding
    doubt : Reason or str
    **changed
        Fields that change as well, such as ``verdict``.
    """
    open_ = replace(finding, verdict=Verdict.INCONCLUSIVE, reason=Reason.of(doubt, finding.reason))
    return replace(forbid(open_, Verdict.VERIFIED), **changed)


def forbid(finding: Finding, *verdicts: Verdict) -> Finding:
    """Return a finding with verdicts, verified or refuted, that it cannot have whatever is sampled.

    Parameters
    ----------
    finding : Finding
    *verdicts : Verdict
        Beside those that are excluded already.
    """
    excluded = finding.excluded.union(verdicts)
    p_verified = 1.0 if Verdict.VERIFIED in excluded else finding.p_verified
    p_refuted = 1.0 if Verdict.REFUTED in excluded else finding.p_refuted
    return replace(finding, excluded=excluded, p_verified=p_verified, p_refuted=p_refuted)


def withhold_in_doubt(findings: Sequence[Finding]) -> list[Finding]:
    """Verify no quantity of a cell where another one of it is known to tend to the wrong limit.

    Parameters
    ----------
    findings : sequence of Finding
        Of one measure on one scheme and problem.
    """
    wrong = [f.quantity for f in findings if f.verdict is Verdict.REFUTED and f.reason.has(Kind.WRONG_LIMIT)]
    doubt = f"not confirmed: {Kind.WRONG_LIMIT} in {', '.join(wrong)}"
    return [withhold(f, doubt) if wrong and f.verdict is Verdict.VERIFIED else f for f in findings]


def _of_looks(p: float, looks: int) -> float:
    return p if isnan(p) else min(1.0, looks * p)
