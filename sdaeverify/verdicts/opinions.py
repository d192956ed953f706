"""What is said of a claim, and how: what one step decides is guarded by paths, which decide the rest alone."""

from collections.abc import Callable, Container
from math import ceil, floor, isfinite, log10
from typing import Any

from ..contracts.claimed import Bound, Order, Word
from ..contracts.finding import Finding, Judgement, Kind, Opinion, Reason, Verdict
from ..contracts.measure import Evidence
from ..contracts.settings import MOST_PATHS
from ..probe.local.delay_links import remove_delay
from ..probe.local.smoothness import rough_coefficient
from ..probe.step.memory import NEAR
from .coverage import Coverage
from .fitted_levels import FEWEST
from .path_tests import CALIBRATED_PATHS, SUSPECT, PathTests, unknown_value


def judge_claim(
    covered: Coverage, judge: Callable[[Any], Opinion], words: Container[str] = (), tier: int = 3
) -> Opinion:
    """Return the opinion on a claim; out of scope where there is none, undecided where its value is not known.

    Parameters
    ----------
    covered : Coverage
    judge : callable, Claim -> Opinion
        Of a claim whose value the measure knows.
    words : container of str
        Words, bounded or not, that the measure knows; if left out, it knows orders.
    tier : int
        Of an opinion without a judgement.
    """
    claim = covered.claim
    if claim is None:
        return Opinion(Verdict.OUT_OF_SCOPE, covered.gap, tier)
    match claim.value:
        case Order():
            known = not words
        case Word(text) | Bound(text):
            known = text in words
        case _:
            known = False
    return judge(claim) if known else Opinion(Verdict.INCONCLUSIVE, unknown_value(claim), tier)


def leave_open(covered: Coverage, reason: Reason | str) -> Opinion:
    """Return that a claim, if there is one, is not decided, and why."""
    undecided = Opinion(Verdict.INCONCLUSIVE, Reason.of(reason))
    return undecided if covered.claim else Opinion(Verdict.OUT_OF_SCOPE, covered.gap)


def local_opinion(verdict: Verdict, text: str, kind: str = Kind.PLAIN) -> Opinion:
    """Return what one step says (T1).

    Parameters
    ----------
    verdict : Verdict
    text : str
        The reason in words.
    kind : str, optional
        Reasons of one kind say the same with other numbers.
    """
    return Opinion(verdict, Reason(text, kind), 1)


def local_doubt(text: str, kind: str = Kind.PLAIN, *, against: bool = False) -> Opinion:
    """Return that one step does not decide, and why.

    Parameters
    ----------
    text : str
        The reason in words.
    kind : str, optional
        Of the reason; one step that does not follow the equation speaks against all claims of the scheme there.
    against : bool, optional
        Whether it speaks against the claim all the same, so that paths do not verify it; it says nothing if left out.
    """
    found = local_opinion(Verdict.INCONCLUSIVE, text, kind)
    return found._replace(excluded=frozenset({Verdict.VERIFIED})) if against else found


def too_coarse(h: float) -> Opinion:
    """Return that a claim is left open by all tiers: steps may have the order, but shorter ones than paths can have.

    A scheme that bounds its drift by 1/h, or its noise by 1, does so in the units of the state and of time.

    Parameters
    ----------
    h : float
        The shortest step size at which the order of one step is too low.
    """
    text = f"one step has too low an order at h = {h:.2g}, and at far shorter ones no such order is seen"
    doubt = local_doubt(f"{text}: steps of a run are too long")
    return doubt._replace(excluded=frozenset({Verdict.VERIFIED, Verdict.REFUTED}))


def of_smooth(opinion: Opinion, claim: float, evidence: Evidence, *, at_few: bool = False) -> Opinion:
    """Return what a local order says of a claim: nothing for it where a coefficient is not smooth enough.

    Order 1/2 needs Lipschitz coefficients alone (Milstein 1988, Theorem 1). Nor does the low order of steps that
    begin on a kink say anything against a claim, where other steps have the order: hardly any step begins there. Nor
    does any low order where a coefficient jumps in time: it may be that of the one step of a run across the jump.

    Parameters
    ----------
    opinion : Opinion
        Of one step.
    claim : float
        The order that is claimed.
    evidence : Evidence
        Of its cell.
    at_few : bool
        Whether what refutes the claim is the order at few states alone.
    """
    verified = opinion.verdict is Verdict.VERIFIED
    if not (verified or opinion.verdict is Verdict.REFUTED):
        return opinion
    rough = rough_coefficient(remove_delay(evidence.scheme, evidence.view)[1])
    if rough is None or (claim <= rough.highest if verified else not (at_few or rough.in_time)):
        return opinion
    return local_doubt(f"{opinion.reason}, for smooth coefficients; here {rough} where solutions go")


def up_to(most: float, opinion: Opinion, claim: float, words: str, *, against: bool = False) -> Opinion:
    """Return what a local order says of a claim: nothing for one above the order that steps in a row allow.

    Parameters
    ----------
    most : float
        That order.
    opinion : Opinion
        Of one step.
    claim : float
        The order that is claimed.
    words : str
        For which steps it holds, and what others there are.
    against : bool
        Whether the claim is known to be wrong if it is of more.
    """
    if opinion.verdict is not Verdict.VERIFIED or claim <= most:
        return opinion
    return local_doubt(f"{opinion.reason}, {words}", against=against)


def of_law(opinion: Opinion, claim: float, evidence: Evidence, *, paths: bool) -> Opinion:
    """Return what a local order says of a claim along paths, or in law: nothing above what clipped increments allow.

    One step is compared at nodes of the normal law, and paths hardly meet its tails.

    Parameters
    ----------
    opinion, claim, evidence
        As of `of_smooth`.
    paths : bool
        Whether the order is one along paths, or in law.
    """
    most = evidence.scheme.law.most(paths=paths)
    words = f"for normal increments; clipped as these are, {most:g} is the most"
    return up_to(most, opinion, claim, words, against=True)


def of_memory(opinion: Opinion, bar: float, most: float, order: float) -> Opinion:
    """Return what a local order says of a claim: nothing above the order of what the memory of a run changes.

    Steps are probed without a history. Memory may spoil their order, and take back errors that are no smaller than
    what it changes: an order refutes a claim only if it is surely below.

    Parameters
    ----------
    opinion : Opinion
        Of one step.
    bar : float
        The least order that counts as the claimed one.
    most : float
        Order of what memory changes; infinite without memory.
    order : float
        That one step has.
    """
    decided = opinion.verdict in {Verdict.VERIFIED, Verdict.REFUTED}
    enough = bar <= most if opinion.verdict is Verdict.VERIFIED else order + NEAR <= most
    if not decided or enough or opinion.reason.kind is Kind.INCONSISTENT:
        return opinion
    return local_doubt(f"{opinion.reason}; but memory changes runs by errors of order {most:.2f}")


def decide(tests: PathTests, evidence: Evidence) -> Opinion:
    """Return the verdict of the paths alone: they verify nothing that they speak against as well."""
    found, doubted = Verdict.INCONCLUSIVE, is_suspect(tests)
    if tests.refuted <= evidence.level:
        found = Verdict.REFUTED
    elif tests.verified <= evidence.level and not doubted:
        found = Verdict.VERIFIED
    # Of a measure with paths of its own there may be an opinion before the run has any.
    more = found is Verdict.INCONCLUSIVE and isfinite(tests.growth) and evidence.paths > 0
    paths = tests.growth * evidence.paths
    needed = "" if found is not Verdict.INCONCLUSIVE else tests.remedy or _ask_to_decide(tests, evidence)
    finer = found is Verdict.INCONCLUSIVE and tests.reason.has(Kind.FINER)
    settled = _beyond_budget(evidence, paths) if more else not finer
    opinion = Opinion(found, tests.reason.then(needed), 3, settled, tests.verified, tests.refuted)
    return opinion._replace(p_verified=1.0, excluded=frozenset({Verdict.VERIFIED})) if doubted else opinion


def guard(local: Opinion | None, tests: PathTests, evidence: Evidence) -> Opinion:
    """Return the verdict of a deterministic tier, guarded by the paths; theirs alone where it has none.

    What is refuted without sampling stays so, and what is left open for good stays open. What is verified needs paths
    that could be compared, that would show an error which the claim forbids, and that do not refute it. Where they
    look as if they might, or are too few to show anything, more of them are asked for, and without more nothing is
    decided.

    Parameters
    ----------
    local : Opinion or None
        What one step says; None where it was not asked.
    tests : PathTests
        What paths say.
    evidence : Evidence
    """
    if local is not None and (local.final or local.verdict is Verdict.REFUTED):
        return local
    if local is None or local.verdict is Verdict.INCONCLUSIVE:
        return beside(local, decide(tests, evidence))
    if tests.refuted <= evidence.level:
        reason = tests.reason.then(local.reason, ", although ")
        return Opinion(Verdict.REFUTED, reason, 3, p_refuted=tests.refuted)
    doubt, settled = _doubt(tests, evidence)
    if doubt:
        reason = local.reason.then(doubt, "; ")
        return Opinion(Verdict.INCONCLUSIVE, reason, 3, settled, p_refuted=tests.refuted)
    return local._replace(p_refuted=tests.refuted)


def beside(local: Opinion | None, opinion: Opinion) -> Opinion:
    """Return what paths say of a claim that one step leaves open: they do not verify what it speaks against.

    Parameters
    ----------
    local : Opinion or None
        An inconclusive one of one step; None where it was not asked.
    opinion : Opinion
        Of the paths.
    """
    if local is None:
        return opinion
    if not local.speaks_against:
        return opinion.plus(local.reason)
    if opinion.verdict is Verdict.VERIFIED:
        reason = local.reason.then(opinion.reason, ", although ")
        opinion = opinion._replace(verdict=Verdict.INCONCLUSIVE, reason=reason)
    else:
        # More paths do not verify it either.
        reason = opinion.reason.without(Kind.MORE_PATHS).without(Kind.TRUTH)
        opinion = opinion._replace(reason=reason.then(local.reason))
    return opinion._replace(p_verified=1.0, excluded=opinion.excluded | local.excluded)


def _doubt(tests: PathTests, evidence: Evidence) -> tuple[Reason, bool]:
    """Return why paths that refute nothing are no guard, or an empty reason, and whether more of them do not help."""
    asked = (ask(tests, evidence) for ask in (doubt_few_paths, doubt_likeness, doubt_power))
    return next((doubt for doubt in asked if doubt is not None), (Reason(), True))


def doubt_few_paths(tests: PathTests, evidence: Evidence) -> tuple[Reason, bool] | None:  # noqa: ARG001
    """Return that there are too few paths for an interval."""
    if evidence.paths >= CALIBRATED_PATHS:
        return None
    few = f"{{paths}} paths are too few to exclude a violation, {CALIBRATED_PATHS} are needed"
    return Reason(few, Kind.GUARD, {"paths": evidence.paths}), True


def doubt_likeness(tests: PathTests, evidence: Evidence) -> tuple[Reason, bool] | None:
    """Return that errors along paths do not look like the claim."""
    if tests.against > 1.0 - evidence.settings.confidence:
        return None
    unlike = Reason("paths do not show what is claimed at these step sizes", Kind.GUARD).then(tests.reason, ": ")
    # What is sure and does not refute is held back: more paths leave it so.
    held = tests.suspected <= evidence.level and tests.refuted > SUSPECT
    more = (
        Reason("pre-asymptotic or wrong, finer steps would decide", Kind.FINER)
        if held
        else Reason("more paths would decide", Kind.MORE_PATHS)
    )
    return unlike.then(more), False


def doubt_power(tests: PathTests, evidence: Evidence) -> tuple[Reason, bool] | None:
    """Return that the paths would not show an error as large as the claim forbids."""
    if tests.blind <= 1.0:
        return None
    doubt = Reason("{paths} paths cannot exclude a violation", Kind.GUARD, {"paths": evidence.paths})
    if not isfinite(tests.blind):
        return doubt.then("nor would more paths", ", "), True
    needed = tests.blind * evidence.paths
    asked = _ask_for_paths("--paths {paths} would", "nor would {most:.0e}, the most of --paths", needed)
    return doubt.then(asked, ", "), _beyond_budget(evidence, needed)


def is_suspect(tests: PathTests) -> bool:
    """Return whether paths speak against a claim that they would verify."""
    return tests.suspected <= SUSPECT


def _beyond_budget(evidence: Evidence, needed: float) -> bool:
    """Tell whether half of all paths say that all are too few: the last look, as long as all others, is saved."""
    most = evidence.settings.paths
    return most <= 2 * evidence.paths < 2 * most < 2 * needed


def _ask_to_decide(tests: PathTests, evidence: Evidence) -> Reason:
    """Return how many paths would decide; no number where these are enough by their figures and do not decide."""
    if not isfinite(tests.growth) or evidence.paths == 0:
        return Reason()
    if tests.growth > 1.0:
        beyond = "more than {most:.0e} paths, the most of --paths, would be needed"
        return _ask_for_paths("about {paths} paths would decide (--paths)", beyond, tests.growth * evidence.paths)
    if tests.verified <= evidence.level:
        text = "the same paths speak against the claim (p = {p:.1g}): finer steps would decide (--levels)"
        return Reason(text, numbers={"p": tests.suspected})
    # An order below the bound, with a second fit that is not sure of it yet.
    return Reason("more paths would decide (--paths)", Kind.MORE_PATHS) if tests.refuted < 0.5 else Reason()


def ask_to_resolve(signal: float, needed: float, paths: int) -> Reason:
    """Return how many paths would tell an effect from 0, which does not decide what size it has.

    Parameters
    ----------
    signal, needed : float
        Size of the effect in standard errors, now and as it is needed. Below 1 it may be noise alone, which grows
        with the number of paths that is asked for: no number is given.
    paths : int
        Number of paths now.
    """
    if signal < 1.0:
        return Reason("no number of paths can be predicted from less than one standard error")
    beyond = "more than {most:.0e} paths, the most of --paths, would be needed to show one"
    return _ask_for_paths("about {paths} paths would show one (--paths)", beyond, paths * (needed / signal) ** 2)


def _ask_for_paths(text: str, beyond: str, paths: float) -> Reason:
    """Return a number of paths in words, or other words where it is more than a run takes."""
    if paths > MOST_PATHS:
        return Reason(beyond, Kind.MORE_PATHS, {"paths": f"{paths:.2g}", "most": MOST_PATHS})
    return Reason(text, Kind.MORE_PATHS, {"paths": rounded_up(paths)})


def rounded_up(number: float) -> str:
    """Return a positive number with two digits, rounded up: 1024 paths do not say that 1000 would decide."""
    unit = 10.0 ** max(floor(log10(number)) - 1, 0)
    return f"{ceil(number / unit) * unit:.0f}"


def no_fit(evidence: Evidence, covered: Coverage, left_out: Reason) -> Opinion:
    """Return the opinion on a quantity that has too few levels for a slope, and why they were left out.

    Parameters
    ----------
    evidence : Evidence
    covered : Coverage
    left_out : Reason
        Why levels were left out.
    """
    verdict = Verdict.INCONCLUSIVE if covered.claim else Verdict.OUT_OF_SCOPE
    if evidence.health.sums["lost"][-1] > 0:
        verdict = Verdict.DIVERGED
    return Opinion(verdict, Reason(f"fewer than {FEWEST} step sizes can be fitted").then(left_out, ": "))


def finding(covered: Coverage, opinion: Opinion, **shown: Any) -> Finding:
    """Return the row of a quantity: its claim, the opinion on it, and what is shown beside; see `Finding`.

    Parameters
    ----------
    covered : Coverage
        The quantity and its claim.
    opinion : Opinion
        Verdict and reason.
    **shown
        Fields of `Finding` and details of the measure, such as ``estimate`` and ``method``.
    """
    return Finding(quantity=covered.quantity, claim=covered.claim, **opinion._asdict(), **shown)


NOT_PROBED = Judgement(
    (Finding(quantity="", verdict=Verdict.INCONCLUSIVE, reason=Reason("the step cannot be probed")),),
    (),
)
