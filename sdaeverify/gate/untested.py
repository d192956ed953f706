"""Untested claims of the gated schemes, because a gate that skips a claim must not pass for it."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from ..contracts.finding import UNMEASURED, Kind, Verdict
from ..contracts.matching import match
from ..contracts.scheme import Claim, Scheme, is_about
from ..contracts.spelling import did_you_mean
from ..errors import FAULTS
from ..registry.load import Registry
from ..registry.selection import select_measures, select_problems
from ..study import CellResult, Plan
from ..study.plan import cells_of_claims
from .gate_plan import gated_schemes, omitted_measures
from .policy import Policy


class Untested(NamedTuple):
    """A claim that no cell tests, or that has a quantity without a finding.

    Attributes
    ----------
    scheme : Scheme
    claim : Claim
    why : str
    chosen : bool
        Whether the policy excludes the claim by its selection of measures, or its problems run on request only.
    """

    scheme: Scheme
    claim: Claim
    why: str
    chosen: bool = False

    def __str__(self) -> str:
        where = f" where the problem has {', '.join(sorted(self.claim.when))}" if self.claim.when else ""
        return f"not tested: {self.scheme.label}: {self.claim.measure} {self.claim}{where}: {self.why}"


def find_untested(registry: Registry, policy: Policy, made: Plan, results: Sequence[CellResult]) -> list[Untested]:
    """Return the claims of the gated schemes that no cell tests.

    Parameters
    ----------
    registry : Registry
    policy : Policy
    made : Plan
        Plan of the gate.
    results : sequence of CellResult
        Results of all cells of the plan, and of examinations.
    """
    by_cell, tested = {result.cell: result for result in results}, cells_of_claims(made)
    examined = _examined(made, results)
    return [
        each
        for scheme in gated_schemes(registry, policy)
        for claim in dict.fromkeys(scheme.promises)
        if (scheme, claim) not in examined
        for each in _why_not_tested(
            registry, policy, (scheme, claim), [by_cell[cell] for cell in tested.get((scheme, claim), [])]
        )
    ]


def _examined(made: Plan, results: Iterable[CellResult]) -> set[tuple[Scheme, Claim]]:
    """Return the claims that examinations have put to a test; classes of equations answer none of a cell."""
    planned = {*made.cells}
    beside = (result for result in results if result.cell not in planned and result.cell.class_name is None)
    return {(each.cell.scheme, found.claim) for each in beside for found in each.findings if found.claim is not None}


def known_quantities(results: Iterable[CellResult]) -> set[str]:
    """Return the names of the quantities on which there is a finding, except findings that are out of scope."""
    return {f.quantity for each in results for f in each.findings if f.verdict is not Verdict.OUT_OF_SCOPE}


def unknown_quantities(claim: Claim, found: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield each quantity of a claim that is not among those found, with a message."""
    names = sorted(set(found))
    for quantity in claim.quantities:
        if not any(is_about(name, quantity) for name in names):
            listed = f" (known: {', '.join(names)})" if names else ""
            yield quantity, f"no result is about {quantity!r}{did_you_mean(quantity, names)}{listed}"


def unknown_words(claim: Claim, results: Iterable[CellResult]) -> str:
    """Return the message that the measure has no test of the claimed value, or an empty string."""
    told = (f.claim for each in results for f in each.findings if f.reason.has(Kind.UNKNOWN_VALUE))
    unknown = any(other is not None and other.value == claim.value for other in told)
    return f"measure {claim.measure} has no test for the claim {str(claim)!r}" if unknown else ""


def _why_not_tested(
    registry: Registry, policy: Policy, promise: tuple[Scheme, Claim], results: list[CellResult]
) -> Iterator[Untested]:
    scheme, claim = promise
    if claim.measure not in registry.measures:
        why = f"measure {claim.measure!r} is not registered{did_you_mean(claim.measure, registry.measures)}"
        yield Untested(scheme, claim, why)
    elif not results:
        yield _without_cell(registry, policy, scheme, claim)
    elif not any(f.verdict in UNMEASURED or not f.quantity for each in results for f in each.findings):
        if why := unknown_words(claim, results):
            yield Untested(scheme, claim, why)
        lost = list(unknown_quantities(claim, known_quantities(results)))
        # A quick tier tests each claim on one problem, which need not have all quantities of the claim.
        if not policy.budget.quick or len(lost) == len(claim.quantities):
            yield from (Untested(scheme, claim, why) for _, why in lost)


def _without_cell(registry: Registry, policy: Policy, scheme: Scheme, claim: Claim) -> Untested:
    if claim.measure in omitted_measures(registry, policy):
        return Untested(scheme, claim, f"tier {policy.tier} leaves the measure out", chosen=True)
    if claim.measure not in {measure.name for measure in select_measures(registry, policy.measures)}:
        return Untested(scheme, claim, "the policy does not select the measure", chosen=True)
    if not policy.problems and (label := _on_request(registry, scheme, claim)):
        return Untested(scheme, claim, f"it applies only to problems run on request, such as {label}", chosen=True)
    return Untested(scheme, claim, "it applies to no selected problem")


def _on_request(registry: Registry, scheme: Scheme, claim: Claim) -> str:
    """Return the label of a problem run on request on which a claim holds, or an empty string."""
    names = [name for name, entry in registry.problems.items() if entry.on_request]
    measure = registry.measures[claim.measure].thing
    for spec in select_problems(registry, names) if names else []:
        try:
            problem = spec.build()
            view = match(scheme, problem).problem
            if view is not None and claim.when <= view.traits and not measure.refuses(scheme, problem):
                return spec.label
        except FAULTS:
            # Errors of the problem are reported when it is run.
            continue
    return ""
