"""The plan of a gate: the claimed cells that belong to a tier."""

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import Any

from ..contracts.claimed import Order
from ..contracts.scheme import Claim, Scheme
from ..errors import FAULTS, UsageError
from ..forms import components
from ..forms.controls import deciding
from ..registry.contributions import Registered
from ..registry.discovery import OWN_DISTRIBUTION, normalise
from ..registry.load import Registry
from ..registry.selection import select_measures, select_problems, select_schemes
from ..study import Cell, Plan, ProblemPlan, plan
from ..study.plan import ControlPlan, claims_of
from ..study.trial import trial_of
from ..verdicts.coverage import claim_for
from .policy import Policy

# The quick tier tests each claim once, on the cheapest problem that can decide it. The problems in scope are ranked
# by these criteria, in this order:
#
# 1. Fewest weaker schemes that would pass, for claims of an order. Weaker schemes have the same form and claim the
#    order on some of the problems and a lower one on others, as Euler-Maruyama claims strong order 1 with additive
#    noise alone.
# 2. A pathwise truth, because all other problems cost a run at much finer steps.
# 3. No stronger claim of the scheme that covers the same quantity there.
# 4. Fewest components, then most kinds of exact solutions, then the label.
#
# The choice depends on no measurement, and changes only with the problems and the claims. A claim that is the
# strongest only on problems without a pathwise truth is left to the larger tiers.


Rank = tuple[bool, bool, int, int, str]
Test = tuple[Rank, Cell]


def every_claim_once(plans: Sequence[ProblemPlan], others: Sequence[Scheme] = ()) -> list[ProblemPlan]:
    """Select one cell for each claim of each scheme.

    Parameters
    ----------
    plans : sequence of ProblemPlan
        Problems with their claimed cells.
    others : sequence of Scheme, optional
        Schemes whose claims show on which problems a weaker scheme would pass.

    Returns
    -------
    list of ProblemPlan
        The same problems with the selected cells, and with all cells in error, for which the scope of a claim is
        unknown.
    """
    tests: dict[tuple[Scheme, Claim], list[Test]] = {}
    for claim, rank, cell in (test for made in plans for test in _tests(made)):
        tests.setdefault((cell.scheme, claim), []).append((rank, cell))
    kept = set[int]()
    for (scheme, claim), found in tests.items():
        passing = _weaker_that_pass(claim, [cell for _, cell in found], _of_same_form(scheme, others))
        _, (_, cell) = min(zip(passing, found, strict=True), key=lambda each: (each[0], each[1][0]))
        kept.add(id(cell))
    return [
        replace(made, cells=tuple(c for c in made.cells if c.verdict is not None or id(c) in kept)) for made in plans
    ]


def _of_same_form(scheme: Scheme, others: Sequence[Scheme]) -> list[Scheme]:
    return [other for other in others if {*other.forms} & {*scheme.forms} and other.promises]


def _weaker_that_pass(claim: Claim, cells: Sequence[Cell], others: Sequence[Scheme]) -> list[int]:
    """Count for each cell the schemes that claim the order there and a lower one in another cell."""
    counts = [0 for _ in cells]
    if not isinstance(claim.value, Order) or len(cells) == 1:
        return counts
    for other in others:
        orders = [_claimed_order(other, cell, claim.measure) for cell in cells]
        if any(0.0 < order < claim.value.least for order in orders):
            counts = [n + (order >= claim.value.least) for n, order in zip(counts, orders, strict=True)]
    return counts


def _claimed_order(scheme: Scheme, cell: Cell, measure: str) -> float:
    """Return the highest order that a scheme claims for a measure on the problem of a cell, or 0."""
    traits = cell.seen.traits if cell.seen is not None else frozenset[str]()
    claims = (claim for claim in scheme.promises if claim.measure == measure and claim.when <= traits)
    return max((claim.value.least for claim in claims if isinstance(claim.value, Order)), default=0.0)


def size(problem: Any) -> int:
    """Return the number of components of a problem; 0 without a problem, or if its start cannot be computed."""
    try:
        return components(problem) if problem else 0
    except FAULTS:
        # Errors of a plugin's problem are reported in its cells.
        return 0


def _tests(made: ProblemPlan) -> Iterator[tuple[Claim, Rank, Cell]]:
    """Yield each claim that a cell tests, with the rank of its problem."""
    problem = made.problem
    if problem is None:
        return
    kinds = {type(truth) for truth in problem.truths}
    ends = size(problem), -len(kinds), made.spec.label
    for cell in made.cells:
        for claim in claims_of(cell) if cell.seen else ():
            rank = (problem.pathwise is None, not _counts(claim, cell.scheme, cell.seen), *ends)
            yield claim, rank, cell


def _counts(claim: Claim, scheme: Scheme, view: Any) -> bool:
    quantities = claim.quantities or ("",)
    return any(claim_for(scheme, view.traits, claim.measure, name).claim is claim for name in quantities)


def gate_plan(registry: Registry, policy: Policy, executor: Executor | None = None) -> Plan:
    """Plan a gate, with only the claimed cells that the tier covers.

    Parameters
    ----------
    registry : Registry
    policy : Policy
    executor : Executor, optional
        Isolated workers decide which cells can be run; without an executor this process decides.

    Returns
    -------
    Plan
        The largest problem first, so that workers finish at about the same time. Empty if there is no claim.

    Raises
    ------
    UsageError
        If a name is unknown or a pattern matches nothing.
    ParameterError
        If a parameter is unknown or its value is not accepted.
    """
    tier = policy.budget
    chosen = (
        gated_schemes(registry, policy),
        select_problems(registry, policy.problems),
        [m for m in select_measures(registry, policy.measures) if m.name not in omitted_measures(registry, policy)],
    )
    resolve = (lambda label: select_schemes(registry, label)[0]) if not tier.quick else None
    made = plan(*chosen, resolve, trial_of(executor, *chosen), registry.followed)
    claimed = [_claimed_part(problem) for problem in made.problems]
    kept = every_claim_once(claimed, _known_weaker(registry, chosen[0])) if tier.quick else claimed
    ready = [_with_asked_controls(problem, controls=not tier.quick) for problem in kept if problem.cells]
    # Rough cost of a problem: number of cells times number of components.
    return Plan(tuple(sorted(ready, key=lambda made: len(made.cells) * size(made.problem), reverse=True)))


def _known_weaker(registry: Registry, gated: Sequence[Scheme]) -> list[Scheme]:
    """Return the shipped and gated schemes; other installed schemes must not change what a gate runs."""
    shipped = [
        entry.thing
        for entry in registry.schemes.values()
        if normalise(entry.origin.distribution) == OWN_DISTRIBUTION and not (entry.on_request or entry.thing.claimant)
    ]
    return [*shipped, *(scheme for scheme in gated if scheme not in shipped)]


def omitted_measures(registry: Registry, policy: Policy) -> list[str]:
    """Return the measures that are too slow for the tier; empty if the policy names measures."""
    if not policy.budget.quick or policy.measures:
        return []
    return [measure.name for measure in select_measures(registry) if measure.lengthy]


def gated_schemes(registry: Registry, policy: Policy) -> list[Scheme]:
    """Return the schemes of a policy: those of its patterns, or else of its project and plugin files.

    Without any of these, all schemes are gated that are not run on request only.

    Raises
    ------
    UsageError
        As `select_schemes`.
    """
    if policy.schemes:
        return select_schemes(registry, policy.schemes)
    own = _own(registry, policy)
    if policy.distribution and not own:
        if policy.examinations:
            # A project may have only solvers, which are not schemes of the matrix.
            return []
        raise UsageError(
            f"project {policy.distribution} registers no scheme here; install it, or name schemes in {policy.file}"
        )
    return select_schemes(registry, [variant for entry in own for variant in entry.variants])


def gates_everything(registry: Registry, policy: Policy) -> bool:
    """Return whether all schemes are gated because the policy names none and its project has none."""
    return not (policy.schemes or policy.distribution or _own(registry, policy))


def _own(registry: Registry, policy: Policy) -> list[Registered]:
    return [entry for entry in registry.schemes.values() if _is_of(entry, policy)]


def _is_of(entry: Registered, policy: Policy) -> bool:
    claimant = entry.thing.claimant or entry.origin.distribution
    named = bool(policy.distribution) and normalise(claimant) == normalise(policy.distribution)
    return named or entry.origin.module in policy.plugins


def _claimed_part(made: ProblemPlan) -> ProblemPlan:
    return replace(made, cells=tuple(cell for cell in made.cells if claims_of(cell)))


def _with_asked_controls(made: ProblemPlan, *, controls: bool) -> ProblemPlan:
    """Run only the controls that decide a claim, and list the others as missing."""
    claims = {claim for cell in made.cells for claim in claims_of(cell)}
    measures = {claim.measure for claim in claims} if controls else set()
    kept = [plan for plan in made.controls if plan.control.measure in measures]
    asked = {(claim.measure, order) for claim in claims for order in _deciding(kept, claim)}
    plans = (
        p if (p.control.measure, p.control.order) in asked else ControlPlan(p.control, missing="no claim asks for it")
        for p in kept
    )
    return replace(made, controls=tuple(plans))


def _deciding(plans: Sequence[ControlPlan], claim: Claim) -> tuple[float, ...]:
    if not isinstance(claim.value, Order):
        return ()
    orders = (plan.control.order for plan in plans if plan.control.measure == claim.measure)
    return deciding(orders, claim.value.least)
