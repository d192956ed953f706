"""Opinions on a claim: paths guard the decision of one step, and decide alone if one step does not."""

from collections.abc import Callable, Container
from math import ceil, floor, isfinite, log10
from typing import Any

from ..contracts.claimed import Bound, Order, Word
from ..contracts.finding import Finding, Judgement, Kind, Opinion, Reason, Verdict
from ..contracts.measure import Evidence
from ..contracts.stages import MOST_PATHS
from ..probe.local.delay_links import remove_delay
from ..probe.local.smoothness import rough_coefficient
from ..probe.step.memory import NEAR
from .coverage import Coverage
from .fitted_levels import FEWEST
from .path_tests import CALIBRATED_PATHS, SUSPECT, PathTests, unknown_value


def judge_claim(
    covered: Coverage, judge: Callable[[Any], Opinion], words: Container[str] = (), tier: int = 3
) -> Opinion:
    """Return the opinion on a claim, out of scope without a claim and inconclusive if its kind is unknown.

    Parameters
    ----------
    covered : Coverage
    judge : callable, Claim -> Opinion
        Judge a claim whose kind of value the measure has a test for.
    words : container of str
        Names of the `Word` and `Bound` values that the measure has a test for. If empty, it tests orders.
    tier : int
        Tier of the opinion when `judge` is not called.
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
    """Return an inconclusive opinion for a given reason, or out of scope if no claim covers the quantity."""
    undecided = Opinion(Verdict.INCONCLUSIVE, Reason.of(reason))
    return undecided if covered.claim else Opinion(Verdict.OUT_OF_SCOPE, covered.gap)


def local_opinion(verdict: Verdict, text: str, kind: str = Kind.PLAIN) -> Opinion:
    """Return an opinion of tier T1, from one step.

    Parameters
    ----------
    verdict : Verdict
    text : str
        Reason of the verdict.
    kind : str, optional
        Kind of the reason; reasons of the same kind differ only in their numbers.
    """
    return Opinion(verdict, Reason(text, kind), 1)


def local_doubt(text: str, kind: str = Kind.PLAIN, *, against: bool = False) -> Opinion:
    """Return an inconclusive opinion from one step.

    Parameters
    ----------
    text : str
        Reason why one step does not decide.
    kind : str, optional
        Kind of the reason. A step that does not follow the equation speaks against all claims of the scheme there.
    against : bool, optional
        Whether the doubt speaks against the claim, so that paths must not verify it.
    """
    found = local_opinion(Verdict.INCONCLUSIVE, text, kind)
    return found._replace(excluded=frozenset({Verdict.VERIFIED})) if against else found


def too_coarse(h: float) -> Opinion:
    """Return an opinion that no tier decides because only step sizes below those of a run can show the order.

    Taming is an example: a scheme that bounds its drift by 1/h, or its noise by 1, does so in the units of the state
    and of time.

    Parameters
    ----------
    h : float
        Shortest step size at which the order of one step is too low.
    """
    text = f"the order of one step is too low at h = {h:.2g}, but not at much shorter steps"
    doubt = local_doubt(f"{text}: the steps of the run are too long")
    return doubt._replace(excluded=frozenset({Verdict.VERIFIED, Verdict.REFUTED}))


def of_smooth(opinion: Opinion, claim: float, evidence: Evidence, *, at_few: bool = False) -> Opinion:
    """Withhold a verdict of a local order if a coefficient is not smooth enough for it.

    Order 1/2 needs Lipschitz coefficients alone (Milstein 1988, Theorem 1). A low order of steps that begin on a kink
    does not refute a claim if other steps have the order, because hardly any step of a run begins there. Where a
    coefficient jumps in time, no low order refutes: it may be that of the single step of a run across the jump.

    Parameters
    ----------
    opinion : Opinion
        Opinion from one step.
    claim : float
        Claimed order.
    evidence : Evidence
        Evidence of the cell.
    at_few : bool
        Whether the claim is refuted by the order at a few states alone.
    """
    verified = opinion.verdict is Verdict.VERIFIED
    if not (verified or opinion.verdict is Verdict.REFUTED):
        return opinion
    rough = rough_coefficient(remove_delay(evidence.scheme, evidence.view)[1])
    if rough is None or (claim <= rough.highest if verified else not (at_few or rough.in_time)):
        return opinion
    return local_doubt(f"{opinion.reason}, for smooth coefficients only, but {rough} on the range of solutions")


def up_to(most: float, opinion: Opinion, claim: float, words: str, *, against: bool = False) -> Opinion:
    """Withhold verification by a local order above the highest order that consecutive steps allow.

    Parameters
    ----------
    most : float
        Highest order that consecutive steps allow.
    opinion : Opinion
        Opinion from one step.
    claim : float
        Claimed order.
    words : str
        For which steps the local order holds, and which other steps a run has.
    against : bool
        Whether a claim above `most` is known to be wrong, so that paths must not verify it either.
    """
    if opinion.verdict is not Verdict.VERIFIED or claim <= most:
        return opinion
    return local_doubt(f"{opinion.reason}, {words}", against=against)


def of_law(opinion: Opinion, claim: float, evidence: Evidence, *, paths: bool) -> Opinion:
    """Withhold verification by a local order above the order that clipped increments allow.

    One step is compared at nodes of the normal law, and paths hardly meet its tails.

    Parameters
    ----------
    opinion, claim, evidence
        See `of_smooth`.
    paths : bool
        Whether the order is one along paths (strong) or in law (weak).
    """
    most = evidence.scheme.law.most(paths=paths)
    words = f"for normal increments; with clipped increments the order is at most {most:g}"
    return up_to(most, opinion, claim, words, against=True)


def of_memory(opinion: Opinion, bar: float, most: float, order: float) -> Opinion:
    """Withhold a verdict of a local order above the order of the errors due to a scheme's memory.

    Steps are probed without a history. Memory can spoil their order, and can cancel errors no smaller than its own
    effect. Therefore a local order refutes a claim only if it lies surely below `most`.

    Parameters
    ----------
    opinion : Opinion
        Opinion from one step.
    bar : float
        Least order that counts as the claimed one.
    most : float
        Order of the effect of memory; infinite without memory.
    order : float
        Order of one step.
    """
    decided = opinion.verdict in {Verdict.VERIFIED, Verdict.REFUTED}
    enough = bar <= most if opinion.verdict is Verdict.VERIFIED else order + NEAR <= most
    if not decided or enough or opinion.reason.kind is Kind.INCONSISTENT:
        return opinion
    return local_doubt(f"{opinion.reason}; but the scheme's memory adds errors of order {most:.2f} to a run")


def decide(tests: PathTests, evidence: Evidence) -> Opinion:
    """Return the verdict of the paths alone, never verified if the paths also speak against the claim."""
    found, doubted = Verdict.INCONCLUSIVE, is_suspect(tests)
    if tests.refuted <= evidence.level:
        found = Verdict.REFUTED
    elif tests.verified <= evidence.level and not doubted:
        found = Verdict.VERIFIED
    # A measure with separate paths may give an opinion before the run has drawn any.
    more = found is Verdict.INCONCLUSIVE and isfinite(tests.growth) and evidence.paths > 0
    paths = tests.growth * evidence.paths
    needed = "" if found is not Verdict.INCONCLUSIVE else tests.remedy or _ask_to_decide(tests, evidence)
    finer = found is Verdict.INCONCLUSIVE and tests.reason.has(Kind.FINER)
    settled = _beyond_budget(evidence, paths) if more else not finer
    opinion = Opinion(found, tests.reason.then(needed), 3, settled, tests.verified, tests.refuted)
    return opinion._replace(p_verified=1.0, excluded=frozenset({Verdict.VERIFIED})) if doubted else opinion


def guard(local: Opinion | None, tests: PathTests, evidence: Evidence) -> Opinion:
    """Return the verdict of a deterministic tier guarded by paths, or that of the paths if it has none.

    A claim refuted without sampling stays refuted, and one left open for good stays open. A verified claim needs
    paths that can be compared, that would show an error which the claim forbids, and that do not refute it. If the
    paths point against the claim, or are too few to show anything, more of them are requested; without more, the
    claim stays inconclusive.

    Parameters
    ----------
    local : Opinion or None
        Opinion from one step; None if there is none.
    tests : PathTests
        Tests on paths.
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
    """Combine the opinion of paths with one of one step that leaves the claim open.

    If one step speaks against the claim, paths cannot verify it.

    Parameters
    ----------
    local : Opinion or None
        Inconclusive opinion from one step; None if there is none.
    opinion : Opinion
        Opinion from paths.
    """
    if local is None:
        return opinion
    if not local.speaks_against:
        return opinion.plus(local.reason)
    if opinion.verdict is Verdict.VERIFIED:
        reason = local.reason.then(opinion.reason, ", although ")
        opinion = opinion._replace(verdict=Verdict.INCONCLUSIVE, reason=reason)
    else:
        # More paths do not verify the claim either.
        reason = opinion.reason.without(Kind.MORE_PATHS).without(Kind.TRUTH)
        opinion = opinion._replace(reason=reason.then(local.reason))
    return opinion._replace(p_verified=1.0, excluded=opinion.excluded | local.excluded)


def _doubt(tests: PathTests, evidence: Evidence) -> tuple[Reason, bool]:
    """Return why paths that do not refute still cannot guard, and whether more paths would not help.

    The reason is empty if the paths can guard.
    """
    asked = (ask(tests, evidence) for ask in (doubt_few_paths, doubt_likeness, doubt_power))
    return next((doubt for doubt in asked if doubt is not None), (Reason(), True))


def doubt_few_paths(tests: PathTests, evidence: Evidence) -> tuple[Reason, bool] | None:  # noqa: ARG001
    """Return the doubt that there are too few paths for a calibrated interval, or None."""
    if evidence.paths >= CALIBRATED_PATHS:
        return None
    few = f"{{paths}} paths are too few to exclude a violation, {CALIBRATED_PATHS} are needed"
    return Reason(few, Kind.GUARD, {"paths": evidence.paths}), True


def doubt_likeness(tests: PathTests, evidence: Evidence) -> tuple[Reason, bool] | None:
    """Return the doubt that errors along paths do not look like the claim, or None."""
    if tests.against > 1.0 - evidence.settings.confidence:
        return None
    unlike = Reason("paths do not agree with the claim at these step sizes", Kind.GUARD).then(tests.reason, ": ")
    # A significant contradiction that does not refute is held back by a guard, and more paths leave it so.
    held = tests.suspected <= evidence.level and tests.refuted > SUSPECT
    more = (
        Reason("either the steps are too coarse or the claim is wrong, finer steps would decide", Kind.FINER)
        if held
        else Reason("more paths would decide", Kind.MORE_PATHS)
    )
    return unlike.then(more), False


def doubt_power(tests: PathTests, evidence: Evidence) -> tuple[Reason, bool] | None:
    """Return the doubt that the paths could not show an error as large as the claim forbids, or None."""
    if tests.blind <= 1.0:
        return None
    doubt = Reason("{paths} paths cannot exclude a violation", Kind.GUARD, {"paths": evidence.paths})
    if not isfinite(tests.blind):
        return doubt.then("nor could more paths", ", "), True
    needed = tests.blind * evidence.paths
    asked = _ask_for_paths("--paths {paths} would", "nor could {most:.0e}, the maximum of --paths", needed)
    return doubt.then(asked, ", "), _beyond_budget(evidence, needed)


def is_suspect(tests: PathTests) -> bool:
    """Return whether paths speak against a claim, at level `SUSPECT`."""
    return tests.suspected <= SUSPECT


def _beyond_budget(evidence: Evidence, needed: float) -> bool:
    """Return whether half of the largest number of paths shows that even the largest number is too few.

    Stopping there saves the last look, which costs as much as all others.
    """
    most = evidence.settings.paths
    return most <= 2 * evidence.paths < 2 * most < 2 * needed


def _ask_to_decide(tests: PathTests, evidence: Evidence) -> Reason:
    """Return how many paths would decide, as a reason.

    The reason is without a number if the paths should suffice by their figures but do not decide.
    """
    if not isfinite(tests.growth) or evidence.paths == 0:
        return Reason()
    if tests.growth > 1.0:
        beyond = "more than {most:.0e} paths, the maximum of --paths, would be needed"
        return _ask_for_paths("about {paths} paths would decide (--paths)", beyond, tests.growth * evidence.paths)
    if tests.verified <= evidence.level:
        text = "the same paths are evidence against the claim (p = {p:.1g}): finer steps would decide (--levels)"
        return Reason(text, numbers={"p": tests.suspected})
    # An order below the bound, with a second fit that is not sure of it yet.
    return Reason("more paths would decide (--paths)", Kind.MORE_PATHS) if tests.refuted < 0.5 else Reason()


def ask_to_resolve(signal: float, needed: float, paths: int) -> Reason:
    """Return how many paths would distinguish an effect from 0, which does not decide its size.

    Parameters
    ----------
    signal, needed : float
        Size of the effect in standard errors, present and required. Below 1 the effect may be noise alone, for which
        every prediction grows with the number of paths: no number is given.
    paths : int
        Present number of paths.
    """
    if signal < 1.0:
        return Reason("below one standard error, the number of paths needed cannot be predicted")
    beyond = "more than {most:.0e} paths, the maximum of --paths, are needed to resolve the bias"
    enough = "about {paths} paths would resolve the bias (--paths)"
    return _ask_for_paths(enough, beyond, paths * (needed / signal) ** 2)


def _ask_for_paths(text: str, beyond: str, paths: float) -> Reason:
    """Return `text` with a number of paths, or `beyond` if the number exceeds the most that a run takes."""
    if paths > MOST_PATHS:
        return Reason(beyond, Kind.MORE_PATHS, {"paths": f"{paths:.2g}", "most": MOST_PATHS})
    return Reason(text, Kind.MORE_PATHS, {"paths": rounded_up(paths)})


def rounded_up(number: float) -> str:
    """Return a positive number with two digits, rounded up so that 1024 paths never read as 1000."""
    unit = 10.0 ** max(floor(log10(number)) - 1, 0)
    return f"{ceil(number / unit) * unit:.0f}"


def no_fit(evidence: Evidence, covered: Coverage, left_out: Reason) -> Opinion:
    """Return the opinion on a quantity that has too few levels for a slope.

    Parameters
    ----------
    evidence : Evidence
    covered : Coverage
    left_out : Reason
        Why levels were left out.
    """
    verdict = Verdict.INCONCLUSIVE if covered.claim else Verdict.OUT_OF_SCOPE
    reason = Reason(f"fewer than {FEWEST} step sizes can be fitted").then(left_out, ": ")
    return diverged(Opinion(verdict, reason), evidence.health.sums["lost"][-1])


def diverged(opinion: Opinion, lost: float) -> Opinion:
    """Return an opinion, with the verdict *diverged* if paths are lost.

    Parameters
    ----------
    opinion : Opinion
        The opinion if all paths are finite.
    lost : float
        Number of paths at the finest step size that are not finite or blew up.
    """
    return opinion._replace(verdict=Verdict.DIVERGED) if lost > 0 else opinion


def finding(covered: Coverage, opinion: Opinion, **shown: Any) -> Finding:
    """Return the finding on a quantity from its coverage and the opinion on it.

    Parameters
    ----------
    covered : Coverage
        The quantity and its claim.
    opinion : Opinion
        Verdict and reason.
    **shown
        Further fields of `Finding` and details of the measure, such as ``estimate`` and ``method``.
    """
    return Finding(quantity=covered.quantity, claim=covered.claim, **opinion._asdict(), **shown)


NOT_PROBED = Judgement(
    (Finding(quantity="", verdict=Verdict.INCONCLUSIVE, reason=Reason("the step cannot be probed")),),
    (),
)
