"""Features of forms that no problem of a run has: nothing in the run can show how schemes treat them."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..errors import FAULTS
from ..forms import Problem
from .plan import Plan


def unseen_features(plan: Plan) -> tuple[str, ...]:
    """Return a line for each form of which a feature is met by no problem of a run.

    Only forms count that a scheme of the run solves without a view, and only the problems that it solves so.

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
    return f"{form.__name__}: no problem here has {listed}"


def _has(found: Any, problem: Problem) -> bool:
    """Return whether a problem has a feature; no, if its coefficients cannot be evaluated."""
    try:
        with np.errstate(all="ignore"):
            return bool(found(problem))
    except FAULTS:
        # A problem with a fault is reported where it is run.
        return False
