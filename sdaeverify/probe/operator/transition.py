"""The transition operator u -> E u(Phi(., xi)) of a scheme seen through a chart, as a matrix.

In orthonormal functions phi_i of the coordinates z,

    T_ij = < phi_i, E phi_j(read(Phi(embed(.), h, xi))) >,

with a quadrature over z and cubature nodes for the noise: one batched step for each step size. Powers of T give
expectations at the final time, its left eigenvector of eigenvalue 1 gives the stationary law, both without sampling.

A step that is affine in several normals leads from each z to a normal law, whose mean and covariance are known from
a few of their values, and whose nodes are those of as many normals as there are coordinates.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask
from ...contracts.scheme import Scheme, Step, flatten
from ...forms import Problem
from ...forms.chart import Angle, Chart
from ...numerics.statistics import EPS
from ..step.nodes import Nodes, gauss_hermite, step_nodes, tensor_rule
from ..step.one_step import OneStep
from ..step.step_noise import StepNoise
from ..step.times import changing
from .basis import Basis, chart_basis
from .chart_equation import output_rows, require_chart

# Gauss-Hermite nodes for each of so many normals a step; with more of them there is no operator.
NODES = {1: 8, 2: 8, 3: 5, 4: 4}
# Paths on which steps are made, and functions evaluated, at once: more do not stay near the processor.
# Size: paths of a call.
AT_ONCE = 8_000
# A coordinate that leaps further than so many scales has blown up.
BLOWN_UP = 1e6
# Rounding of an entry of the matrix, in units of EPS and of the size of its function.
# Rounding: EPS for each operation.
ROUNDING = 64.0
# A step is affine in its noise if it is so to rounding, relative to the largest coordinate: errors add up over a run.
AFFINE = 1e-13
# Rounding of embed and read, and what a solver's tolerance may add, relative to the state.
ON_CHART = 1e-9


class Transition(NamedTuple):
    """The matrix of a step and what was noticed of the step.

    Attributes
    ----------
    matrix : ndarray, shape (n, n)
        Takes the coefficients of u to those of E u(Phi(., xi)).
    departure : float
        Largest |embed(read(x)) - x| of the states x reached, pure outputs left out, relative to |x| and its median.
    failed, truncated : float
        Probability of a step that found no root or blew up, and of one that was changed for stability, from a point
        drawn from the law for which the basis is orthonormal. A state that is not finite is put back where the
        step began.
    """

    matrix: Array
    departure: float
    failed: float
    truncated: float

    @property
    def noticed(self) -> tuple[float, float, float]:
        """What is not the matrix."""
        return self.departure, self.failed, self.truncated


# What a scheme is given in place of a step size h and of increments of variance h, in multiples of h.
Given = tuple[float, float]
ASKED: Given = (1.0, 1.0)


def why_not_operator(scheme: Scheme, view: Problem) -> str:
    """Return why a scheme has no transition operator on a problem's chart, or an empty string."""
    chart, one_step = view.chart, OneStep(scheme, view)
    if chart is None or len(chart.axes) not in {1, 2}:
        return "the problem has no chart of one or two coordinates"
    if reason := one_step.why_not_probed():
        return reason
    if len(flatten(one_step.enter(one_step.equation.initial(1), 0.0, view.horizon))) > one_step.equation.dimension:
        return "the scheme has memory beyond the problem's components"
    if not scheme.law.bounded and (normals := StepNoise.of(one_step).normals) not in NODES:
        return f"{normals} normals a step are too many for a tensor rule"
    return _dependence(one_step) or changing(one_step)


def transition(one_step: OneStep, basis: Basis, h: float, fewer: int = 0, given: Given = ASKED) -> Transition:
    """Return the transition operator of a step of size h.

    Parameters
    ----------
    one_step : OneStep
        Of a pair that `why_not_operator` has nothing against.
    basis : Basis
    h : float
    fewer : int
        By how many the Gauss-Hermite nodes are fewer than usual.
    given : Given

    Returns
    -------
    Transition
    """
    steps = _normal_steps(one_step, basis, fewer, h, given)
    if steps is None:
        steps = _make_steps(one_step, basis, _nodes(one_step, fewer), h, given)
    z, weights, noticed = steps
    return Transition(basis.project(_means(basis, weights, z)), *noticed)


# Coordinates z that Q nodes of the quadrature lead to at K nodes of the noise, shape (k, Q, K), the weights of these,
# and what was noticed in the order of `Transition`.
_Reached = tuple[Array, Array, tuple[float, float, float]]


def _make_steps(one_step: OneStep, basis: Basis, nodes: Nodes, h: float, given: Given) -> _Reached:
    _, chart = require_chart(one_step.view)
    z = np.repeat(basis.nodes, len(nodes.weights), axis=1)
    with np.errstate(all="ignore"):
        x, failed, truncated = _step_in_parts(one_step, chart.embed(z), h, nodes, given)
        reached = chart.read(x)
        usable = np.isfinite(x).all(axis=0) & _is_bounded(chart, reached)
        departure = _departure(chart, x, reached, ~output_rows(*require_chart(one_step.view), basis.nodes))
    failed = failed | ~usable
    weights = np.multiply.outer(basis.weights, nodes.weights).ravel()
    worst = float(np.max(departure, initial=0.0, where=~failed))
    whole = np.where(usable, reached, z).reshape(len(z), -1, len(nodes.weights))
    return whole, nodes.weights, (worst, float(weights @ failed), float(weights @ truncated))


def _normal_steps(one_step: OneStep, basis: Basis, fewer: int, h: float, given: Given) -> _Reached | None:
    """Return nodes of the normal laws that steps lead to, or None if they are not affine in several normals."""
    noise = StepNoise.of(one_step)
    if noise.law.bounded or noise.normals == 1:
        return None
    vertices, count = noise.simplex(), NODES[len(basis.nodes)] - fewer
    corners = gauss_hermite(count)[0].max() * tensor_rule([gauss_hermite(2)] * noise.normals).x
    x = np.concatenate([vertices, corners], axis=1)
    nodes = noise.nodes(x, np.full(x.shape[1], 1.0 / x.shape[1]))
    z, _, noticed = _make_steps(one_step, basis, nodes, h, given)
    at_vertices, beyond = np.split(z, [vertices.shape[1]], axis=2)
    mean, slopes = at_vertices.mean(axis=2, keepdims=True), at_vertices @ vertices.T / vertices.shape[1]
    if any(noticed[1:]) or np.abs(mean + slopes @ corners - beyond).max() > AFFINE * np.abs(z).max():
        return None
    # The transposed of the triangular factor has the covariance, and the first coordinate the first normal alone.
    factors = np.asarray(np.linalg.qr(slopes.transpose(1, 2, 0), mode="r")).transpose(2, 0, 1)
    factors[np.abs(factors) <= AFFINE * np.abs(factors).max()] = 0.0
    rule = tensor_rule([gauss_hermite(count)] * len(factors))
    return mean + factors @ rule.x, rule.weights, noticed


def stationary(matrix: Array) -> Array:
    """Return pi with pi T = pi and pi(1) = 1, the means of all functions, shape (n,); NaN if there are several."""
    T, seen = matrix[1:, 1:], _find_seen(matrix)
    inner, right = np.empty(len(T)), np.where(seen, matrix[0, 1:], 0.0)
    try:
        # The second part has means 0, or several laws.
        for part in (seen, ~seen):
            block = T[np.ix_(part, part)]
            inner[part] = np.linalg.solve((np.eye(len(block)) - block).T, right[part])
    except np.linalg.LinAlgError:
        inner[:] = np.nan
    return np.concatenate([[1.0], inner])


def _find_seen(matrix: Array) -> Mask:
    """Return which functions beside 1 have means, however many steps are made from the law of the basis.

    Where a reflection takes steps to steps, those that change their sign under it have none.
    """
    # Functions are of size 1, what a step makes of them of the size of their columns.
    rounding = ROUNDING * EPS * np.maximum(1.0, np.linalg.norm(matrix, axis=0))
    mixed = ~(np.abs(matrix) <= rounding)
    seen = before = mixed[0]
    while before.any():
        before = mixed[before].any(axis=0) & ~seen
        seen = seen | before
    return np.asarray(seen[1:])


def _means(basis: Basis, weights: Array, z: Array) -> Array:
    """Return E phi_j over the noise from each node of the quadrature, shape (Q, n), z having shape (k, Q, K)."""
    firsts, places = zip(*map(_find_distinct, (z[0], z[-1])), strict=True)
    joint = np.zeros([len(first) for first in firsts])
    np.add.at(joint, places, weights)
    axes = [np.take(axis, first, axis=1) for axis, first in zip((z[0], z[-1]), firsts, strict=True)]
    found = np.empty((z.shape[1], *(len(axis.derivative) for axis in basis.axes)))
    some = -(-AT_ONCE // max(joint.shape))
    for start in range(0, len(found), some):
        rows = slice(start, start + some)
        first, second = basis.factors([axis[rows] for axis in axes])
        np.matmul(np.moveaxis(first, 0, 1), _weigh(joint, np.moveaxis(second, 0, 2)), out=found[rows])
    return found.reshape(len(found), -1)


def _find_distinct(z: Array) -> tuple[Array, Array]:
    """Return the nodes of the noise that lead to values of their own, shape (Q, K), and the place of each among them.

    Part of the noise may not move a coordinate, or none of it.
    """
    _, first, place = np.unique(z[len(z) // 2], return_index=True, return_inverse=True)
    if len(first) < len(place) and np.array_equal(z[:, first[place]], z):
        return first, place
    return np.arange(len(place)), np.arange(len(place))


def _weigh(joint: Array, values: Array) -> Array:
    """Return the weights of pairs of nodes, shape (I, J), times values of shape (..., J, n)."""
    weights = np.diagonal(joint)
    return values * weights[:, None] if np.array_equal(np.diag(weights), joint) else joint @ values


def _nodes(one_step: OneStep, fewer: int = 0) -> Nodes:
    scheme = one_step.scheme
    count = NODES.get(StepNoise.of(one_step).normals, 0) - fewer
    return step_nodes(one_step.view.noise_dim, count, areas="H" in scheme.noise, law=scheme.law)


def _step(one_step: OneStep, x: Array, h: float, nodes: Nodes, given: Given = ASKED) -> Step:
    length, variance = given
    noise = nodes.increment(variance * h, x.shape[1] // len(nodes.weights))
    h = float(length * h)
    return one_step.make(x, 0.0, h, noise)


def _step_in_parts(one_step: OneStep, x: Array, h: float, nodes: Nodes, given: Given) -> tuple[Array, Mask, Mask]:
    """Return where steps lead, which of them failed and which were truncated; few states at a time."""
    count = len(nodes.weights)
    some, found = -(-AT_ONCE // count) * count, []
    for start in range(0, x.shape[1], some):
        part = x[:, start : start + some]
        step, none = _step(one_step, part, h, nodes, given), np.zeros(part.shape[1], dtype=bool)
        masks = (none if mask is None else mask for mask in (step.failed, step.truncated))
        found.append((one_step.read(step.state), *masks))
    reached, failed, truncated = (np.concatenate(parts, axis=-1) for parts in zip(*found, strict=True))
    return reached, failed, truncated


def _is_bounded(chart: Chart, z: Array) -> Mask:
    scales = np.array([np.inf if isinstance(axis, Angle) else axis.scale for axis in chart.axes])
    return np.asarray(np.all(np.abs(z) <= BLOWN_UP * scales[:, None], axis=0))


def _departure(chart: Chart, x: Array, z: Array, core: Mask) -> Array:
    gap = np.linalg.norm((chart.embed(z) - x)[core], axis=0)
    size = np.linalg.norm(x[core], axis=0)
    # States near 0 have no size of their own.
    return np.asarray(gap / (size + np.nanmedian(size)))


def _dependence(one_step: OneStep) -> str:
    # What the coefficients and the steps must not depend on, tried at a few states.
    (ito, chart), T = require_chart(one_step.view), one_step.view.horizon
    z = chart_basis(chart, 3, 3).nodes
    x = chart.embed(z)
    if not all(np.array_equal(f(0.0, x), f(part * T, x)) for f in (ito.drift, ito.diffusion) for part in (0.3, 0.9)):
        return "the coefficients depend on time"
    outputs = output_rows(ito, chart, z)
    if np.max(_departure(chart, x, chart.read(x), ~outputs)) > ON_CHART:
        return "embed and read of the problem's chart are not inverse to each other"
    nodes = _nodes(one_step)
    x = np.repeat(x, len(nodes.weights), axis=1)
    with np.errstate(all="ignore"):
        steps = [_step(one_step, x + shift * outputs[:, None], T / 64.0, nodes) for shift in (0.0, 1.0)]
        here, there = (chart.read(one_step.read(step.state)) for step in steps)
    return "" if np.array_equal(here, there, equal_nan=True) else "a step depends on the pure outputs"
