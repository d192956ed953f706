"""Checks of the derivatives and of the algebraic solution that the author of a delay problem provides."""

from collections.abc import Callable
from functools import partial

import numpy as np

from ...arrays import Array
from ...errors import ProblemError
from ...numerics.derivatives import is_analytic
from ...numerics.linalg import apply
from ..checks import PROBES, check_analytic, check_derivative, check_shape
from .delayed import IndexOne
from .partials import Partials

NAMES = ("x", "v", "y")
# A closed form is accepted as a solution if its defect is at most this part of the terms.
SOLVED = 1e-8
# The rounding error of a complex step, in a derivative that vanishes, is far below this part of the other entries.
SINGULAR = 16.0 * np.finfo(float).eps


def check_jacobians(problem: IndexOne, *at: Array) -> None:
    """Check the given derivatives of drift and constraint, or that complex steps can compute those of the constraint.

    Parameters
    ----------
    problem : IndexOne
    *at : ndarray
        x, v and y on a few paths.

    Raises
    ------
    ProblemError
        If a given derivative disagrees with a difference quotient, or the constraint is not analytic. A drift that is
        not analytic is refused only by schemes that differentiate it.
    """
    if problem.drift_partials is not None:
        _check("drift_partials", partial(problem.drift, 0.0), partial(problem.drift_partials, 0.0), at)
    if problem.constraint is None:
        return
    if problem.constraint_partials is not None:
        _check("constraint_partials", partial(problem.constraint, 0.0), partial(problem.constraint_partials, 0.0), at)
    else:
        for f, z in _sections(partial(problem.constraint, 0.0), at):
            check_analytic("constraint", f, z, "; give constraint_partials")


def why_not_drift_partials(problem: IndexOne) -> str:
    """Return why the drift has no derivatives, from the author or by complex step, or an empty string."""
    if problem.drift_partials is not None:
        return ""
    (x, y), v = problem.initial(1), problem.past(-problem.delay)
    if all(is_analytic(f, z) for f, z in _sections(partial(problem.drift, 0.0), (x, v, y)) if len(z)):
        return ""
    return (
        "drift is not analytic (abs or a real array?), so that Newton's method has no Jacobian; give drift_partials"
    )


def check_solved(problem: IndexOne, x: Array, v: Array) -> None:
    """Check that a given closed form solves the constraint, at the start and near it.

    Parameters
    ----------
    problem : IndexOne
    x, v : ndarray, shape (d, P)
        The initial state, and the solution one delay before it.

    Raises
    ------
    ProblemError
        If the defect exceeds `SOLVED` times the size of the terms.
    """
    if problem.solved is None:
        return
    assert problem.constraint is not None
    for move in (0.0, 0.1):
        at = x + move * (1.0 + np.abs(x)), v - move * (1.0 + np.abs(v))
        y = problem.solved(0.0, *at)
        check_shape("solved(t, x, v)", y, (problem.constraints, PROBES))
        off = np.abs(problem.constraint(0.0, *at, y)).max()
        if not off <= SOLVED * size_of_terms(problem, *at, y):
            raise ProblemError(f"solved(t, x, v) leaves constraint = {off:.3g} at x = {at[0][:, 0].tolist()}")


def size_of_terms(problem: IndexOne, *at: Array) -> float:
    """Return the size of the terms that cancel in the constraint at time 0 for given x, v and y; at least 1."""
    terms = zip(problem.linearised_constraint(0.0, *at), at, strict=True)
    return max(1.0, *(float(np.abs(A).max() * np.abs(z).max()) for A, z in terms))


def check_regular(problem: IndexOne, *at: Array) -> None:
    """Check that du/dy is regular at the start, so that the problem has index 1.

    Raises
    ------
    ProblemError
        If du/dy is singular.
    """
    matrices = [part[..., 0] for part in problem.linearised_constraint(0.0, *at)]
    u_y, size = matrices[-1], max(float(np.abs(part).max()) for part in matrices)
    if u_y.shape[0] != u_y.shape[1] or np.linalg.svd(u_y, compute_uv=False).min() <= SINGULAR * size:
        text = "the derivative of the constraint in y is singular at the start: the problem has not index 1"
        raise ProblemError(f"{text}; du/dy = {u_y.tolist()}")


def _check(name: str, f: Callable[..., Array], given: Callable[..., Partials], at: tuple[Array, ...]) -> None:
    for place, (section, z) in enumerate(_sections(f, at)):
        if not len(z):
            continue

        def derivative(point: Array, direction: Array, place: int = place) -> Array:
            return apply(given(*_replace_at(at, place, point))[place], direction)

        check_derivative(f"{name}(t, x, v, y).{NAMES[place]}", section, derivative, z)


def _sections(f: Callable[..., Array], at: tuple[Array, ...]) -> list[tuple[Callable[[Array], Array], Array]]:
    return [(lambda z, place=place: f(*_replace_at(at, place, z)), z) for place, z in enumerate(at)]  # type: ignore[misc]


def _replace_at(at: tuple[Array, ...], place: int, z: Array) -> tuple[Array, ...]:
    return (*at[:place], z, *at[place + 1 :])
