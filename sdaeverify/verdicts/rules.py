"""Rules that a finding passes between its measure and the report: the tuple `RULES`, in the order of application.

A rule is a guard, which bars verdicts, or a step: a pure function that counts tests or states why a run continues or
stopped. Both receive the finding and its `Case`, which holds the knowledge from outside the evidence of the cell. A
rule leaves the finding unchanged if its field of the case has the default value. Code that learns something about a
finding fills a field of a case and applies all rules.

Guards take verdicts back, or forbid them for good. Only `correct_for_all_tests` gives a verdict, if the p-values of
the finding allow it.
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
    """State why the controls of a problem bar verification of a claim.

    Attributes
    ----------
    reason : str
    verdict : Verdict
        Inconclusive if the controls fail; an error or not run if their outcome is unknown.
    """

    reason: str
    verdict: Verdict = Verdict.INCONCLUSIVE


class Case(NamedTuple):
    """Hold the knowledge about a finding from outside its cell's evidence; a default value changes nothing.

    Attributes
    ----------
    suspicion : str
        Why the problem is suspect when paths refute, or may refute after the correction for all tests: a scheme known
        to be right is, or may be, refuted too.
    objection : Objection or None
        Objection of the problem's controls to verifying the claim.
    end : Reason
        Reason that states where the problem loses its algebraic root, so that the solution ends; empty if it does
        not.
    looks : int
        Number of interim analyses of the paths: each look is a test.
    finer : bool
        Whether finer levels are drawn for the finding.
    diverges : str
        Why the claim cannot hold in its sense: moments of the scheme tend to infinity, or it has no invariant law.
    elsewhere : str
        Error that another finding of the run on the same scheme and problem has shown.
    stopped : str
        Why no further looks were taken.
    significant : frozenset of Verdict or None
        Verdicts that the p-values allow over all tests of the run; None before these are known.
    resolution : float
        Largest undetected error of the limit that a policy accepts, as part of the quantity's size.
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
    """State why a guard bars a verdict of a finding.

    Attributes
    ----------
    reason : Reason or str
    verdict : Verdict
        Verdict given instead of the barred one.
    settled : bool or None
        Whether more paths cannot change the verdict; None leaves the value of the finding.
    added : bool
        Whether the reason follows that of the finding instead of preceding it.
    """

    reason: Reason | str
    verdict: Verdict = Verdict.INCONCLUSIVE
    settled: bool | None = None
    added: bool = False


def doubt_problem(finding: Finding, case: Case) -> Doubt | None:  # noqa: ARG001
    """Return the doubt that the problem is wrong because a positive control is refuted on it as well."""
    if not case.suspicion:
        return None
    return Doubt(f"the exact solution of the problem is in doubt: {case.suspicion}", Verdict.ERROR)


def doubt_discrimination(finding: Finding, case: Case) -> Doubt | None:
    """Return the doubt raised by the controls: the problem does not distinguish orders."""
    if case.objection is None:
        return None
    reason, verdict = case.objection
    known = verdict is Verdict.INCONCLUSIVE
    return Doubt(reason if known else f"not verified: {reason}", verdict, not (known and finding.tier == SAMPLED))


def doubt_moments(finding: Finding, case: Case) -> Doubt | None:  # noqa: ARG001
    """Return the doubt that the moments or the invariant law of the claim do not exist."""
    return Doubt(case.diverges) if case.diverges else None


def doubt_end(finding: Finding, case: Case) -> Doubt | None:
    """Return the doubt that the solution ends within the horizon.

    A refutation by paths stands, because they are compared up to the end of the solution.
    """
    by_paths = finding.verdict is Verdict.REFUTED and finding.tier == SAMPLED
    if not case.end or by_paths or finding.verdict not in DECIDE:
        return None
    return Doubt("" if finding.reason.has(Kind.LOST_INDEX) else case.end, added=True)


def doubt_other_findings(finding: Finding, case: Case) -> Doubt | None:
    """Return the doubt that another finding on the same scheme and problem has shown an error."""
    asked = finding.verdict in {Verdict.VERIFIED, Verdict.INCONCLUSIVE}
    return Doubt(f"not confirmed: {case.elsewhere}") if case.elsewhere and asked else None


def doubt_resolution(finding: Finding, case: Case) -> Doubt | None:
    """Return the doubt that an error above the size accepted by the policy would not have shown."""
    if finding.verdict is not Verdict.VERIFIED or not finding.resolution > case.resolution:
        return None
    text = "an error of {seen:.2g} times the size of the limit could go undetected, the policy allows {asked:g}"
    return Doubt(Reason(text, numbers={"seen": finding.resolution, "asked": case.resolution}))


def count_looks(finding: Finding, case: Case) -> Finding:
    """Multiply the p-values by the number of looks (Bonferroni)."""
    if case.looks == 1:
        return finding
    p_verified, p_refuted = (_of_looks(float(p), case.looks) for p in (finding.p_verified, finding.p_refuted))
    return forbid(replace(finding, p_verified=p_verified, p_refuted=p_refuted))


def wait_for_finer_levels(finding: Finding, case: Case) -> Finding:
    """Leave a finding open if finer levels are being drawn for it."""
    return withhold(finding, FINER, settled=False) if case.finer else finding


def tell_stop(finding: Finding, case: Case) -> Finding:
    """Prepend the reason why sampling stopped to inconclusive findings."""
    cut = case.stopped and finding.verdict is Verdict.INCONCLUSIVE and not finding.settled
    return replace(finding, reason=Reason.of(case.stopped, finding.reason)) if cut else finding


def correct_for_all_tests(finding: Finding, case: Case) -> Finding:
    """Keep, withdraw or give verdicts of paths by their significance over all tests of the run."""
    if case.significant is None or finding.tier < SAMPLED or finding.verdict is Verdict.DIVERGED:
        return finding
    known = {Verdict.REFUTED: finding.p_refuted, Verdict.VERIFIED: finding.p_verified}
    if finding.verdict in known and (case.significant or isnan(known[finding.verdict])):
        return finding
    if finding.verdict in known:
        reason = Reason.of("not significant after correction for all tests of this run", finding.reason)
        return replace(finding, verdict=Verdict.INCONCLUSIVE, reason=reason)
    if finding.verdict is not Verdict.INCONCLUSIVE or not case.significant:
        return finding
    verdict = Verdict.REFUTED if Verdict.REFUTED in case.significant else Verdict.VERIFIED
    reason = finding.reason.before(Kind.MORE_PATHS)
    if verdict is Verdict.VERIFIED:
        # The limit, not verified by this test alone, is verified over all tests.
        reason = reason.without(Kind.LIMIT)
    reason = reason.then("significant after correction for all tests of this run")
    return replace(finding, verdict=verdict, reason=reason)


PROBLEM = Guard(
    asks=doubt_problem,
    bars=REFUTE,
    tier=SAMPLED,
    reason="a scheme that is known to be right is refuted on the same problem",
    remedy="a corrected truth of the problem",
    planted="Euler-Maruyama with the truth of another noise",
)
DISCRIMINATION = Guard(
    asks=doubt_discrimination,
    bars=VERIFY,
    tier=None,
    reason="the controls of the problem fail: it does not distinguish the order from a lower one",
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
    reason="the solution ends where the problem loses its root, so that a run cannot reach the horizon",
    remedy="a shorter horizon",
    planted="a pole within the horizon",
)
OTHER_FINDINGS = Guard(
    asks=doubt_other_findings,
    bars=VERIFY,
    tier=None,
    reason="another finding on the same scheme and problem has shown a wrong limit that this one shares",
    remedy="",
    planted="Milstein with a millionth of too much noise",
)
RESOLUTION = Guard(
    asks=doubt_resolution,
    bars=VERIFY,
    tier=None,
    reason="an error of the size that the policy of a gate must detect could go undetected",
    remedy="more paths",
    planted="another noise, and a gate that asks for a hundredth",
)
Step = Callable[[Finding, Case], Finding]
# In the order of application: guards, and steps that count tests or state why a run continues or stopped.
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
    """Apply all rules to a finding.

    Parameters
    ----------
    finding : Finding
    case : Case
        Present knowledge about the finding.
    """
    return reduce(lambda passed, rule: _decide(passed, case, rule), RULES, finding)


def _decide(finding: Finding, case: Case, rule: Guard | Step) -> Finding:
    """Apply one rule; a guard with a doubt withdraws a verdict that it bars, or forbids it."""
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
    """Return the finding as inconclusive and never to be verified, with the doubt before its reason.

    Parameters
    ----------
    finding : Finding
    doubt : Reason or str
    **changed
        Further fields to replace, such as ``verdict``.
    """
    open_ = replace(finding, verdict=Verdict.INCONCLUSIVE, reason=Reason.of(doubt, finding.reason))
    return replace(forbid(open_, Verdict.VERIFIED), **changed)


def forbid(finding: Finding, *verdicts: Verdict) -> Finding:
    """Return the finding with verdicts that no further sampling can give it.

    Parameters
    ----------
    finding : Finding
    *verdicts : Verdict
        Verdicts to exclude in addition to those that are excluded already. Their p-values become 1.
    """
    excluded = finding.excluded.union(verdicts)
    p_verified = 1.0 if Verdict.VERIFIED in excluded else finding.p_verified
    p_refuted = 1.0 if Verdict.REFUTED in excluded else finding.p_refuted
    return replace(finding, excluded=excluded, p_verified=p_verified, p_refuted=p_refuted)


def withhold_in_doubt(findings: Sequence[Finding]) -> list[Finding]:
    """Withhold verification in a cell if another quantity of the cell has a wrong limit.

    Parameters
    ----------
    findings : sequence of Finding
        Findings of one measure on one scheme and problem.
    """
    wrong = [f.quantity for f in findings if f.verdict is Verdict.REFUTED and f.reason.has(Kind.WRONG_LIMIT)]
    doubt = f"not confirmed: {Kind.WRONG_LIMIT} in {', '.join(wrong)}"
    return [withhold(f, doubt) if wrong and f.verdict is Verdict.VERIFIED else f for f in findings]


def _of_looks(p: float, looks: int) -> float:
    return p if isnan(p) else min(1.0, looks * p)
