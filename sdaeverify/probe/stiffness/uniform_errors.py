"""Errors as functions of eps and h, and the order in h of their supremum over eps.

At fixed eps an error may behave in one way for h << eps and in another for h >> eps (C min(h, eps) is typical), so
that a slope fitted at fixed eps across h = eps means nothing. The supremum over a grid of eps is what
Laurent (2022), Theorem 2.7, bounds.
"""

from collections.abc import Callable, Iterator, Sequence
from math import inf, nan
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask
from ...contracts.scheme import Scheme
from ...forms import Problem, StiffnessFamily
from ...numerics.statistics import EPS
from ..linear.affine import AFFINE
from ..linear.equation import linear_equation
from ..linear.moments import MomentErrors, moment_errors
from ..linear.pair import ROUNDING, mean_square_distance
from ..operator.functional_orders import error_floors, obstacle
from ..operator.transition_errors import invariant_errors
from ..step.one_step import OneStep
from .family import member, stiffnesses

# Values of eps in a decade where moments are propagated, and where an operator is set up for each of them.
PER_DECADE, OPERATORS_PER_DECADE = 2, 1
# Functions of an angle and of a coordinate on the line, by the number of coordinates, in two bases.
FINE, COARSE = {1: (49, 18), 2: (15, 14)}, {1: (33, 12), 2: (11, 10)}
OPERATOR_LEVELS = 4
FURTHER = 6
# No error is known of a scheme that loses more of its steps.
FAILED = 0.01
# The order is that over so many halvings of h at most, to the finest h at which the supremum is known. With two eps a
# decade it moves from one to the next every 1.7 halvings.
HALVINGS, FEWEST = 5, 3
# A supremum is resolved where it is known to this part of itself.
KNOWN = 0.25
# All eps up to so many of the longest steps count.
BEYOND = 10.0
# None is seen where it is at most this part of the size of what is observed.
EXACT = 1e-6


class UniformErrors(NamedTuple):
    """Errors of Q quantities for E stiffness parameters at H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
        From coarse to fine, each half of the one before.
    eps : ndarray, shape (E,)
    error, floor : ndarray, shape (E, H, Q)
        Absolute errors, infinite where the scheme's value is no number, and how far they can be off.
    size : ndarray, shape (E, Q)
        Of what is observed.
    applies : float
        0 where the assumption under which they were found does not hold: nothing follows from them.
    """

    h: Array
    eps: Array
    error: Array
    floor: Array
    size: Array
    applies: float = 1.0


class Supremum(NamedTuple):
    """What is known of sup_eps of one quantity's error.

    Attributes
    ----------
    value, low, high : ndarray, shape (H,)
        The supremum, and what it is at least and at most.
    worst : ndarray, shape (H,)
        The eps where it is taken.
    order, least, most : float
        Its order over the last halvings of h; NaN where it is not resolved, minus infinity where it is infinite.
    seen : bool
        Whether there is an error beyond a small part of the quantity's size.
    left_out : ndarray
        The eps at which the error is not known.
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
    """Yield what is known of each quantity's supremum.

    An eps beyond ten times the longest step is left out where the error is not known well enough at all step sizes:
    with a weak penalty stationary laws are wide, and hard to resolve. Nothing follows for it, and it is named.
    """
    errors, floors = (np.moveaxis(part, 2, 0) for part in (record.error, record.floor))
    for error, floor, size in zip(errors, floors, record.size.T, strict=True):
        used = (record.eps <= BEYOND * record.h[0]) | _clear(error, floor)
        kept = record._replace(eps=record.eps[used])
        found = _supremum(kept, error[used], floor[used], float(size[used].max()))
        yield found._replace(left_out=record.eps[~used])


def _clear(error: Array, floor: Array) -> Mask:
    # The eps whose error is known to a part of itself, or of the largest one that is.
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
        Of a pair whose members `no_moments` has nothing against.
    steps : sequence of int
        Numbers of steps to T; six more follow.

    Returns
    -------
    UniformErrors
        First moments, then the second ones on and above the diagonal.
    """

    def of(problem: StiffnessFamily) -> tuple[Array, Array, float, float]:
        record, rate = moment_errors(scheme, problem, steps), linear_equation(OneStep(scheme, problem).equation).rate
        i, j = np.triu_indices(record.first.shape[1])
        errors = np.concatenate([record.first, record.second[:, i, j]], axis=1)
        # The entries of a stiff matrix are rounded to EPS of its size, whatever is computed from them.
        stiff = ROUNDING * EPS * problem.horizon * rate * _size(record)
        return errors, np.broadcast_to((record.floor + stiff)[:, None], errors.shape), _size(record), _linear(record)

    return _collected(view, _finer(steps), stiffnesses(PER_DECADE), of)


def strong_suprema(scheme: Scheme, view: Problem, steps: Sequence[int]) -> UniformErrors:
    """Return (E |X_N - X(T)|^2)^{1/2} on one Brownian path, by exact propagation; see `linear_pair`.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of a pair whose members `no_linear_pair` has nothing against.
    steps : sequence of int
        Numbers of steps to T; six more follow.

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

    return _collected(view, _finer(steps), stiffnesses(PER_DECADE), of)


def invariant_suprema(scheme: Scheme, view: Problem, steps: Sequence[int]) -> UniformErrors:
    """Return the errors of stationary means by the transition operator, at the coarsest step sizes.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of a pair whose members `transition.refusal` has nothing against.
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
        # What is put back where it began is no longer the scheme.
        broken = np.where(record.failed > FAILED, inf, 0.0)[:, None]
        return record.errors, error_floors(record) + broken, size, float(not obstacle(record))

    return _collected(view, steps, stiffnesses(OPERATORS_PER_DECADE), of)


def _collected(
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


def _size(record: MomentErrors) -> float:
    # Of the least moments met: those of a scheme that is unstable have no size.
    least = float(np.min(record.scale, initial=inf, where=np.isfinite(record.scale)))
    return least if np.isfinite(least) else 1.0


def _linear(record: MomentErrors) -> float:
    # A step that overflows shows no defect; one without root has no moments.
    return float(record.defect.max() <= AFFINE)
