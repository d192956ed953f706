"""The attacks of a hunt, one for each scheme, measure and form. Requires hypothesis."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from math import inf
from pathlib import Path
from typing import Any

from sdaeverify import Scheme, UsageError
from sdaeverify.errors import FAULTS
from sdaeverify.measuring import Bound, Measure
from sdaeverify.studying import (
    ProblemSpec,
    Registry,
    load_registry,
    match,
    select_measures,
    select_problems,
    select_schemes,
    unknown,
)

from .campaign import ClaimSearch, made_with, search_all
from .confirm import confirm
from .observation import Target, by_one_step
from .options import EXAMPLES, HuntOptions, Schemes
from .report import Attack, HuntReport
from .search import any_of
from .share import Share, StoredShares
from .strategies import EXAMPLES as DRAWINGS
from .strategies import STATIONARY
from .strategies.shipped import SHIPPED

# Text of a claimed bound of a bias.
UNBIASED = "unbiased"


def attack_all(schemes: Schemes, asked: HuntOptions) -> HuntReport:
    """Search counterexamples to each claim of some schemes.

    Parameters
    ----------
    schemes : str, Scheme or sequence of them
    asked : HuntOptions
    """
    registry = load_registry([str(file) for file in asked.plugins])
    _require_traits(asked)
    targets = list(_targets(registry, schemes, asked))
    if not targets:
        raise UsageError("nothing to search: the schemes have no claims about the measures for problems of the forms")
    searches = [_search(registry, target, asked, len(targets)) for target in targets]
    met = search_all(searches, registry, asked)
    found = sum(share.example is not None for share in met)
    return HuntReport(tuple(_attack(*pair, found) for pair in zip(targets, met, strict=True)), registry.files)


def _search(registry: Registry, target: Target, asked: HuntOptions, targets: int) -> ClaimSearch:
    limit = inf if asked.minutes is None else 60.0 * asked.minutes / targets
    examples = EXAMPLES if asked.minutes is None and asked.examples is None else asked.examples
    specs = tuple(_matching(registry, target.scheme)) if target.form == SHIPPED else ()
    about = " ".join((target.scheme.label, target.measure.name, target.form))
    folder = None if asked.database is None else Path(asked.database)
    return ClaimSearch(
        target,
        tuple(sorted(asked.when)),
        specs,
        examples,
        limit,
        asked.shrinking,
        asked.seed,
        # The digest of the code is costly, so it is computed only if shares are stored.
        StoredShares(folder, target.form, about, "" if folder is None else made_with(target, asked)),
    )


def _targets(registry: Registry, schemes: Schemes, asked: HuntOptions) -> Iterator[Target]:
    measures = select_measures(registry, asked.measures)
    for scheme in select_schemes(registry, schemes):
        claimed = {claim.measure for claim in scheme.promises}
        for measure in sorted((one for one in measures if one.name in claimed), key=_place):
            forms = _stationary(scheme, measure, asked.forms) or _forms(scheme, asked.forms)
            yield from (Target(scheme, measure, form, registry.followed) for form in forms)


def _place(measure: Measure) -> tuple[bool, str]:
    """Return the sort key of a measure: measures that one step decides come first."""
    return not by_one_step(measure), measure.name


def _stationary(scheme: Scheme, measure: Measure, wanted: Sequence[str]) -> list[str]:
    """Return the drawings with a known invariant law on which unbiasedness is tested; none for other claims.

    It is decided by one step if detailed balance holds, unlike an order, which takes long chains.
    """
    values = [each.value for each in scheme.promises if each.measure == measure.name]
    unbiased = any(isinstance(value, Bound) and value.text == UNBIASED for value in values)
    known = [form for form in STATIONARY if unbiased and not measure.refuses(scheme, _problem(form))]
    return [form for form in known if _draws(scheme, form) and (not wanted or form in wanted)]


def _forms(scheme: Scheme, wanted: Sequence[str]) -> list[str]:
    """Return the requested forms that a scheme solves; without a request, the forms it solves directly."""
    known = dict.fromkeys((*DRAWINGS, *STATIONARY, SHIPPED))
    if others := sorted(set(wanted) - set(known)):
        raise UsageError(f"examples have the forms {', '.join(known)}: {unknown('form', others[0], known)}")
    if wanted:
        return [form for form in wanted if form == SHIPPED or _draws(scheme, form)]
    own = [form for form in DRAWINGS if isinstance(_problem(form), scheme.forms) and _draws(scheme, form)]
    return own if scheme.domain is None else [*own, SHIPPED]


def _draws(scheme: Scheme, form: str) -> bool:
    """Return whether a scheme solves the random problems of a form, which have no restricted domain."""
    return scheme.domain is None and scheme.view_of(_problem(form)) is not None


def _require_traits(asked: HuntOptions) -> None:
    """Raise for traits that no form declares, unless registered problems are drawn, which may declare others."""
    known = {name: trait for form in DRAWINGS for name, trait in type(_problem(form)).known_traits().items()}
    others = sorted(set(map(str, asked.when)) - set(known))
    if others and SHIPPED not in asked.forms:
        raise UsageError(f"{unknown('trait', others[0], known)}; sdaeverify info traits shows all")


@cache
def _problem(form: str) -> Any:
    """Return a fixed example problem of a form."""
    return any_of((DRAWINGS | STATIONARY)[form].strategy()).build()


def _matching(registry: Registry, scheme: Scheme) -> list[ProblemSpec]:
    """Return the registered problems that a scheme solves."""
    specs = [spec for spec in select_problems(registry) if _solves(scheme, spec)]
    if not specs:
        raise UsageError(f"{scheme.label} solves no registered problem")
    return specs


def _solves(scheme: Scheme, spec: ProblemSpec) -> bool:
    try:
        return match(scheme, spec.build()).problem is not None
    except FAULTS:
        return False


def _claimed(target: Target) -> Iterator[str]:
    return (str(claim) for claim in target.scheme.promises if claim.measure == target.measure.name)


def _attack(target: Target, share: Share, found: int) -> Attack:
    attack = Attack(
        target.scheme.label,
        target.measure.name,
        target.form,
        tried={(kind, group): count for kind, group, count in share.tried},
        verified=share.verified,
        doubtful=share.doubtful,
        claims=dict.fromkeys(_claimed(target), 0) | dict(share.claims),
        tolerance=type(target.measure).step_tolerance,
    )
    if share.example is None:
        return attack
    confirmed, alone = confirm(target.scheme, share.example, target.measure, found)
    return replace(
        attack,
        claim=share.claim,
        reason=share.reason,
        example=share.example,
        confirmed=confirmed,
        by_paths=alone,
        found_after=share.found_after,
        seconds=share.seconds,
    )
