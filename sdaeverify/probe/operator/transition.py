"""Transition operator u -> E u(Phi(., xi)) of a scheme in the coordinates of a chart, as a matrix.

In orthonormal functions phi_i of the coordinates z,

    T_ij = < phi_i, E phi_j(read(Phi(embed(.), h, xi))) >,

with quadrature over z and cubature nodes for the noise: one batched step for each step size. Powers of T give
expectations at the final time, its left eigenvector of eigenvalue 1 the stationary law, both without sampling.

A step that is affine in several normals maps each z to a normal law. Its mean and covariance follow from a few
values, and it needs nodes for only as many normals as there are coordinates.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask
from ...contracts.scheme import Scheme, Step, flatten
from ...forms import Problem
from ...forms.chart import Angle, Chart
from ...numerics.newton import SOLVED
from ...numerics.statistics import EPS
from ..local.smoothness import follow
from ..step.nodes import SEED, Nodes, gauss_hermite, step_nodes, tensor_rule
from ..step.one_step import OneStep
from ..step.states import reached_states
from ..step.step_noise import StepNoise
from ..step.times import changing
from .basis import Basis, chart_basis
from .chart_equation import output_rows, require_chart

# Gauss-Hermite nodes per normal, by the number of normals of a step; for more of them there is no operator.
NODES = {1: 8, 2: 8, 3: 5, 4: 4}
# Paths for which steps are made, and functions evaluated, in one call: more do not fit the processor's caches.
# Size: paths of a call.
AT_ONCE = 8_000
# A coordinate counts as blown up beyond this number of scales.
# Size: of the range of coordinates; the probability of steps beyond it counts as failed.
BLOWN_UP = 1e6
# Rounding error of a matrix entry, in units of EPS and of the size of its function.
# Rounding: EPS for each operation.
ROUNDING = 64.0
# Tolerance for a step affine in its noise, relative to the largest coordinate: errors add up over a run.
# Rounding: 64 operations at the vertices, and at corners up to 4 standard deviations away, err by 320 eps = 7e-14.
# Other steps are made at all nodes, which costs more.
AFFINE = 1e-13
KINKS = "a step has a kink or a jump that the nodes of the operator do not resolve"
# Lines between reached states on which a step is evaluated, intervals of each, and the step size in units of time.
# Size: lines, intervals and a step.
LINES, CUTS, SHORT = 16, 32, 2.0**-4


class Transition(NamedTuple):
    """Matrix of a step, with diagnostics of the step.

    Attributes
    ----------
    matrix : ndarray, shape (n, n)
        Maps the coefficients of u to those of E u(Phi(., xi)).
    departure : float
        Largest |embed(read(x)) - x| over the states x reached, without pure outputs, relative to |x| plus its median.
    failed, truncated : float
        Probability that a step finds no root or blows up, and that it is truncated, from a point drawn from the law
        for which the basis is orthonormal. A state that is not finite is replaced by the state before the step.
    """

    matrix: Array
    departure: float
    failed: float
    truncated: float

    @property
    def noticed(self) -> tuple[float, float, float]:
        """Diagnostics: departure, failed and truncated."""
        return self.departure, self.failed, self.truncated


# Step size and variance of increments that a scheme receives, in multiples of h.
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
        return f"{normals} normals per step are too many for a tensor rule"
    return _dependence(one_step) or changing(one_step) or _kinks(one_step)


def transition(one_step: OneStep, basis: Basis, h: float, fewer: int = 0, given: Given = ASKED) -> Transition:
    """Return the transition operator of a step of size h.

    Parameters
    ----------
    one_step : OneStep
        Scheme and problem for which `why_not_operator` is empty.
    basis : Basis
    h : float
    fewer : int
        Number of Gauss-Hermite nodes per normal to leave out.
    given : Given
        Step size and variance of the increments that the scheme receives, in multiples of h.

    Returns
    -------
    Transition
    """
    steps = _normal_steps(one_step, basis, fewer, h, given)
    if steps is None:
        steps = _make_steps(one_step, basis, _nodes(one_step, fewer), h, given)
    z, weights, noticed = steps
    return Transition(basis.project(_means(basis, weights, z)), *noticed)


# Coordinates z reached from Q quadrature nodes at K noise nodes, shape (k, Q, K), the weights of the latter, and the
# diagnostics of `Transition`.
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
    """Return nodes of the normal laws after steps, or None if the steps are not affine in several normals."""
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
    # The transposed triangular factor has the same covariance, and its first coordinate depends on the first normal
    # only.
    factors = np.asarray(np.linalg.qr(slopes.transpose(1, 2, 0), mode="r")).transpose(2, 0, 1)
    factors[np.abs(factors) <= AFFINE * np.abs(factors).max()] = 0.0
    rule = tensor_rule([gauss_hermite(count)] * len(factors))
    return mean + factors @ rule.x, rule.weights, noticed


def stationary(matrix: Array) -> Array:
    """Return pi with pi T = pi and pi(1) = 1, the means of all functions, shape (n,); NaN if pi is not unique."""
    T, seen = matrix[1:, 1:], _find_seen(matrix)
    inner, right = np.empty(len(T)), np.where(seen, matrix[0, 1:], 0.0)
    try:
        # On the second part the means are 0, or there are several laws.
        for part in (seen, ~seen):
            block = T[np.ix_(part, part)]
            inner[part] = np.linalg.solve((np.eye(len(block)) - block).T, right[part])
    except np.linalg.LinAlgError:
        inner[:] = np.nan
    return np.concatenate([[1.0], inner])


def _find_seen(matrix: Array) -> Mask:
    """Return which functions other than 1 have nonzero means after some number of steps from the law of the basis.

    If the steps are symmetric under a reflection, functions that change sign under it have mean 0.
    """
    # Functions have size 1, and their images the size of their columns.
    rounding = ROUNDING * EPS * np.maximum(1.0, np.linalg.norm(matrix, axis=0))
    mixed = ~(np.abs(matrix) <= rounding)
    seen = before = mixed[0]
    while before.any():
        before = mixed[before].any(axis=0) & ~seen
        seen = seen | before
    return np.asarray(seen[1:])


def _means(basis: Basis, weights: Array, z: Array) -> Array:
    """Return E phi_j over the noise from each quadrature node, shape (Q, n), for z of shape (k, Q, K)."""
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
    """Return the values at distinct noise nodes, shape (Q, K), and for each node its index among them.

    Part of the noise, or all of it, may not affect a coordinate.
    """
    _, first, place = np.unique(z[len(z) // 2], return_index=True, return_inverse=True)
    if len(first) < len(place) and np.array_equal(z[:, first[place]], z):
        return first, place
    return np.arange(len(place)), np.arange(len(place))


def _weigh(joint: Array, values: Array) -> Array:
    """Return weights of pairs of nodes, shape (I, J), times values of shape (..., J, n)."""
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
    """Return the states after steps, and masks of failed and truncated ones; made for a few states per call."""
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
    # The median of the sizes is added, since a state near 0 gives no scale.
    return np.asarray(gap / (size + np.nanmedian(size)))


def _dependence(one_step: OneStep) -> str:
    # Return a dependence on time or pure outputs that excludes an operator, tested at a few states, or an empty
    # string.
    (ito, chart), T = require_chart(one_step.view), one_step.view.horizon
    z = chart_basis(chart, 3, 3).nodes
    x = chart.embed(z)
    if not all(np.array_equal(f(0.0, x), f(part * T, x)) for f in (ito.drift, ito.diffusion) for part in (0.3, 0.9)):
        return "the coefficients depend on time"
    outputs = output_rows(ito, chart, z)
    if np.max(_departure(chart, x, chart.read(x), ~outputs)) > SOLVED:
        return "embed and read of the problem's chart are not inverses of each other"
    nodes = _nodes(one_step)
    x = np.repeat(x, len(nodes.weights), axis=1)
    with np.errstate(all="ignore"):
        steps = [_step(one_step, x + shift * outputs[:, None], T / 64.0, nodes) for shift in (0.0, 1.0)]
        here, there = (chart.read(one_step.read(step.state)) for step in steps)
    return "" if np.array_equal(here, there, equal_nan=True) else "a step depends on components that are outputs only"


@lru_cache(maxsize=64)
def _kinks(one_step: OneStep) -> str:
    """Return that a step has a kink or a jump as a function of its state and its noise, or an empty string.

    Quadrature misses a different step in a region between its nodes, of the states or of the noise. So the step is
    evaluated along lines between states that solutions reach, with fixed noise, and along lines through both.
    """
    _, chart = require_chart(one_step.view)
    rng, h = np.random.Generator(np.random.Philox(key=SEED + 19)), SHORT * one_step.time_unit
    states = chart.read(reached_states(one_step.view, one_step.equation).points)
    ends = states[:, rng.integers(states.shape[1], size=(2, LINES))]
    drawn = [one_step.scheme.law.increment(one_step.view.drawn(rng, h, LINES), h) for _ in range(2)]
    parts = [[part for part in (noise.dW, noise.H) if part is not None] for noise in drawn]
    begin, end = (np.concatenate(part) for part in parts)
    # Increments of few values have no lines between them.
    other = begin if one_step.scheme.law.bounded else end
    # Random weights, so that the kink of one component does not cancel that of another.
    weights, rows = rng.standard_normal((one_step.equation.dimension, 1)), np.cumsum([len(ends), len(drawn[0].dW)])

    def image(y: Array) -> Array:
        z, dW, H = np.split(y, rows)
        step = one_step.make(chart.embed(z), 0.0, h, drawn[0]._replace(dW=dW, H=H if len(H) else None))
        return np.asarray((weights * one_step.read(step.state)).sum(axis=0))

    lines = (np.concatenate([ends, np.stack([begin, last], axis=1)]) for last in (begin, other))
    with np.errstate(all="ignore"):
        return KINKS if any(follow(line, CUTS, image, 2)[0] for line in lines) else ""
