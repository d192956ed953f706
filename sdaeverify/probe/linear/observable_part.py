"""Reduction of a linear system to the part that components depend on and that admissible states reach.

The rows of L R_k1 ... R_kn, for all n, span the influence of the memory on the components L x at this and later
steps. The R_k map the memory modulo its other part into itself. The other part, even if it grows, has no influence.

On a constrained problem the columns of R_k1 ... R_kn M, with M spanning the admissible states, span the reachable
states. Off the manifold, where there are no solutions, the constraint's defect need not decay. Sums of multipliers,
on which no component depends, are no states either.
"""

import numpy as np

from ...arrays import Array
from ...contracts.scheme import flatten
from ..step.one_step import OneStep
from .equation import LinearEquation, linear_equation
from .linear_map import MemoryStep
from .second_moments import Operator

# Directions whose relative contribution to the span is smaller count as dependent.
# Rounding: of a projection on the directions before.
ADDS = 1e-12


def restrict_to_observed(
    step: MemoryStep, operator: Operator, components: Array | None = None
) -> tuple[Operator, Array]:
    """Return an operator restricted to the memory that some components depend on.

    Parameters
    ----------
    step : MemoryStep
    operator : Operator
        Has factors [[R, r], [0, 1]], shape (k + 1, k + 1, K).
    components : ndarray of int, optional
        Rows of the components; all by default.

    Returns
    -------
    Operator
        Has factors [[R, r], [0, 1]], shape (p + 1, p + 1, K), for the memory y = Q x.
    ndarray, shape (p + 1, k + 1)
        [[Q, 0], [0, 1]] with orthonormal rows.
    """
    k = step.dimension
    everything = components is None and k == step.one_step.equation.dimension
    if everything or not np.isfinite(operator.factors).all():
        return operator, np.eye(k + 1)
    reading = step.reading()[:-1, :-1]
    rows = _close_under_maps(reading if components is None else reading[components], operator.homogeneous.factors)
    Q = np.eye(len(rows) + 1, k + 1)
    Q[:-1, :-1], Q[-1] = rows, np.eye(k + 1)[-1]
    return _between(operator, Q), Q


def essential_operator(step: MemoryStep, operator: Operator) -> Operator:
    """Return the linear part of an operator on the subspace that matters for stability, acting on (p, p) matrices."""
    one_step = step.one_step
    if not one_step.view.has_constraints or not np.isfinite(operator.factors).all():
        return restrict_to_observed(step, operator)[0].homogeneous
    seen, rows = restrict_to_observed(step, operator, _states(linear_equation(one_step.equation)))
    linear, entered = seen.homogeneous, one_step.enter(one_step.admissible_corners, 0.0, step.h)
    columns = rows[:-1, :-1] @ _differences(flatten(entered))
    return _between(linear, _close_under_maps(columns.T, linear.factors.swapaxes(0, 1)))


def essential_equation(one_step: OneStep) -> LinearEquation:
    """Return the linear part of a problem's equation on the subspace that matters for stability."""
    equation = linear_equation(one_step.equation)
    A, C = equation.homogeneous
    if not one_step.view.has_constraints:
        return LinearEquation(A, C)
    states = _states(equation)
    Q = _independent(_differences(one_step.admissible_corners)[states].T, np.zeros((0, len(states))))
    A, C = A[np.ix_(states, states)], C[np.ix_(states, states)]
    return LinearEquation(Q @ A @ Q.T, _between(Operator(C, np.ones(C.shape[-1])), Q).factors)


def _states(equation: LinearEquation) -> Array:
    # Return the components on which some component depends, themselves included; all components if there is no
    # dependence.
    A, C = equation.homogeneous
    needed = np.abs(A).max(axis=0) + np.abs(C).max(axis=(0, 2)) > 0.0
    return np.flatnonzero(needed if needed.any() else ~needed)


def _differences(x: Array) -> Array:
    return x[:, 1:] - x[:, :1]


def _between(operator: Operator, Q: Array) -> Operator:
    return Operator(np.moveaxis(Q @ np.moveaxis(operator.factors, -1, 0) @ Q.T, 0, -1), operator.weights)


def _close_under_maps(start: Array, maps: Array) -> Array:
    """Return an orthonormal basis of the rows of `start` and of all their products with maps (k, k, K).

    Each round adds a row or ends: there are at most k rounds, and k rows times K maps altogether.
    """
    R = np.moveaxis(maps, -1, 0)
    rows, further = np.zeros((0, len(maps))), start
    while len(rows) < len(maps) and len(further := _independent(further, rows)):
        rows = np.concatenate([rows, further])
        further = np.concatenate(further @ R)
    return rows


def _independent(rows: Array, known: Array) -> Array:
    # Return an orthonormal basis of the part of `rows` orthogonal to known orthonormal rows; rows are normalised
    # first.
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    rows = rows[lengths[:, 0] > 0.0] / lengths[lengths[:, 0] > 0.0]
    _, sizes, basis = np.linalg.svd(_beside(rows, known), full_matrices=False)
    # For a direction with such a small contribution, one projection leaves rounding errors that are no longer
    # relatively small; so it is projected twice.
    added = basis[sizes > ADDS * len(rows)][: len(known.T) - len(known)]
    return np.asarray(np.linalg.qr(_beside(added, known).T)[0].T)


def _beside(rows: Array, known: Array) -> Array:
    return np.asarray(rows - rows @ known.T @ known)
