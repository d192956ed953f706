"""What a finding passes on its way from a measure to the report: one tuple of rules, `RULES`, in their order.

A rule is a pure function of the finding and of its `Case`, which says what is known beside the cell's own evidence. A
rule for which the case has nothing returns the finding as it is. So whoever learns something about a finding puts it
into a case and sends the finding the whole way; nobody else changes what was found.

No rule makes a verdict out of nothing: all but the last take verdicts back, or forbid them for good, and the last two
may give one that the p-values of the finding allow.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce
from math import inf, isinf, isnan
from typing import Any, NamedTuple

from ..contracts.claimed import Order
from ..contracts.finding import SAMPLED, Finding, Kind, Reason, Verdict

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
    half_width : float
        Distance from the estimate to the upper end of the narrowest interval that lay below the claim at an earlier
        look on the same levels; infinite if none did.
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
    half_width: float = inf
    diverges: str = ""
    elsewhere: str = ""
    stopped: str = ""
    significant: frozenset[Verdict] | None = None
    resolution: float = inf


Rule = Callable[[Finding, Case], Finding]


def heed_controls(finding: Finding, case: Case) -> Finding:
    """Verify only where the problem discriminates, and refute only where it is sound."""
    if case.suspicion:
        finding = forbid(finding, Verdict.REFUTED)
        if finding.verdict is Verdict.REFUTED:
            doubt = f"the exact solution of the problem is in doubt: {case.suspicion}"
            return withhold(finding, doubt, verdict=Verdict.ERROR)
    if case.objection is None:
        return finding
    if finding.verdict is not Verdict.VERIFIED:
        return forbid(finding, Verdict.VERIFIED)
    reason, verdict = case.objection
    known = verdict is Verdict.INCONCLUSIVE
    doubt = reason if known else f"not verified: {reason}"
    return withhold(finding, doubt, verdict=verdict, settled=not (known and finding.tier == SAMPLED))


def require_moments(finding: Finding, case: Case) -> Finding:
    """Verify no claim for which moments, or an invariant law, of the scheme would have to exist and do not."""
    if not case.diverges:
        return finding
    if finding.verdict is Verdict.VERIFIED:
        return withhold(finding, case.diverges)
    return forbid(finding, Verdict.VERIFIED)


def heed_end(finding: Finding, case: Case) -> Finding:
    """Leave open what is found of a run that the solution may not last for: then only paths refute."""
    by_paths = finding.verdict is Verdict.REFUTED and finding.tier == SAMPLED
    if not case.end or by_paths or finding.verdict not in {Verdict.VERIFIED, Verdict.REFUTED}:
        return finding
    reason = finding.reason if finding.reason.has(Kind.LOST_INDEX) else finding.reason.then(case.end)
    open_ = replace(finding, verdict=Verdict.INCONCLUSIVE, reason=reason)
    return forbid(open_, Verdict.VERIFIED, Verdict.REFUTED)


def count_looks(finding: Finding, case: Case) -> Finding:
    """Put the p-values to as many tests as there are looks."""
    if case.looks == 1:
        return finding
    p_verified, p_refuted = (_of_looks(float(p), case.looks) for p in (finding.p_verified, finding.p_refuted))
    return forbid(replace(finding, p_verified=p_verified, p_refuted=p_refuted))


def lies_below(finding: Finding, half_width: float = inf) -> bool:
    """Return whether the interval of an order, or one of this half width if that is narrower, is below the claim."""
    if finding.claim is None or not isinstance(finding.claim.value, Order):
        return False
    return finding.estimate + min(half_width, finding.high - finding.estimate) < finding.claim.value.floor


def keep_suspicion(finding: Finding, case: Case) -> Finding:
    """Leave open what an earlier look spoke against if the interval is only wider now, as heavy tails make it."""
    if finding.verdict is not Verdict.VERIFIED or isinf(case.half_width) or not lies_below(finding, case.half_width):
        return finding
    doubt = Reason("the order of fewer paths lies below the claim, and its interval is only wider now", Kind.GUARD)
    return withhold(finding, doubt, settled=False)


def wait_for_finer_levels(finding: Finding, case: Case) -> Finding:
    """Leave open what finer levels are drawn for."""
    return withhold(finding, FINER, settled=False) if case.finer else finding


def heed_other_findings(finding: Finding, case: Case) -> Finding:
    """Verify nothing that another finding on the same scheme and problem has shown to be wrong."""
    if not case.elsewhere or finding.verdict not in {Verdict.VERIFIED, Verdict.INCONCLUSIVE}:
        return finding
    if finding.verdict is Verdict.INCONCLUSIVE:
        return forbid(finding, Verdict.VERIFIED)
    return withhold(finding, f"not confirmed: {case.elsewhere}")


def tell_stop(finding: Finding, case: Case) -> Finding:
    """Say first why no further paths were drawn for what is open."""
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


def ask_resolution(finding: Finding, case: Case) -> Finding:
    """Leave open what was verified by evidence that would not have shown an error of the size asked for."""
    if finding.verdict is not Verdict.VERIFIED or not finding.resolution > case.resolution:
        return finding
    text = "an error of {seen:.2g} of the size of the limit would not have shown, the policy allows {asked:g}"
    return withhold(finding, Reason(text, numbers={"seen": finding.resolution, "asked": case.resolution}))


RULES: tuple[Rule, ...] = (
    heed_controls,
    require_moments,
    heed_end,
    count_looks,
    keep_suspicion,
    wait_for_finer_levels,
    heed_other_findings,
    tell_stop,
    correct_for_all_tests,
    ask_resolution,
)


def send(finding: Finding, case: Case) -> Finding:
    """Return the finding after all rules.

    Parameters
    ----------
    finding : Finding
    case : Case
        What is known of it now.
    """
    return reduce(lambda passed, rule: rule(passed, case), RULES, finding)


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
