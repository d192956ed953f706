"""The attacks of a hunt, one for each scheme, measure and form. They need hypothesis."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from math import inf, nan
from pathlib import Path
from typing import Any

from ...api import Schemes
from ...contracts.matching import match
from ...contracts.measure import Measure
from ...contracts.scheme import Scheme
from ...errors import FAULTS, UsageError
from ...registry.load import Registry, load_registry
from ...registry.selection import select_measures, select_problems, select_schemes
from ..strategies import EXAMPLES as DRAWINGS
from ..strategies import Example, shipped
from ..strategies.shipped import SHIPPED
from .confirm import confirm
from .options import EXAMPLES, HuntOptions
from .report import Attack, HuntReport
from .search import MOST, Budget, Search, Target, any_of, find
from .sight import ONE_STEP


def attack_all(schemes: Schemes, asked: HuntOptions) -> HuntReport:
    """Attack each claim of some schemes.

    Parameters
    ----------
    schemes : str, Scheme or sequence of them
    asked : HuntOptions
    """
    registry = load_registry([str(file) for file in asked.plugins])
    targets = list(_targets(registry, schemes, asked))
    if not targets:
        raise UsageError("nothing is hunted: the schemes claim nothing of these measures on problems of these forms")
    budget = _budget(asked, len(targets))
    met = [
        (search := Search(target, budget, frozenset(asked.when)), _find(registry, search, asked))
        for target in targets
    ]
    found = sum(example is not None for _, example in met)
    files = tuple(str(Path(file).absolute()) for file in asked.plugins)
    return HuntReport(tuple(_attack(search, example, found) for search, example in met), files)


def _find(registry: Registry, search: Search, asked: HuntOptions) -> Example | None:
    target = search.target
    asked.tell(f"{target.scheme.label}, {target.measure.name}, {target.form} ...")
    database = None if asked.database is None else Path(asked.database)
    example = find(search, _strategy(registry, target, asked.when), asked.seed, database)
    outcome = "none refutes it" if example is None else f"example {search.found_after} refutes it"
    asked.tell(f"{target.scheme.label}, {target.measure.name}, {target.form}: {search.looked_at} examples, {outcome}")
    return example


def _budget(asked: HuntOptions, targets: int) -> Budget:
    seconds = inf if asked.minutes is None else 60.0 * asked.minutes / targets
    examples = (EXAMPLES if asked.minutes is None else MOST) if asked.examples is None else asked.examples
    return Budget(examples, seconds, min(asked.shrinking, seconds))


def _targets(registry: Registry, schemes: Schemes, asked: HuntOptions) -> Iterator[Target]:
    measures = select_measures(registry, asked.measures)
    for scheme in select_schemes(registry, schemes):
        claimed = {claim.measure for claim in scheme.promises}
        for measure in sorted((one for one in measures if one.name in claimed), key=_place):
            yield from (Target(scheme, measure, form) for form in _forms(scheme, asked.forms))


def _place(measure: Measure) -> tuple[bool, str]:
    """Return what measures are sorted by: first those that one step tells of."""
    return measure.name not in ONE_STEP, measure.name


def _forms(scheme: Scheme, wanted: Sequence[str]) -> list[str]:
    """Return the forms that are asked for; if none is, those that a scheme solves itself."""
    known = [*DRAWINGS, SHIPPED]
    if unknown := sorted(set(wanted) - set(known)):
        raise UsageError(f"unknown form {', '.join(unknown)}; known are {', '.join(known)}")
    return list(wanted) or [form for form in DRAWINGS if isinstance(_problem(form), scheme.forms)]


@cache
def _problem(form: str) -> Any:
    """Return a problem of a form."""
    return any_of(DRAWINGS[form].strategy()).build()


def _strategy(registry: Registry, target: Target, when: Sequence[str]) -> Any:
    if target.form == SHIPPED:
        return shipped(_matching(registry, target.scheme))
    drawing = DRAWINGS[target.form]
    # Kinds that have the traits by construction are enough; traits that the form sets are found among all.
    kinds = tuple(kind for kind in drawing.kinds if set(when) <= set(drawing.traits.get(kind, ()))) or drawing.kinds
    return drawing.strategy(kinds=kinds)


def _matching(registry: Registry, scheme: Scheme) -> list[Any]:
    """Return the registered problems that a scheme solves."""
    specs = [spec for spec in select_problems(registry) if _solves(scheme, spec)]
    if not specs:
        raise UsageError(f"{scheme.label} solves no registered problem")
    return specs


def _solves(scheme: Scheme, spec: Any) -> bool:
    try:
        return match(scheme, spec.build()).problem is not None
    except FAULTS:
        return False


def _attack(search: Search, example: Example | None, found: int) -> Attack:
    target, (_, tolerance) = search.target, ONE_STEP.get(search.target.measure.name, (None, nan))
    attack = Attack(
        target.scheme.label,
        target.measure.name,
        target.form,
        tried=dict(search.tried),
        verified=search.verified,
        doubtful=search.doubtful,
        tolerance=tolerance,
    )
    sight = None if example is None else search.seen[example]
    if example is None or sight is None:
        return attack
    confirmed, alone = confirm(target.scheme, example, target.measure, found)
    return replace(
        attack,
        claim=sight.claim,
        reason=sight.refuted,
        example=example,
        confirmed=confirmed,
        by_paths=alone,
        found_after=search.found_after,
        seconds=search.seconds,
    )
