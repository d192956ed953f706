"""What a gate runs: the claimed cells that a tier covers."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

from ..contracts.scheme import Claim, Scheme
from ..errors import UsageError
from ..forms.controls import deciding
from ..registry.contributions import SchemeEntry
from ..registry.discovery import normalized
from ..registry.load import Registry
from ..registry.selection import select_measures, select_problems, select_schemes
from ..study import Plan, ProblemPlan, plan
from ..study.claimed import claims_of
from ..study.plan import ControlPlan
from ..study.remote_plan import asking
from .cover import every_claim_once, size
from .policy import Policy
from .tiers import Cover, tier_of


def gate_plan(registry: Registry, policy: Policy, executor: Executor | None = None) -> Plan:
    """Plan a gate: claimed cells only, those of the tier's cover.

    Parameters
    ----------
    registry : Registry
    policy : Policy
    executor : Executor, optional
        Isolated workers are asked what can be run; schemes and problems are asked here without them.

    Returns
    -------
    Plan
        The largest problem first, so that workers end together; without a problem where nothing is claimed.

    Raises
    ------
    UsageError
        If a name is unknown or a pattern matches nothing.
    ParameterError
        If a parameter is unknown or its value is not accepted.
    """
    tier = tier_of(policy)
    chosen = (
        gated_schemes(registry, policy),
        select_problems(registry, policy.problems),
        [m for m in select_measures(registry, policy.measures) if m.name not in left_out(registry, policy)],
    )
    resolve = (lambda label: select_schemes(registry, label)[0]) if tier.controls else None
    made = plan(*chosen, resolve, asking(executor, *chosen))
    claimed = [_claimed(problem) for problem in made.problems]
    kept = every_claim_once(claimed) if tier.cover is Cover.EVERY_CLAIM_ONCE else claimed
    ready = [_controlled(problem, controls=tier.controls) for problem in kept if problem.cells]
    return Plan(tuple(sorted(ready, key=_work, reverse=True)))


def left_out(registry: Registry, policy: Policy) -> list[str]:
    """Return the measures that take too long for the tier; none where the policy names measures."""
    if tier_of(policy).lengthy or policy.measures:
        return []
    return [measure.name for measure in select_measures(registry) if measure.lengthy]


def gated_schemes(registry: Registry, policy: Policy) -> list[Scheme]:
    """Return the schemes a policy means: by its patterns, else those of its project; everything without a project.

    Raises
    ------
    UsageError
        As `select_schemes`.
    """
    if policy.schemes:
        return select_schemes(registry, policy.schemes)
    own = [entry for entry in registry.schemes.values() if _is_of(entry, policy)]
    if policy.distribution and not own:
        raise UsageError(
            f"project {policy.distribution} registers no scheme here; install it, or name schemes in {policy.file}"
        )
    everything = own or registry.schemes.values()
    return select_schemes(registry, [variant for entry in everything for variant in entry.variants])


def _is_of(entry: SchemeEntry, policy: Policy) -> bool:
    origin = entry.origin
    named = bool(policy.distribution) and normalized(origin.distribution) == normalized(policy.distribution)
    return named or origin.module in policy.plugins


def _claimed(made: ProblemPlan) -> ProblemPlan:
    return replace(made, cells=tuple(cell for cell in made.cells if claims_of(cell, made.problem)))


def _controlled(made: ProblemPlan, *, controls: bool) -> ProblemPlan:
    """Run the controls of what is claimed; of another order it is known all the same that there are some."""
    claims = {claim for cell in made.cells for claim in claims_of(cell, made.problem)}
    measures = {claim.measure for claim in claims} if controls else set()
    kept = [plan for plan in made.controls if plan.control.measure in measures]
    asked = {(claim.measure, order) for claim in claims for order in _deciding(kept, claim)}
    return replace(
        made, controls=tuple(p if (p.control.measure, p.control.order) in asked else _idle(p) for p in kept)
    )


def _deciding(plans: Sequence[ControlPlan], claim: Claim) -> tuple[float, ...]:
    if isinstance(claim.value, str):
        return ()
    return deciding((plan.control.order for plan in plans if plan.control.measure == claim.measure), claim.value)


def _idle(unasked: ControlPlan) -> ControlPlan:
    return ControlPlan(unasked.control, missing="no claim asks for it")


def _work(made: ProblemPlan) -> int:
    """Return what a problem costs, very roughly: its cells times its components."""
    return len(made.cells) * size(made.problem)
