"""Ito equation of a problem in the coordinates of its chart, and its generator in a basis.

For x = embed(z), dx = f dt + B dW and dz = b dt + s dW, Ito's formula reads

    B_j = D embed(z) s_j,    f = D embed(z) b + (1/2) sum_j D^2 embed(z)(s_j, s_j),

which has more equations than unknowns unless the chart is the identity; it is a chart if they have a solution.
"""

from itertools import combinations_with_replacement

import numpy as np

from ...arrays import Array, Mask
from ...errors import ProblemError
from ...forms import Equation, Problem
from ...forms.chart import Chart
from ...forms.names import article
from ...numerics import is_analytic, jacobian, second_directional
from .basis import Basis

# Accepted deviation from Ito's formula, relative to its terms.
# Rounding: the second difference for D^2 embed, of width 1e-3, errs by 1e-12 |s|^2; right for noise up to |s| = 30.
CONSISTENT = 1e-9


def require_chart(view: Problem) -> tuple[Equation, Chart]:
    """Return the Ito equation and the chart of a problem, or raise if one is missing."""
    ito = view.ito()
    if ito is None or view.chart is None:
        raise ProblemError(f"{article(type(view).__name__)} without Ito equation or chart has no equation on a chart")
    return ito, view.chart


def output_rows(ito: Equation, chart: Chart, z: Array) -> Mask:
    """Return which rows of a state are pure outputs: 0 under `embed`, and without influence on the coefficients.

    Parameters
    ----------
    ito : Equation
    chart : Chart
    z : ndarray, shape (k, P)
        Coordinates at which this is tested.

    Returns
    -------
    ndarray of bool, shape (d,)
    """
    x = chart.embed(z)
    idle = np.logical_not(x.any(axis=1))
    if not idle.any():
        return idle
    moved = x + np.where(idle, 1.0, 0.0)[:, None]
    same = all(np.array_equal(f(0.0, x), f(0.0, moved)) for f in (ito.drift, ito.diffusion))
    return idle if same else np.zeros_like(idle)


def coefficients(ito: Equation, chart: Chart, z: Array) -> tuple[Array, Array]:
    """Return drift and diffusion of the coordinates at z, shape (k, P).

    Parameters
    ----------
    ito : Equation
        The Ito equation of the problem.
    chart : Chart
        Coordinates of the manifold.
    z : ndarray, shape (k, P)
        Points of evaluation.

    Returns
    -------
    ndarray, shape (k, P)
        Drift b.
    ndarray, shape (k, l, P)
        Diffusion s.

    Raises
    ------
    ProblemError
        If `embed` is not analytic, or if the solution does not stay on its image.
    """
    if not is_analytic(chart.embed, z[:, :1]):
        raise ProblemError("embed of the chart is not analytic (abs or a real array?): no complex step can be made")
    core = ~output_rows(ito, chart, z)
    x = chart.embed(z)
    f = np.broadcast_to(ito.drift(0.0, x), x.shape)[core]
    B = np.broadcast_to(ito.diffusion(0.0, x), (len(x), ito.noise_dim, x.shape[1]))[core]
    tangents = np.moveaxis(jacobian(chart.embed, z)[core], -1, 0)
    inverse = np.linalg.pinv(tangents)
    s = _solve_columns(tangents, inverse, B)
    curvature = sum(second_directional(chart.embed, z, column, column)[core] for column in np.moveaxis(s, 1, 0))
    return _solve_columns(tangents, inverse, (f - 0.5 * curvature)[:, None])[:, 0], s


def generator(ito: Equation, chart: Chart, basis: Basis) -> Array:
    """Return the matrix of u -> b . grad u + (1/2) s s^T : D^2 u in a basis, shape (n, n).

    Its exponential is, to the accuracy of the basis, the semigroup u -> E u(z_t), a reference independent of schemes.

    Parameters
    ----------
    ito : Equation
        Ito equation of the problem; coefficients are taken at time 0.
    chart : Chart
        Coordinates of the manifold.
    basis : Basis
        The n functions of the coordinates.
    """
    b, s = coefficients(ito, chart, basis.nodes)
    A = np.einsum("ilp,jlp->ijp", s, s)
    axes = list(zip(basis.axes, basis.factors(basis.nodes), strict=True))
    derivatives = [[values, D.T @ values, D.T @ (D.T @ values)] for (_, D, *_), values in axes]
    image = np.zeros((basis.nodes.shape[1], *(len(values) for _, values in axes)))
    for weight, orders in _terms(b, A):
        first, second = (derivatives[axis][order] for axis, order in enumerate(orders))
        image += np.einsum("q,aq,bq->qab", weight, first, second)
    return basis.project(image.reshape(len(image), -1))


def _terms(b: Array, A: Array) -> list[tuple[Array, tuple[int, int]]]:
    # Return coefficients with the orders of the two partial derivatives that they multiply.
    def orders(*axes: int) -> tuple[int, int]:
        return axes.count(0), axes.count(1)

    first = [(b[i], orders(i)) for i in range(len(b))]
    pairs = combinations_with_replacement(range(len(b)), 2)
    return first + [((0.5 if i == j else 1.0) * A[i, j], orders(i, j)) for i, j in pairs]


def _solve_columns(tangents: Array, inverse: Array, right: Array) -> Array:
    # Return columns c with D embed c = right on every path, shapes (rows, m, P) -> (k, m, P).
    right = np.moveaxis(right, -1, 0)
    columns = inverse @ right
    defect = np.abs(tangents @ columns - right)
    if np.any(defect > CONSISTENT * (1.0 + np.abs(right))):
        raise ProblemError(f"the solution leaves the image of the chart: a coefficient is off by {defect.max():.2g}")
    return np.moveaxis(columns, 0, -1)
