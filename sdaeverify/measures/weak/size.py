"""The size of weak errors without sampling: the constant of the leading term, and claimed bounds at a step size.

Moments of linear equations, and the transition operator on a chart, give the error E g(X_T^h) - E g(X_T) with its
sign at each step size. Extrapolated, it has the leading term C h^p. At the step size that a claim names, it is
compared with the claimed bound; where it is not known there, paths decide if the mean of the solution is known.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.claimed import Bound
from ...contracts.finding import Finding, Method, Opinion, Reason, Verdict
from ...contracts.measure import Evidence
from ...contracts.scheme import Claim, Scheme
from ...contracts.tally import Tally, packed, unpacked
from ...forms import Delayed, Problem
from ...numerics.statistics import Estimate
from ...probe.linear.moments import (
    MomentErrors,
    moment_errors_at,
    observable_errors,
    quadratic_form,
    why_not_moments,
)
from ...probe.operator.functional_orders import (
    Coefficient,
    functional_orders,
    leading_error,
    order_of,
)
from ...probe.operator.transition import why_not_operator
from ...probe.operator.transition_errors import TransitionErrors, chart_observables, weak_errors
from ...probe.step.one_step import why_not_resolved
from ...verdicts.coverage import Coverage, coverage
from ...verdicts.opinions import decide, finding
from ...verdicts.path_tests import PathTests, ask_for_truth, why_vacuous, with_sample
from ..means import Means, known_mean
from .probe import MOMENTS, OPERATOR

WEAK, AT_STEPS = "weak", "at claimed step sizes"
# Rounding: the number of steps to the horizon is a whole one up to that of h and T, relative.
WHOLE = 1e-9
BY_MOMENTS, BY_OPERATOR, ALONG_PATHS = Method("moments", 2), Method("transition operator", 2), Method("paths", 3)
UNKNOWN = Reason("without sampling, this error is known only for quadratic means of linear equations and on charts")


def error_constant(evidence: Evidence, observable: str) -> Coefficient | None:
    """Return the leading term C h^p of the weak error of an observable, or None where it is not known.

    Parameters
    ----------
    evidence : Evidence
        Of a cell.
    observable : str
    """
    return evidence.without_paths.read(_read_constant, evidence.view, observable)


def constant_columns(evidence: Evidence, observable: str) -> dict[str, object]:
    """Return the leading term of the weak error of an observable as details of a finding, if it is known."""
    found = error_constant(evidence, observable)
    return {} if found is None else found.details


def _read_constant(tally: Tally, view: Problem, observable: str) -> Coefficient | None:
    moments, operator = unpacked(MOMENTS, MomentErrors, tally), unpacked(OPERATOR, TransitionErrors, tally)
    if moments is not None:
        form = quadratic_form(view, observable)
        errors = observable_errors(moments, form) if form is not None else None
        found = None if errors is None else leading_error(*errors[:3], order_of(*errors).order)
        h = moments.h
    elif operator is not None and observable in chart_observables(view) and not operator.why_not_evidence:
        place, h = chart_observables(view).index(observable), operator.h
        floors, order = operator.floors[:, place], functional_orders(operator)[place].order
        found = leading_error(h, operator.errors[:, place], floors, order)
    else:
        return None
    return None if found is None or why_not_resolved(view, float(h[-1])) else found


# Claimed bounds.


def claimed_bounds(claims: Iterable[Claim], view: Problem) -> list[tuple[Claim, Bound, int]]:
    """Return the claims of bounds of weak errors at a step size that hold on a problem.

    Parameters
    ----------
    claims : iterable of Claim
    view : Problem
        What the scheme sees.

    Returns
    -------
    list of (Claim, Bound, int)
        With the number of steps to the horizon, 0 where that is not a whole one.
    """
    held = ((claim, claim.value) for claim in claims if claim.measure == WEAK and claim.when <= view.traits)
    bounds = ((claim, value, value.at) for claim, value in held if isinstance(value, Bound))
    return [(claim, bound, _count(view.horizon / h)) for claim, bound, h in bounds if h is not None]


def _count(steps: float) -> int:
    return round(steps) if steps > 0.5 and abs(steps - round(steps)) <= WHOLE * steps else 0


def probe_bounds(scheme: Scheme, view: Any) -> Tally:
    """Return weak errors without sampling at the step sizes of claimed bounds; empty without such claims.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        What the scheme sees.
    """
    held = [(claim, bound, count) for claim, bound, count in claimed_bounds(scheme.promises, view) if count]
    if not held or view.capability(Delayed):
        return Tally()
    steps, found = sorted({count for _, _, count in held}), Tally()
    left = {name for claim, bound, _ in held for name in view.observables if claim.covers(WEAK, name + bound.suffix)}
    if not why_not_moments(scheme, view):
        found = packed(f"{MOMENTS} {AT_STEPS}", moment_errors_at(scheme, view, steps))
        left = {name for name in left if quadratic_form(view, name) is None}
    if not left or view.chart is None or why_not_operator(scheme, view):
        return found
    return found.merge(packed(f"{OPERATOR} {AT_STEPS}", weak_errors(scheme, view, steps)))


def bound_findings(evidence: Evidence, means: Mapping[str, Means]) -> Iterator[Finding]:
    """Yield the finding on each observable whose weak error a claim bounds at a step size.

    Parameters
    ----------
    evidence : Evidence
    means : mapping of str to Means
        Means along paths, by observable.
    """
    asked = {bound.suffix: count for _, bound, count in claimed_bounds(evidence.promises, evidence.view)}
    for name, (suffix, count) in product(evidence.view.observables, asked.items()):
        # The least of several bounds counts.
        covered = coverage(evidence, WEAK, f"{name}{suffix}")
        if covered.claim is not None and isinstance(covered.claim.value, Bound):
            wanted = _BoundedError(covered, covered.claim.value, count, name)
            yield replace(_finding(evidence, wanted, means), value_of="weak error")


class _BoundedError(NamedTuple):
    # A claimed bound of the weak error of an observable, with its number of steps.
    covered: Coverage
    bound: Bound
    steps: int
    name: str


def _finding(evidence: Evidence, asked: _BoundedError, means: Mapping[str, Means]) -> Finding:
    if not asked.steps:
        text = f"the step size {asked.bound.at:g} does not divide the horizon {evidence.view.horizon:g}"
        return finding(asked.covered, Opinion(Verdict.INCONCLUSIVE, Reason(text)))
    known = _known_error(evidence.without_paths, evidence.view, asked)
    if known is not None:
        ends = {"low": known.error - known.off, "high": known.error + known.off}
        return finding(asked.covered, _opinion(asked, known), method=known.method, estimate=known.error, **ends)
    error, why = _sampled_error(evidence, asked, means.get(asked.name))
    if error is None:
        return finding(asked.covered, Opinion(Verdict.INCONCLUSIVE, UNKNOWN.then(why)))
    low, high = error.interval(evidence.settings.confidence)
    tests = _tests(asked.bound, error, evidence, means[asked.name].size)
    ends = {"estimate": error.value, "low": low, "high": high}
    return finding(asked.covered, decide(tests, evidence), method=ALONG_PATHS, **ends)


class _Known(NamedTuple):
    # A weak error, how far it can be off, the size of the observable, and how it was found.
    error: float
    off: float
    size: float
    method: Method


def _known_error(tally: Tally, view: Problem, asked: _BoundedError) -> _Known | None:
    moments = unpacked(f"{MOMENTS} {AT_STEPS}", MomentErrors, tally)
    form = None if moments is None else quadratic_form(view, asked.name)
    errors = None if moments is None or form is None else observable_errors(moments, form)
    if errors is not None:
        row = _row(errors.h, view, asked)
        return _Known(float(errors.errors[row]), float(errors.floors[row]), errors.size, BY_MOMENTS)
    operator = unpacked(f"{OPERATOR} {AT_STEPS}", TransitionErrors, tally)
    if operator is None or asked.name not in chart_observables(view) or operator.why_not_evidence:
        return None
    row, place = _row(operator.h, view, asked), chart_observables(view).index(asked.name)
    error, off = (float(each[row, place]) for each in (operator.errors, operator.floors))
    known = _Known(error, off, float(operator.sizes[place]), BY_OPERATOR)
    return known if np.isfinite([error, off]).all() else None


def _row(h: Array, view: Problem, asked: _BoundedError) -> int:
    return int(np.argmin(np.abs(view.horizon / h - asked.steps)))


def _opinion(asked: _BoundedError, known: _Known) -> Opinion:
    most, size = asked.bound.most, abs(known.error)
    text = "weak error {error:.3g} without sampling, known to {off:.1g}; at most {most:g} claimed"
    reason = Reason(text, numbers={"error": known.error, "off": known.off, "most": most})
    if size + known.off <= most:
        vacuous = why_vacuous(most, known.size)
        verdict = Verdict.INCONCLUSIVE if vacuous else Verdict.VERIFIED
        return Opinion(verdict, vacuous.then(reason), 2)
    return Opinion(Verdict.REFUTED if size - known.off > most else Verdict.INCONCLUSIVE, reason, 2)


def _sampled_error(
    evidence: Evidence, asked: _BoundedError, means: Means | None
) -> tuple[Estimate | None, Reason | str]:
    """Return the weak error at a level of the run, or why it cannot be estimated from paths."""
    steps = evidence.settings.steps
    if asked.steps not in steps:
        return None, f"paths have {', '.join(map(str, steps))} steps, not {asked.steps} (--levels)"
    level, truth = [*steps].index(asked.steps), known_mean(evidence.problem, asked.name)
    if means is None or means.heavy or evidence.health.sums["lost"][level] > 0:
        return None, "no mean can be estimated from the paths"
    if means.coupled:
        return means.difference(level), ""
    if truth is None:
        return None, ask_for_truth(f"a Moment of {asked.name}")
    return Estimate(means.mean(level).value - truth, means.mean(level).se), ""


def _tests(bound: Bound, error: Estimate, evidence: Evidence, size: float) -> PathTests:
    """Return the tests of a bound by paths: errors of either sign refute it, and both are excluded to verify it."""
    text = "weak error {error:.3g} along paths, standard error {off:.1g}; at most {most:g} claimed"
    reason = Reason(text, numbers={"error": error.value, "off": error.se, "most": bound.most})
    larger = Estimate(abs(error.value), error.se)
    refuted, growth = min(1.0, 2.0 * larger.p_above(bound.most)), larger.growth_to_decide(bound.most, evidence.level)
    tests = PathTests(larger.p_below(bound.most), refuted, reason, growth)
    return with_sample(tests, evidence.paths, heavy=False).unless_vacuous(bound.most, size)
