"""Invariant law: the order in h with which stationary means tend to the exact ones.

If a step accepts or rejects a proposal, detailed balance shows whether it leaves the exact law invariant (T1).
If the problem has a chart of one or two coordinates, the stationary law of the scheme is computed from its
transition operator (T2), without sampling. For claims that remain open, replicated chains at several step sizes
with the same noise are run (T3): paired differences give the order, and the coarsest mean minus the differences shows
whether the limit is the exact law.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from ...arrays import Array
from ...contracts.claimed import bar
from ...contracts.finding import SAMPLED, Finding, Judgement, Kind, LevelFinding, Method, Opinion, Reason, Verdict
from ...contracts.measure import Evidence, Measure
from ...contracts.scheme import Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally, packed, unpacked
from ...forms import Problem
from ...forms.truths import InvariantMean, MomentEquation
from ...probe.balance import Balance, balance, why_not_balanced
from ...probe.operator.functional_orders import (
    ABOVE_FLOOR,
    Fall,
    FunctionalOrder,
    functional_orders,
    widen,
)
from ...probe.operator.transition import why_not_operator
from ...probe.operator.transition_errors import (
    Densities,
    TransitionErrors,
    invariant_errors,
    invariant_observables,
    stationary_densities,
)
from ...probe.step.one_step import why_not_resolved
from ...registry.hookspecs import hookimpl
from ...simulate.chains import ChainPlan, ChainRecord, chains_of, run_chains
from ...verdicts.coverage import Coverage, coverage
from ...verdicts.opinions import beside, finding, judge_claim, leave_open
from ..late_steps import late_steps, withhold_late
from ..resolution import stationary_resolution
from ..weak.probe import TOLERANCE
from .bias import bias_bound, bias_of_operator, judge_balance, with_bias, withhold_vacuous
from .chain_findings import chain_findings, chain_levels, is_decided

METHOD = Method("stationary law of the transition operator", 2)
NO_ORDER = FunctionalOrder(np.nan, np.nan, np.nan)


def usable(record: TransitionErrors) -> bool:
    """Return whether the scheme stays on the chart."""
    return not record.why_not_evidence


def operator_findings(
    evidence: Evidence, record: TransitionErrors, orders: Mapping[str, FunctionalOrder]
) -> list[Finding]:
    """Return a finding for each observable with a known exact mean, from the orders of a record.

    Parameters
    ----------
    evidence : Evidence
    record : TransitionErrors
        Errors of invariant means, by observable and step size.
    orders : mapping of str to FunctionalOrder
        Their orders, by observable.
    """
    floors = record.floors
    columns = dict(zip(orders, zip(record.errors.T, floors.T, strict=True), strict=True))
    later = _falls(record, unpacked(SHORT_OPERATOR, TransitionErrors, evidence.tally), orders)
    sizes = dict(zip(orders, record.sizes.tolist(), strict=True))
    found = []
    for name in (truth.observable for truth in evidence.view.truths if isinstance(truth, InvariantMean)):
        found.append(_finding(coverage(evidence, "invariant", name), orders.get(name), later.get(name, Fall())))
        bound = bias_bound(found[-1].claim)
        if bound is not None and name in orders:
            found[-1] = with_bias(found[-1], *bias_of_operator(bound, record.h, *columns[name], orders[name]))
        if name in orders:
            errors, off = columns[name]
            seen = stationary_resolution(errors, ABOVE_FLOOR * off, sizes[name], found[-1].claim)
            found[-1] = replace(found[-1], resolution=seen)
    return found


def _falls(record: TransitionErrors, short: TransitionErrors | None, names: Collection[str]) -> Mapping[str, Fall]:
    """Return the fastest fall of the errors from any step size to the short one, by observable; empty without it."""
    if short is None or not usable(short):
        return {}
    columns = (record.errors.T, record.floors.T, short.errors[0], ABOVE_FLOOR * short.floors[0])
    found = (_fastest_fall(record.h, float(short.h[0]), *column) for column in zip(*columns, strict=True))
    return dict(zip(names, found, strict=True))


def _fastest_fall(h: Array, short: float, errors: Array, floors: Array, last: float, floor: float) -> Fall:
    if not abs(last) > floor:
        return Fall()
    most = np.log((np.abs(errors) + floors) / (abs(last) - floor)) / np.log(h / short)
    place = int(np.argmax(most))
    return Fall(float(most[place]), float(h[place]), short)


def is_settled(evidence: Evidence, record: TransitionErrors) -> bool:
    """Return whether finer steps are not needed: all claims are verified, or the means are fixed by a symmetry."""
    orders = operator_orders(record, evidence.view)
    fixed = {name for name, order in orders.items() if order.fixed}
    claimed = {found.quantity: found.verdict for found in operator_findings(evidence, record, orders) if found.claim}
    return all(verdict is Verdict.VERIFIED for name, verdict in claimed.items() if name not in fixed)


def operator_levels(evidence: Evidence, record: TransitionErrors) -> Iterator[LevelFinding]:
    """Yield the error of each observable at each step size."""
    floors = record.floors
    for index, name in enumerate(invariant_observables(evidence.view)):
        errors = record.errors[:, index]
        for level, h in enumerate(record.h):
            details = {
                "error_floor": float(floors[level, index]),
                "local_order": _local_order(record.h, errors, level),
            }
            yield LevelFinding(name, None, float(errors[level]), 0.0, details, float(h))


def operator_orders(record: TransitionErrors, view: Problem) -> dict[str, FunctionalOrder]:
    """Return the order of each observable that is a function on the chart."""
    return dict(zip(invariant_observables(view), widen(functional_orders(record), view), strict=True))


def _finding(covered: Coverage, known: FunctionalOrder | None, later: Fall) -> Finding:
    if covered.claim is not None and known is None:
        opinion = Opinion(Verdict.NOT_APPLICABLE, Reason("not a function of the coordinates of the problem's chart"))
    else:
        opinion = judge_claim(covered, lambda claim: _opinion(claim.value.least, known or NO_ORDER, later))
    order = known or NO_ORDER
    return finding(
        covered,
        opinion._replace(tier=2),
        estimate=order.order,
        low=order.low,
        high=order.high,
        method=METHOD,
        details={"leading_coefficient": order.coefficient},
    )


def _opinion(claimed: float, found: FunctionalOrder, later: Fall) -> Opinion:
    bound = claimed - TOLERANCE
    if not found.resolved:
        return _heed_fall(Opinion(Verdict.INCONCLUSIVE, Reason(found.note)), found, bound)
    if not found.informative:
        return Opinion(Verdict.NOT_APPLICABLE, Reason(f"not informative: {found.note}"))
    figures = {"order": found.order, "claimed": claimed, "bar": bar(claimed, bound)}
    text = "order {order:.2f} of the error of the stationary mean, by the transition operator; {bar}"
    reason = Reason(text, Kind.ORDER, figures).then(found.note)
    if np.isinf(found.order):
        reason = Reason(f"{found.note}: order {claimed:g} holds", Kind.ORDER, figures)
    if found.low >= bound and later.most < bound:
        return _heed_fall(Opinion(Verdict.INCONCLUSIVE, reason), found._replace(fall=later), bound)
    if found.low >= bound:
        return Opinion(Verdict.VERIFIED, reason)
    if found.high < bound:
        return Opinion(Verdict.REFUTED, Reason(found.note, Kind.WRONG_LIMIT) if found.order == 0.0 else reason)
    text = "order {order:.2f} [{low:.2f}, {high:.2f}] by the transition operator; {bar}"
    reason = Reason(text, Kind.ORDER, {**figures, "low": found.low, "high": found.high}).then(found.note)
    return _heed_fall(Opinion(Verdict.INCONCLUSIVE, reason), found, bound)


def _heed_fall(opinion: Opinion, found: FunctionalOrder, bound: float) -> Opinion:
    """Return an undecided opinion as evidence against the claim if errors fall too slowly between two step sizes."""
    fall = found.fall
    if not fall.most < bound:
        return opinion
    text = "from h = {coarse:.2g} to {fine:.2g} the error of the stationary mean falls like h^{most:.2f} at most"
    return opinion.plus(Reason(text, numbers=fall._asdict()))._replace(excluded=frozenset({Verdict.VERIFIED}))


def _local_order(h: Array, errors: Array, level: int) -> float:
    if level == 0 or not errors[level - 1 : level + 1].all():
        return float("nan")
    return float(np.log(abs(errors[level - 1] / errors[level])) / np.log(h[level - 1] / h[level]))


OPERATOR, CHAINS, DENSITIES, BALANCE = "stationary law", "chains", "densities", "balance"
SHORT_OPERATOR = "stationary law of short steps"
# Quantities that have levels but no finding.
DENSITY = "density of coordinate"
# Size: number of step sizes of the operator.
STEP_SIZES = 5
# Further step sizes. If the first ones do not resolve the problem, up to MOST are tried. If a claim is not verified,
# finer ones follow, FURTHER at most; each is half of the previous one. The cost is the same at every step size.
# Size.
FURTHER, MOST = 6, 16
# A step shorter than the finest one by this factor, at which an error must have fallen as claimed.
# Size: of the factor; what changes at shorter steps is not seen.
SHORTER = 64.0


class Invariant(Measure):
    """Order of the bias of stationary means."""

    name: ClassVar[str] = "invariant"
    lengthy: ClassVar[bool] = True
    follows: ClassVar[str] = "stationary law"
    budgeted: ClassVar[bool] = True
    detail_columns: ClassVar[Mapping[str, str]] = {
        "leading_coefficient": "of the leading power of h in the error",
        "class": "bias where a bound of the bias is claimed",
        "local_orders": "orders between consecutive step sizes",
        "bias": "bias at the smallest step size",
        "bias_std_error": "its standard error",
        "resolved": "smallest mean difference in standard errors",
        "chains": "number of chains",
        "chain_length": "length of a chain after burn-in",
        "burn_in": "length of the burn-in",
        "contraction": "rate at which chains driven by the same noise approach each other",
        "looks": "number of interim analyses (looks) of the chains",
    }
    level_columns: ClassVar[Mapping[str, str]] = {
        "error_floor": "error of the operator's own discretisation",
        "local_order": "order between this step size and the one before",
        "fitted": "whether the order is fitted to this level",
        "difference": "mean difference to the next step size on the same noise",
        "difference_std_error": "its standard error",
        "at": "value of a coordinate, where the estimate is its stationary density under the scheme",
        "exact": "its stationary density under the equation",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: no invariant mean or moment equation is known."""
        known = any(isinstance(truth, InvariantMean | MomentEquation) for truth in problem.truths)
        absent = (
            "no mean under the invariant law is known for the problem; attach an InvariantMean or a MomentEquation"
        )
        return "" if known else absent

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the errors of the operator's stationary law, and means of chains if it leaves claims open."""
        found = self._stationary(scheme, view, settings)
        return found.merge(late_steps(scheme, view, self.name)) if found.sums else found

    def _stationary(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        view = view.with_moment_equations
        evidence = Evidence(
            scheme, view, view, settings, _balance(scheme, view, settings), Tally(), level=settings.level
        )
        operator = stationary_record(evidence)
        if operator is not None:
            known = packed(OPERATOR, operator).merge(_densities(evidence, operator))
            evidence = replace(evidence, tally=evidence.tally.merge(known))
            evidence = replace(evidence, tally=evidence.tally.merge(self._at_short_steps(evidence, operator)))
        left = _open_quantities({found.quantity: found for found in self.judge(evidence).findings})
        if not (left and np.isfinite(view.relaxation_time)):
            return evidence.tally
        return evidence.tally.merge(packed(CHAINS, _chains(evidence, left)))

    def _at_short_steps(self, evidence: Evidence, operator: TransitionErrors) -> Tally:
        """Return the errors at a much shorter step size, if an order is verified by the others."""
        h = float(operator.h[-1]) / SHORTER
        held = (found.verdict is Verdict.VERIFIED and found.claim for found in self.judge(evidence).findings)
        if not any(held) or why_not_resolved(evidence.view, h):
            return Tally()
        return packed(SHORT_OPERATOR, invariant_errors(evidence.scheme, evidence.view, [h]))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each observable with a known exact mean, and its levels."""
        evidence = replace(evidence, view=evidence.view.with_moment_equations)
        operator = unpacked(OPERATOR, TransitionErrors, evidence.tally)
        chains, balanced = unpacked(CHAINS, ChainRecord, evidence.tally), unpacked(BALANCE, Balance, evidence.tally)
        findings = {truth.observable: _without_chart(evidence, truth) for truth in _truths(evidence.view)}
        levels: list[LevelFinding] = []
        # The logarithm of a difference of exactly zero is not a defect.
        with np.errstate(all="ignore"):
            if operator is not None:
                orders = evidence.without_paths.read(_read_orders, evidence.view)
                findings |= {found.quantity: found for found in operator_findings(evidence, operator, orders)}
                levels += operator_levels(evidence, operator)
                levels += density_levels(unpacked(DENSITIES, Densities, evidence.tally))
            if chains is not None:
                sampled = {found.quantity: found for found in chain_findings(evidence, chains)}
                findings |= {name: _join_chains(findings[name], sampled[name]) for name in _open_quantities(findings)}
                levels += chain_levels(evidence, chains)
        judged = (withhold_vacuous(found, evidence) for found in judge_balance([*findings.values()], balanced))
        return Judgement(tuple(withhold_late(found, evidence.tally) for found in judged), tuple(levels))


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Invariant()]


def _read_orders(tally: Tally, view: Problem) -> dict[str, FunctionalOrder]:
    operator = unpacked(OPERATOR, TransitionErrors, tally)
    return {} if operator is None else operator_orders(operator, view)


def coarsest_step(view: Problem, settings: Settings) -> float:
    """Return twice the run's coarsest step, or the same fraction of the relaxation time if that is shorter.

    Stationary biases at the step sizes of pathwise errors are often too small to detect.
    """
    return 2.0 * min(view.horizon, view.relaxation_time) / settings.coarsest


def stationary_record(evidence: Evidence) -> TransitionErrors | None:
    """Return the errors of the stationary law, or None if there is no operator or the scheme leaves the chart."""
    scheme, view = evidence.scheme, evidence.view
    if why_not_operator(scheme, view) or not invariant_observables(view):
        return None
    sizes = [coarsest_step(view, evidence.settings) / 2.0**level for level in range(MOST)]
    resolving = [not why_not_resolved(view, h) for h in sizes]
    first = max(STEP_SIZES, resolving.index(True) + 1) if resolving[-1] else STEP_SIZES
    further = sizes[first : STEP_SIZES + FURTHER] if resolving[-1] else []
    record = invariant_errors(scheme, view, sizes[:first])
    if usable(record) and further and not is_settled(evidence, record):
        record = record.extend(invariant_errors(scheme, view, further))
    return record if usable(record) else None


def _balance(scheme: Scheme, view: Problem, settings: Settings) -> Tally:
    """Return both sides of detailed balance, for a scheme that claims to be unbiased."""
    if all(bias_bound(claim) is None for claim in scheme.claims) or why_not_balanced(scheme, view):
        return Tally()
    coarsest = coarsest_step(view, settings)
    found = balance(scheme, view, [coarsest / 2.0**level for level in range(STEP_SIZES)])
    return Tally() if found is None else packed(BALANCE, found)


def _densities(evidence: Evidence, record: TransitionErrors) -> Tally:
    """Return the densities at the largest step size that resolves them, where errors are largest."""
    found = (stationary_densities(evidence.scheme, evidence.view, float(h)) for h in record.h[:STEP_SIZES])
    return next((packed(DENSITIES, densities) for densities in found if densities.resolved), Tally())


def density_levels(record: Densities | None) -> Iterator[LevelFinding]:
    """Yield the density of each coordinate at each point, with the exact one in the details."""
    if record is None:
        return
    for number, (points, own, exact) in enumerate(zip(record.at, record.scheme, record.exact, strict=True), 1):
        for y, density, right in zip(points, own, exact, strict=True):
            details = {"at": float(y), "exact": float(right)}
            yield LevelFinding(f"{DENSITY} {number}", None, float(density), 0.0, details, float(record.h))


def _chains(evidence: Evidence, names: Collection[str]) -> ChainRecord:
    """Run chains until the claims about the given observables are decided or enough of them are."""
    view, settings = evidence.view, evidence.settings
    h, chains = coarsest_step(view, settings), chains_of(settings.paths)
    plan = ChainPlan(h, view.relaxation_time, settings.seed, settings.max_looks, *chains)

    def enough(record: ChainRecord) -> bool:
        return is_decided([found for found in chain_findings(evidence, record) if found.quantity in names], record)

    return run_chains(evidence.scheme, view, plan, enough)


def _open_quantities(findings: Mapping[str, Finding]) -> list[str]:
    # Chains do not decide claims whose verification other evidence excludes.
    open_ = (found for found in findings.items() if found[1].verdict is Verdict.INCONCLUSIVE)
    return [name for name, found in open_ if Verdict.VERIFIED not in found.excluded]


def _join_chains(found: Finding, sampled: Finding) -> Finding:
    """Return the finding of chains on an observable, combined with the objections of the transition operator.

    Parameters
    ----------
    found : Finding
        Undecided: by the operator (tier 2), or because there is none.
    sampled : Finding
        By chains.
    """
    if found.tier == SAMPLED:
        return sampled
    operator, chains = (Opinion(*(getattr(each, name) for name in Opinion._fields)) for each in (found, sampled))
    return replace(sampled, **beside(operator, chains)._asdict())


def _truths(view: Problem) -> list[InvariantMean]:
    return [truth for truth in view.truths if isinstance(truth, InvariantMean)]


def _without_chart(evidence: Evidence, truth: InvariantMean) -> Finding:
    covered = coverage(evidence, Invariant.name, truth.observable)
    reason = "the problem declares neither a chart that the scheme can use nor a relaxation time for chains"
    return finding(covered, leave_open(covered, reason))
