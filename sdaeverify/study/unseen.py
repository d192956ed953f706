"""Gaps of a run: features of forms that none of its problems has, and claims that apply to none of its problems."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..contracts.scheme import Claim
from ..contracts.spelling import counted
from ..errors import FAULTS
from ..forms import Problem
from .plan import Plan, cells_of_claims


def unseen(plan: Plan) -> tuple[str, ...]:
    """Return a line for each form with features that no problem of a run has, and one for untested claims.

    Parameters
    ----------
    plan : Plan
    """
    untested = _describe_untested(plan)
    return (*unseen_features(plan), *([untested] if untested else []))


def unseen_features(plan: Plan) -> tuple[str, ...]:
    """Return a line for each form with features that no problem of a run has.

    Only forms that a scheme of the run solves without a view count, and only the problems that it solves in this way.

    Parameters
    ----------
    plan : Plan
    """
    problems: dict[type[Any], dict[str, Problem]] = {}
    for form, label, problem in _solved(plan):
        problems.setdefault(form, {})[label] = problem
    lines = (_describe(form, [*solved.values()]) for form, solved in problems.items())
    return tuple(sorted(filter(None, lines)))


def _solved(plan: Plan) -> Iterator[tuple[type[Any], str, Problem]]:
    """Yield the forms of schemes with the problems of these forms that they are run on."""
    for made in plan.problems:
        problem = made.problem
        if problem is None:
            continue
        forms = dict.fromkeys(form for cell in made.runnable if not cell.view for form in cell.scheme.forms)
        yield from ((form, made.spec.label, problem) for form in forms if isinstance(problem, form))


def _describe(form: type[Any], problems: list[Problem]) -> str:
    missing = [feature.name for feature in form.features() if not any(_has(feature.found, each) for each in problems)]
    if not missing:
        return ""
    *others, last = missing
    listed = f"{', '.join(others)} or {last}" if others else last
    return f"{form.__name__}: no problem of this run has {listed}"


def _has(found: Any, problem: Problem) -> bool:
    """Return whether a problem has a feature; False if its coefficients cannot be evaluated."""
    try:
        with np.errstate(all="ignore"):
            return bool(found(problem))
    except FAULTS:
        # The cells of the problem report the fault.
        return False


def _describe_untested(plan: Plan) -> str:
    """Return the number of claims that no cell tests, with the first of them as an example, or an empty string."""
    tested, measures = cells_of_claims(plan), {cell.measure.name for cell in plan.cells}
    schemes = dict.fromkeys(cell.scheme for cell in plan.cells)
    promises = dict.fromkeys((scheme, claim) for scheme in schemes for claim in scheme.promises)
    missed = [each for each in promises if each[1].measure in measures and each not in tested]
    if not missed:
        return ""
    scheme, claim = missed[0]
    verb, more = ("was", "") if len(missed) == 1 else ("were", f"; {len(missed) - 1} more")
    counts = f"{counted(len(missed), 'claim')} {verb} tested nowhere"
    return f"{counts}: {scheme.label}, {claim.measure} {claim}: {_why_untested(claim)}{more}"


def _why_untested(claim: Claim) -> str:
    if not claim.when:
        return "it applies to no problem of this run"
    *others, last = sorted(claim.when)
    traits = f"{', '.join(others)} and {last}" if others else last
    return f"no problem of this run has {'both ' if len(others) == 1 else ''}{traits}"
