"""Exact law of a scheme with discrete increments: its points and their probabilities.

With atoms xi_k of weight w_k, a step maps a point x_i of probability p_i to points Phi_h(x_i; xi_k) of probability
p_i w_k. Coinciding points are merged. If steps commute, as with constant or linear coefficients, N steps of three
atoms lead to (N + 1)(N + 2)/2 points instead of 3^N, and every expectation is a sum over them. This includes
expectations of jump functions, for which smooth test functions or a few thousand paths give no information.

On such a lattice the errors of nonsmooth functions are irregular in h and change sign, depending on the position of a
jump between two points. The quantity that decreases is their maximum over numbers of steps between N and 2N,

    E_N = max_{N <= n < 2N} |E q(X_n) - E q(x(T))| = O(N^-p).
"""

from math import inf, nan
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Parts, each
from ...contracts.scheme import Scheme, State, flatten
from ...forms import Delayed, Problem
from ..step.nodes import step_nodes

# Most points of a step; number of doublings of N, and of numbers of steps from N to 2N.
# Size: points, and numbers of steps.
MOST, DOUBLED, NUMBERS = 2**16, 4, 7
# Points are merged if they differ by less than rounding errors of many steps, relative to their size or, near 0, to a
# small part of the mean size. Distances between distinct atoms are larger.
# Rounding: 4e6 operations of eps; what the means change by it counts as their error.
SAME, NEAR = 1e-9, 1e-3
# Points of smaller probability are dropped: altogether their probability is below rounding.
# Rounding: 2^16 of them are less than EPS.
UNLIKELY = 1e-22
# Number of E_N that an order needs.
# Theorem: elementary, a local order needs two values, and its change a third.
FEWEST = 3


class PointLaw(NamedTuple):
    """Expectations of O observables at the end, for numbers of steps from N to 2N, for H values of N.

    They are NaN for observables with unknown components.

    Attributes
    ----------
    h : ndarray, shape (H,)
        Step sizes T/N, coarse to fine, as far as the number of points is small enough.
    means : ndarray, shape (H, 7, O)
    blur : ndarray, shape (H, 7, O)
        Change of the means if all points are moved by the tolerance of merging.
    """

    h: Array
    means: Array
    blur: Array


def why_not_point_law(scheme: Scheme, view: Problem) -> str:
    """Return why a scheme has no law on few points, or an empty string."""
    if not scheme.law.bounded:
        return f"{scheme.law.name} increments take too many values"
    if view.capability(Delayed) is not None or view.records or not scheme.noise <= {"dW", "H"}:
        return "some of its noise is not discrete"
    return "" if view.observables else "the problem has no observables"


def point_law(scheme: Scheme, view: Problem, coarsest: int) -> PointLaw:
    """Return the expectations of all observables at T, without sampling.

    Parameters
    ----------
    scheme : Scheme
        Scheme with discrete increments, see `why_not_point_law`.
    view : Problem
        Problem in the scheme's form.
    coarsest : int
        Number of steps on the coarsest level.
    """
    found: list[Array] = []
    with np.errstate(all="ignore"):
        for number in (coarsest << doubled for doubled in range(DOUBLED)):
            means = [_expectations(scheme, view, number + number * k // NUMBERS) for k in range(NUMBERS)]
            known = [each_one for each_one in means if each_one is not None]
            if len(known) < NUMBERS:
                break
            found.append(np.stack(known))
    values = np.reshape(found, (len(found), NUMBERS, 2, len(view.observables)))
    return PointLaw(view.horizon / (coarsest << np.arange(len(found))), values[:, :, 0], values[:, :, 1])


def largest_errors_order(record: PointLaw, place: int, exact: float = nan) -> float:
    """Return the order of the largest errors of an observable, or NaN if there are too few step sizes.

    The larger of the orders on all step sizes and without the coarsest is returned, and the uncertainty of the errors
    increases it.

    Parameters
    ----------
    record : PointLaw
    place : int
        Index of the observable.
    exact : float
        Its expectation for the equation; if NaN, the mean over the finest step sizes is used instead.
    """
    means, blur = record.means[..., place], record.blur[..., place]
    if len(means) < FEWEST or not np.isfinite(means).all():
        return nan
    errors = np.abs(means - (means[-1].mean() if np.isnan(exact) else exact))
    coarse, finest = (errors + blur)[:-1].max(axis=1), np.maximum(errors - blur, 0.0)[-1].max()
    if not finest > 0.0:
        return inf
    orders = np.log2(coarse / finest) / np.arange(len(coarse), 0.0, -1.0)
    return float(orders[:2].max())


def _expectations(scheme: Scheme, view: Problem, steps: int) -> Array | None:
    """Return the means of the observables and their blur, shape (2, O); None if there are too many points.

    The blur is the change of the means if all points are moved by the tolerance of merging.
    """
    if (reached := _law_after(scheme, view, steps)) is None:
        return None
    parts, probability = scheme.parts(view, reached[0]), reached[1]
    here, *beside = (_means_of(view, parts, probability, by) for by in (0.0, -SAME, SAME))
    return np.stack([here, np.abs(np.stack(beside) - here).max(axis=0)])


def _law_after(scheme: Scheme, view: Problem, steps: int) -> tuple[State, Array] | None:
    """Return the points after some steps, and their probabilities; None if they are too many or a step fails."""
    nodes = step_nodes(view.noise_dim, 1, areas="H" in scheme.noise, law=scheme.law)
    h, atoms = view.horizon / steps, len(nodes.weights) if nodes.exact else MOST
    make = scheme.prepare(view, h)
    state, probability = scheme.start(view, 1, h), np.ones(1)
    for step in range(steps):
        count = len(probability)
        if count * atoms > MOST:
            return None
        wide = each(lambda part: np.repeat(part, atoms, axis=-1), state)
        made = make(wide, step * h, nodes.increment(h, count))
        if made.failed is not None and made.failed.any():
            return None
        state, probability = _merge(made.state, np.outer(probability, nodes.weights).ravel())
    return state, probability


def _merge(state: State, probability: Array) -> tuple[State, Array]:
    """Return the distinct points, with the sums of the probabilities of coinciding points."""
    x = flatten(state)
    near = SAME * NEAR * (np.abs(x) @ probability)
    values = np.stack([_number_values(row, SAME * np.abs(row) + least) for row, least in zip(x, near, strict=True)])
    order = np.lexsort(values)
    apart = np.diff(values[:, order], axis=1).any(axis=0)
    first, group = order[np.concatenate([[True], apart])], np.concatenate([[0], np.cumsum(apart)])
    merged = np.bincount(group, probability[order])
    likely = merged > UNLIKELY
    return each(lambda part: part[..., first[likely]], state), merged[likely]


def _number_values(x: Array, same: Array) -> Array:
    """Return for each value the index of its cluster; neighbours in a cluster differ by at most `same`."""
    order = np.argsort(x)
    places = np.empty(len(x), dtype=int)
    places[order] = np.concatenate([[0], np.cumsum(np.diff(x[order]) > same[order[1:]])])
    return places


def _means_of(view: Problem, parts: Parts, probability: Array, by: float) -> Array:
    moved = {name: (1.0 + by) * part for name, part in parts.items()}
    values = (view.observe(name, view.horizon, moved) for name in view.observables)
    return np.array([np.nan if value is None else (value * probability).sum() for value in values])
