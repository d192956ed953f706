"""Errors as functions of eps and h: at the final time, and of one step, uniformly in eps.

At fixed eps an error may behave differently for h << eps and for h >> eps (C min(h, eps) is typical), so
a slope fitted at fixed eps across h = eps is meaningless. The supremum over a grid of eps is the quantity that
Laurent (2022), Theorem 2.7, bounds; its order in h is reported.

The local weak error is estimated by comparing one step with two half steps for every stiffness parameter.
Laurent (2022), Propositions 3.3 and 3.7: from all x with omega |zeta(x)| <= C sqrt(h), omega = 1 - e^{-h/eps},

    |E phi(X^eps(h)) - E phi(Phi_h(x))| <= C h^{3/2}        with one C for all eps.

The observable part of it, for the first and second moments of an increment (third ones are O(h^{3/2}) themselves), is

    D(h) = sup_{eps, x} |E phi(Phi_h(x)) - E phi(Phi_{h/2} o Phi_{h/2}(x))|,

and, for eps far above h, the difference between Phi_h and Euler's step. Together they are sufficient: the local error
delta(h, eps) is, up to the accumulation in a stable step, the sum over k of 2^k D(h/2^k) and the limit of
2^k delta(h/2^k, eps), where eps is far above h/2^k. D = O(h^p) with p > 1 makes the sum O(h^p).

Expectations are sums over nodes: all atoms of a bounded law, else +-sqrt(n) e_i, which have the right moments up to
the third. The remainder is O(h^2).
"""

from collections.abc import Callable, Iterator, Sequence
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Array, Mask, Problem, Scheme
from sdaeverify.numerics import norm
from sdaeverify.probing import (
    Nodes,
    OneStep,
    StepNoise,
    StiffnessFamily,
    cloud,
    invariant_errors,
    linear_equation,
    mean_square_distance,
    moment_errors,
    step_nodes,
)

from .._members import member, stiffnesses

# Values of eps per decade for the propagation of moments, and for operators, which are set up for each of them.
PER_DECADE, OPERATORS_PER_DECADE = 2, 1
# Rounding of one step of a recursion, in units of EPS and of the size of the moments.
ROUNDING, EPS = 16.0, float(np.finfo(float).eps)
# Functions of an angle and of a coordinate on the line, by the number of coordinates, in two bases.
FINE, COARSE = {1: (49, 18), 2: (15, 14)}, {1: (33, 12), 2: (11, 10)}
OPERATOR_LEVELS = 4
FURTHER = 6
# Largest share of lost steps for which an error is defined.
FAILED = 0.01
# The order is taken over at most this number of halvings of h, up to the finest h at which the supremum is known.
# With two eps per decade the maximiser moves from one to the next every 1.7 halvings.
HALVINGS, FEWEST = 5, 3
# A supremum is resolved if its relative uncertainty is at most this.
KNOWN = 0.25
# All eps up to this multiple of the longest step are used.
BEYOND = 10.0
# An error at most this part of the size of the quantity is treated as none.
EXACT = 1e-6


class UniformErrors(NamedTuple):
    """Errors of Q quantities for E stiffness parameters at H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
        From coarse to fine, each half of the previous one.
    eps : ndarray, shape (E,)
    error, floor : ndarray, shape (E, H, Q)
        Absolute errors, infinite if the scheme's value is not finite, and bounds of their numerical errors.
    size : ndarray, shape (E, Q)
        Size of the quantity.
    applies : float
        0 if the assumption under which they were computed does not hold, so that no conclusion follows.
    """

    h: Array
    eps: Array
    error: Array
    floor: Array
    size: Array
    applies: float = 1.0


class Supremum(NamedTuple):
    """The supremum over eps of one quantity's error.

    Attributes
    ----------
    value, low, high : ndarray, shape (H,)
        The supremum with a lower and an upper bound.
    worst : ndarray, shape (H,)
        The eps that attains it.
    order, least, most : float
        Its order over the last halvings of h, with bounds; NaN if it is not resolved, minus infinity if it is
        infinite.
    seen : bool
        Whether there is an error beyond a small part of the quantity's size.
    left_out : ndarray
        The eps at which the error is unknown.
    """

    value: Array
    low: Array
    high: Array
    worst: Array
    order: float
    least: float
    most: float
    seen: bool
    left_out: Array

    @property
    def resolved(self) -> bool:
        """Whether its order is known."""
        return not np.isnan(self.order)


def suprema(record: UniformErrors) -> Iterator[Supremum]:
    """Yield the supremum of each quantity.

    An eps beyond ten times the longest step is excluded if the error is not accurate enough at all step sizes,
    because with a weak penalty stationary laws are wide, and hard to resolve. No conclusion follows for it, and it is
    mentioned.
    """
    errors, floors = (np.moveaxis(part, 2, 0) for part in (record.error, record.floor))
    for error, floor, size in zip(errors, floors, record.size.T, strict=True):
        used = (record.eps <= BEYOND * record.h[0]) | _clear(error, floor)
        kept = record._replace(eps=record.eps[used])
        found = _supremum(kept, error[used], floor[used], float(size[used].max()))
        yield found._replace(left_out=record.eps[~used])


def _clear(error: Array, floor: Array) -> Mask:
    # The eps whose error is known up to a fraction of itself, or of the largest such error.
    clear = np.isinf(error) | (floor <= KNOWN * error)
    largest = np.max(error, axis=0, initial=0.0, where=clear)
    return np.asarray((clear | (floor <= KNOWN * largest)).all(axis=1))


def _supremum(record: UniformErrors, error: Array, floor: Array, size: float) -> Supremum:
    value, worst = error.max(axis=0), record.eps[error.argmax(axis=0)]
    with np.errstate(invalid="ignore"):
        low, high = np.max(np.where(np.isinf(error), inf, error - floor), axis=0), np.max(error + floor, axis=0)
    seen = bool(np.any(np.isinf(high) | (high > EXACT * size)))
    return Supremum(value, low, high, worst, *_order(record.h, value, low, high), seen, np.empty(0))


def _order(h: Array, value: Array, low: Array, high: Array) -> tuple[float, float, float]:
    if np.isinf(value[-1]):
        return -inf, -inf, -inf
    known = np.flatnonzero(np.isfinite(high) & (low >= (1.0 - KNOWN) * high) & (low > 0.0))
    last = int(known.max(initial=0))
    first = max(last - HALVINGS, 0)
    if last - first < FEWEST or first not in known:
        return nan, nan, nan
    ratios = np.array([value[first] / value[last], low[first] / high[last], high[first] / low[last]])
    slopes = np.log(ratios) / np.log(h[first] / h[last])
    return float(slopes[0]), float(slopes[1]), float(slopes[2])


def moment_suprema(scheme: Scheme, view: Problem, steps: Sequence[int]) -> UniformErrors:
    """Return the errors of all first and second moments at T, by exact propagation.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Requires that `why_not_moments` returns an empty string for the members.
    steps : sequence of int
        Numbers of steps to T; six doublings are added.

    Returns
    -------
    UniformErrors
        First moments, then the second ones on and above the diagonal.
    """

    def of(problem: StiffnessFamily) -> tuple[Array, Array, float, float]:
        record, rate = moment_errors(scheme, problem, steps), linear_equation(OneStep(scheme, problem).equation).rate
        errors = record.errors
        # The entries of a stiff matrix are rounded to EPS of its size, which bounds the accuracy of any result.
        largest = float(record.size.max()) ** 2
        stiff = ROUNDING * EPS * problem.horizon * rate * largest
        return (
            errors,
            np.broadcast_to((record.floor + stiff)[:, None], errors.shape),
            largest,
            float(record.linear),
        )

    return _collect_errors(view, _finer(steps), stiffnesses(PER_DECADE), of)


def strong_suprema(scheme: Scheme, view: Problem, steps: Sequence[int]) -> UniformErrors:
    """Return (E |X_N - X(T)|^2)^{1/2} on one Brownian path, by exact propagation; see `linear_pair`.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Requires that `why_not_linear_pair` returns an empty string for the members.
    steps : sequence of int
        Numbers of steps to T; six doublings are added.

    Returns
    -------
    UniformErrors
        A single quantity.
    """

    def of(problem: StiffnessFamily) -> tuple[Array, Array, float, float]:
        one_step, T = OneStep(scheme, problem), problem.horizon
        found = np.array([mean_square_distance(one_step, T / count, count) for count in _finer(steps)])
        squares, off = found.T[..., None]
        roots = np.sqrt(np.maximum(squares, 0.0))
        # |sqrt(e) - sqrt(e')| <= sqrt |e - e'| for all e and e'.
        with np.errstate(divide="ignore", invalid="ignore"):
            floor = np.fmin(off / roots, np.sqrt(off))
        return roots, floor, float(np.abs(one_step.equation.initial(1)).max()), float(np.isfinite(off).all())

    return _collect_errors(view, _finer(steps), stiffnesses(PER_DECADE), of)


def invariant_suprema(scheme: Scheme, view: Problem, steps: Sequence[int]) -> UniformErrors:
    """Return the errors of stationary means by the transition operator, at the coarsest step sizes.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Requires that `why_not_operator` returns an empty string for the members.
    steps : sequence of int
        Numbers of steps to T; the first one and three doublings are used.

    Returns
    -------
    UniformErrors
        Of `invariant_observables`, in their order.
    """
    steps = [steps[0] * 2**level for level in range(OPERATOR_LEVELS)]

    def of(problem: StiffnessFamily) -> tuple[Array, Array, float | Array, float]:
        record = invariant_errors(scheme, problem, [problem.horizon / n for n in steps], (FINE, COARSE))
        size = np.maximum(record.spread, np.abs(record.exact))
        # A step that is returned to its initial state is no longer the scheme's.
        broken = np.where(record.failed > FAILED, inf, 0.0)[:, None]
        return record.errors, record.floors + broken, size, float(not record.why_not_evidence)

    return _collect_errors(view, steps, stiffnesses(OPERATORS_PER_DECADE), of)


def _collect_errors(
    view: Problem,
    steps: Sequence[int],
    eps: Array,
    of: Callable[[StiffnessFamily], tuple[Array, Array, float | Array, float]],
) -> UniformErrors:
    with np.errstate(all="ignore"):
        errors, floors, sizes, applies = zip(*(of(member(view, each)) for each in eps), strict=True)
    error = np.abs(np.stack(errors))
    lost = ~np.isfinite(error)
    return UniformErrors(
        h=np.array([view.horizon / count for count in steps]),
        eps=eps,
        error=np.where(lost, inf, error),
        floor=np.where(lost, 0.0, np.stack(floors)),
        size=np.broadcast_to(np.array(sizes).reshape(len(eps), -1), (len(eps), error.shape[2])),
        applies=min(applies),
    )


def _finer(steps: Sequence[int]) -> list[int]:
    return [*steps, *(steps[-1] * 2**level for level in range(1, FURTHER + 1))]


# Step sizes 4^-4, ..., 4^-8 of the horizon, or of the unit of time if that is shorter; and eps in steps.
LEVELS = 4.0 ** -np.arange(4.0, 9.0)
RATIOS = 10.0 ** np.array([-6.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 6.0])
# For a random family: sizes at which 1 per cent of a term of order 1 exceeds all terms of order 3/2, and
# stiffness parameters near the step size.
MEMBER_LEVELS = 4.0 ** -np.arange(7.0, 12.0)
MEMBER_RATIOS = np.array([0.125, 0.5, 2.0, 1e6])
# Every third point of the cloud, and distances to either side of the manifold, in standard deviations of the noise.
EVERY, SIDES = 3, (-1.0, 0.0, 1.0)
# Maximum number of pairs of nodes.
MOST_PAIRS = 1_000
# A defect is used if it exceeds this multiple of its rounding.
FLOORS = 300.0
# Relative accuracy of Euler's step, in units of h/eps.
NEARLY = 100.0


class UniformDefects(NamedTuple):
    """Defects of F first and second moments of an increment, at H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
        From coarse to fine.
    halves : ndarray, shape (F, H)
        Maximum over states and eps of the difference between one step and two half steps.
    ratio : ndarray, shape (F, H)
        eps/h that attains it.
    euler : ndarray, shape (F, H)
        Maximum over states of the difference from Euler's step, for the largest eps.
    floor, nearly : ndarray, shape (F, H)
        Smaller differences between steps are rounding; smaller differences from Euler's step are within its own
        error, because eps is not infinite.
    failed : ndarray, shape (H,)
        Share of steps without a root.
    """

    h: Array
    halves: Array
    ratio: Array
    euler: Array
    floor: Array
    nearly: Array
    failed: Array


def why_not_uniform_defects(scheme: Scheme, view: Any) -> str:
    """Return why one step of a family cannot be evaluated for all eps, or an empty string."""
    law, motions = scheme.law, view.noise_dim
    if law.bounded and len(law.values) ** (2 * motions) > MOST_PAIRS:
        return f"two steps with {law.name} increments in {motions} dimensions take too many values to enumerate"
    return OneStep(scheme, member(view)).why_not_probed()


def uniform_defects(scheme: Scheme, view: Any, levels: Array = LEVELS, ratios: Array = RATIOS) -> UniformDefects:
    """Return the defects of a pair; requires that `why_not_uniform_defects` returns an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
    levels : ndarray
        Step sizes in units of time, from coarse to fine.
    ratios : ndarray, ascending
        eps/h; the last one represents infinity.
    """
    sizes = levels * min(1.0, view.horizon)
    with np.errstate(all="ignore"):
        found = [_level(scheme, view, float(h), ratios) for h in sizes]
    return UniformDefects(sizes, *(np.stack(parts, axis=-1) for parts in zip(*found, strict=True)))


def _level(scheme: Scheme, view: Any, h: float, ratios: Array) -> tuple[Array, ...]:
    x, sizes, failed = _states(view, h), [], 0.0
    for ratio in ratios:
        one_step = OneStep(scheme, member(view, ratio * h))
        whole, halves = _combine_steps(one_step, x, h, 1), _combine_steps(one_step, x, 0.5 * h, 2)
        sizes.append(np.abs(whole.moments - halves.moments).max(axis=1))
        failed = max(failed, whole.failed, halves.failed)
    nodes = _nodes(one_step)
    wide = np.repeat(x, len(nodes.weights), axis=1)
    plain = _moments(one_step.euler(wide, 0.0, h, nodes.increment(h, x.shape[1])) - wide, nodes.weights)
    table, euler = np.array(sizes), np.abs(whole.moments - plain).max(axis=1)
    nearly = whole.floor + NEARLY / ratios[-1] * np.abs(plain).max()
    return table.max(axis=0), ratios[table.argmax(axis=0)], euler, whole.floor, nearly, np.asarray(failed)


def _states(view: Any, h: float) -> Array:
    """Return points on the manifold, and at the distance that the noise of a step moves them, shape (d, S)."""
    limit = member(view, 0.0)
    on = cloud(limit, limit.ito())[:, ::EVERY]
    normal = limit.push(limit.linearised(on), np.ones((limit.constraints, on.shape[1])))
    unit = normal / norm(normal)
    return np.concatenate([on + side * np.sqrt(h) * limit.strength * unit for side in SIDES], axis=1)


class _After(NamedTuple):
    # Moments (F, S) of the increment of several steps, the size of their rounding (F,), and the share without a root.
    moments: Array
    floor: Array
    failed: float


def _combine_steps(one_step: OneStep, x: Array, h: float, steps: int) -> _After:
    """Return the moments after one or more steps, over all combinations of their nodes."""
    nodes = _nodes(one_step)
    count, states = len(nodes.weights), x.shape[1]
    wide = np.repeat(x, count**steps, axis=1)
    state, step, failed = one_step.enter(wide, 0.0, h), one_step.scheme.prepare(one_step.view, h), 0.0
    weights = np.ones(1)
    for index in np.indices((count,) * steps).reshape(steps, -1):
        noise = Nodes(nodes.dW[:, index], None if nodes.H is None else nodes.H[:, index], nodes.weights[index])
        result = step(state, 0.0, noise.increment(h, states))
        state, weights = result.state, weights * noise.weights
        failed = max(failed, 0.0 if result.failed is None else float(np.mean(result.failed)))
    added = one_step.read(state) - wide
    rounding = FLOORS * EPS * np.abs(x).max() * np.array([1.0, np.abs(added).max()])
    moments = _moments(added, weights)
    return _After(moments, np.repeat(rounding, [len(x), len(moments) - len(x)]), failed)


def _moments(added: Array, weights: Array) -> Array:
    """Return the means of y_i and of y_i y_j, i <= j, shape (F, S)."""
    y = added.reshape(len(added), -1, len(weights))
    i, j = np.triu_indices(len(y))
    return np.asarray(np.concatenate([y, y[i] * y[j]]) @ weights)


def _nodes(one_step: OneStep) -> Nodes:
    noise = StepNoise.of(one_step)
    if noise.law.bounded:
        return step_nodes(noise.motions, 0, law=noise.law)
    n = noise.normals
    return noise.nodes(np.sqrt(n) * np.concatenate([np.eye(n), -np.eye(n)], axis=1), np.full(2 * n, 0.5 / n))
