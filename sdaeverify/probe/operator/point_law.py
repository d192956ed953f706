"""The exact law of a scheme whose increments take few values: its points, with their probabilities.

From points x_i of probability p_i a step leads, with atoms xi_k of weight w_k, to Phi_h(x_i; xi_k) of probability
p_i w_k. Points that coincide are one. Where steps can be taken in any order, as with constant or linear coefficients,
N steps of three atoms lead to (N + 1)(N + 2)/2 points in place of 3^N, and every expectation is a sum over them: that
of a jump as well, about which neither smooth test functions nor a few thousand paths say anything.

On such a lattice errors of functions that are not smooth jump about as h tends to 0, and change their sign: by where
between two points a jump lies. What falls is the largest of them over numbers of steps between N and 2N,

    E_N = max_{N <= n < 2N} |E q(X_n) - E q(x(T))| = O(N^-p).
"""

from math import inf, nan
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Parts, each
from ...contracts.scheme import Scheme, State, flatten
from ...forms import Delayed, Problem
from ..step.nodes import step_nodes

# Points of a step at most; how often N is doubled, and how many numbers of steps there are from N to 2N.
# Size: points, and numbers of steps.
MOST, DOUBLED, NUMBERS = 2**16, 4, 7
# Points are one where they differ by less than rounding of many steps, in parts of their own size and, where they are
# near 0, of a small part of the mean size. No atom is so small.
SAME, NEAR = 1e-9, 1e-3
# Points of a smaller probability are left out: all together they are less than rounding.
# Rounding: 2^16 of them are less than EPS.
UNLIKELY = 1e-22
# How many E_N an order needs.
FEWEST = 3


class PointLaw(NamedTuple):
    """Expectations of O observables at the end, for numbers of steps from N to 2N, for H values of N.

    NaN stands for those whose components are not known.

    Attributes
    ----------
    h : ndarray, shape (H,)
        Step sizes T/N, coarse to fine, as many as have few enough points.
    means : ndarray, shape (H, 7, O)
    blur : ndarray, shape (H, 7, O)
        By how much means change where all points are moved by as little as points that are one can differ.
    """

    h: Array
    means: Array
    blur: Array


def why_not_point_law(scheme: Scheme, view: Problem) -> str:
    """Return why a pair has no law on few points, or an empty string."""
    if not scheme.law.bounded:
        return f"{scheme.law.name} increments take more than a few values"
    if view.capability(Delayed) is not None or view.records or not scheme.noise <= {"dW", "H"}:
        return "its noise has parts that are not of few values"
    return "" if view.observables else "there are no observables"


def point_law(scheme: Scheme, view: Problem, coarsest: int) -> PointLaw:
    """Return the expectations of all observables at T, without sampling.

    Parameters
    ----------
    scheme : Scheme
        Of bounded increments, see `why_not_point_law`.
    view : Problem
        Of the scheme's form.
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
    """Return the order of the largest errors of an observable, or NaN where there are too few step sizes.

    Of the orders on all step sizes and without the coarsest the larger one counts, and what is not known of errors
    makes it larger.

    Parameters
    ----------
    record : PointLaw
    place : int
        Of the observable.
    exact : float
        Its expectation under the equation; where it is not known, the mean of the finest ones takes its place.
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
    """Return the means of the observables and their blur, shape (2, O); None where there are too many points.

    The blur is how much means change where all points are moved a little.
    """
    if (reached := _law_after(scheme, view, steps)) is None:
        return None
    parts, probability = scheme.parts(view, reached[0]), reached[1]
    here, *beside = (_means_of(view, parts, probability, by) for by in (0.0, -SAME, SAME))
    return np.stack([here, np.abs(np.stack(beside) - here).max(axis=0)])


def _law_after(scheme: Scheme, view: Problem, steps: int) -> tuple[State, Array] | None:
    """Return the points after so many steps, and their probabilities; None where there are too many."""
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
    """Return the points that differ, each with the probability of all that coincide with it."""
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
    """Return the place of each value among those that differ by more than is the same."""
    order = np.argsort(x)
    places = np.empty(len(x), dtype=int)
    places[order] = np.concatenate([[0], np.cumsum(np.diff(x[order]) > same[order[1:]])])
    return places


def _means_of(view: Problem, parts: Parts, probability: Array, by: float) -> Array:
    moved = {name: (1.0 + by) * part for name, part in parts.items()}
    values = (view.observe(name, view.horizon, moved) for name in view.observables)
    return np.array([np.nan if value is None else (value * probability).sum() for value in values])
