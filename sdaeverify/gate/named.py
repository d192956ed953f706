"""Names in expected failures: each must be one that the registry, the plan or an examination knows."""

from collections.abc import Iterable, Iterator, Mapping

from ..contracts.labels import matches, parse_label
from ..contracts.spelling import did_you_mean
from ..errors import UsageError
from ..registry.contributions import Registered
from ..registry.load import Registry
from ..study import Cell
from ..study.class_results import NAME
from .expected import FailingClaim
from .policy import Policy

GLOBS = ("*", "?")


def require_named(registry: Registry, policy: Policy, cells: Iterable[Cell]) -> None:
    """Check that each expected failure of a policy names schemes, problems and measures that there are.

    Solvers that examinations name are known when these have ended, so that a policy with examinations is not checked
    here.

    Parameters
    ----------
    registry : Registry
    policy : Policy
    cells : iterable of Cell
        Of the plan, with schemes and problems that need not be registered.

    Raises
    ------
    UsageError
        If one can never match a finding.
    """
    if policy.examinations:
        return
    planned = list(cells)
    for one in policy.expected_failures:
        if why := why_never(one, registry, planned):
            raise UsageError(f"the expected failure {one} ({one.reason}) can never match: {why}")


def why_never(one: FailingClaim, registry: Registry, cells: Iterable[Cell]) -> str:
    """Return why an expected failure cannot match any finding, or an empty string.

    Parameters
    ----------
    one : FailingClaim
    registry : Registry
    cells : iterable of Cell
        Of schemes and problems that are registered, and of others.
    """
    planned = list(cells)
    kinds = {
        "scheme": (registry.schemes, {cell.scheme.label for cell in planned}),
        "problem": (registry.problems, {cell.spec.label for cell in planned} | {NAME}),
        "measure": (registry.measures, {cell.measure.name for cell in planned}),
    }
    reasons = (why for kind, known in kinds.items() for why in _objections(kind, getattr(one, kind), *known))
    return next(reasons, "")


def _objections(kind: str, pattern: str, registered: Mapping[str, Registered], labels: set[str]) -> Iterator[str]:
    """Yield why a pattern matches no label, of things that are registered or have one of the labels given."""
    if any(matches(pattern, label) for label in labels):
        return
    name = pattern.partition("[")[0]
    names = {*registered, *(label.partition("[")[0] for label in labels)}
    if not any(matches(name, each) for each in names):
        yield f"no {kind} is named {name}{did_you_mean(name, names)}"
    elif name in registered and not any(glob in pattern for glob in GLOBS):
        yield from _objections_to_label(pattern, registered[name])


def _objections_to_label(pattern: str, entry: Registered) -> Iterator[str]:
    """Yield why a pattern without wildcards is not the label of a registered thing."""
    try:
        made = entry.make(parse_label(pattern).parameters)
    except UsageError as error:
        yield str(error)
        return
    if (label := str(getattr(made, "label", entry.name))) != pattern:
        yield f"the label of {pattern} is written {label}"
