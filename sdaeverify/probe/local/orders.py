"""Local orders: powers of h with which defects decrease, above rounding and above a solver's tolerance."""

from typing import NamedTuple

import numpy as np

from ...arrays import Array

# Defects that stop decreasing below this part of the solution's size are errors of a solver's tolerance.
# Measured by tests/probe/test_local_strong.py: solvers that stop below it refute nothing, a wrong noise is seen.
TOLERANCE = 1e-6
# A lower power of h is that of a plateau.
# Theorem: the least power of a defect is 1/2, of a wrong noise; less the tolerance of strong orders.
FLAT = 0.4
# A level is used if it exceeds a plateau by this factor: the plateau then changes a local order by less than 0.03.
# Rounding: log2 of (1 + 1/30)/(1 + 1/60) is 0.023, where defects halve.
CLEAR = 30.0
# Part of the solution's size below which a defect is rounding.
# Rounding: a step and two half steps of 64 operations each err by at most 192 eps = 4.3e-14 (Higham 2002, Lemma 3.1).
ROUNDING = 6e-14
# An order that changes by less than this from one level to the next has settled.
# Theorem: elementary, a correction like h^(1/2) halves from one size to the next, a fourth of it, so that changes to
# come add up to as much again: half of the tolerance of strong orders.
SETTLED = 0.05


class LocalOrders(NamedTuple):
    """Orders of defects in h, each from the two finest usable levels.

    Attributes
    ----------
    order : ndarray, shape (...)
        Infinite if fewer than two levels are above the floor, so that the defect is rounding. NaN if the finest
        level is not finite, or if a plateau leaves fewer than two levels.
    ahead : ndarray, shape (...)
        Extrapolated next order, if it changes by the same amount again.
    plateau_h : ndarray, shape (...)
        Largest h on a plateau; 0 if there is none.
    """

    order: Array
    ahead: Array
    plateau_h: Array


def last_orders(h: Array, size: Array, floor: Array, scale: Array, used: int | None = None) -> LocalOrders:
    """Return the last local orders log(size_j/size_k) / log(h_j/h_k) above the floors.

    The tolerance of a solver appears as a plateau of the defects at small h. Levels finer than the `used` ones serve
    to detect a plateau; if there is none and the orders have converged there, they are taken from these levels.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes, coarsest first.
    size : ndarray, shape (..., H)
        Nonnegative defects.
    floor, scale : ndarray, shape (H,) or (..., H)
        Below `floor` a defect is rounding; `scale` is the size of the quantity with the defect.
    used : int, optional
        Number of levels from which orders are taken, coarsest first; all by default.

    Returns
    -------
    LocalOrders
    """
    finite = np.isfinite(size)
    usable = finite & (size > floor)
    fine = finest_usable(usable)
    order, longer = _orders(h, size, usable, fine)
    # Over two or three levels, to detect irregular errors below a tolerance as well.
    flat = ((order < FLAT) | (longer < FLAT)) & (pick(size, fine[0]) < TOLERANCE * pick(scale, fine[0]))
    plateau = np.where(flat, np.maximum(pick(size, fine[0]), pick(size, fine[1])), -1.0)
    hidden = usable & (size <= CLEAR * plateau[..., None])
    clear, wanted = usable & ~hidden, np.arange(len(h)) < (used or len(h))
    # If all levels are clear, the orders computed above can be reused.
    every = _extrapolate_order(h, size, clear) if hidden.any() else _extrapolate(order, longer)
    first = every if wanted.all() else _extrapolate_order(h, size, clear & wanted)
    with np.errstate(invalid="ignore"):
        settled = ~flat & (np.abs(every[1] - every[0]) < SETTLED)
    order, ahead = (np.where(settled, a, b) for a, b in zip(every, first, strict=True))
    known = finite[..., -1] & (finite.sum(axis=-1) > 1) & ~(flat & np.isinf(order))
    order, ahead = (np.where(known, part, np.nan) for part in (order, ahead))
    return LocalOrders(order, ahead, np.where(hidden, h, 0.0).max(axis=-1))


def worst_order(h: Array, size: Array, scale: Array) -> float:
    """Return the order of the largest defects over all states; infinite if they are rounding, NaN if not finite.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes, coarsest first.
    size, scale : ndarray, shape (S, H)
        Nonnegative defects at S states, and the size of the quantity with the defect.
    """
    worst = scale.max(axis=0)
    return float(last_orders(h, size.max(axis=0), ROUNDING * worst, worst).order)


def _extrapolate_order(h: Array, size: Array, usable: Array) -> tuple[Array, Array]:
    return _extrapolate(*_orders(h, size, usable, finest_usable(usable)))


def _extrapolate(order: Array, longer: Array) -> tuple[Array, Array]:
    """Return the last order, and the extrapolated next one, which changes by the same amount again."""
    with np.errstate(invalid="ignore"):
        # The order over three levels is the mean of two local ones: the last change is twice the difference from it.
        return order, np.where(np.isfinite(longer), order + 2.0 * (order - longer), order)


def finest_usable(usable: Array) -> tuple[Array, ...]:
    """Return the indices of the three finest usable levels, finest first; 0 if there are fewer."""
    behind = np.cumsum(usable[..., ::-1], axis=-1)[..., ::-1]
    return tuple((usable & (behind == rank)).argmax(axis=-1) for rank in (1, 2, 3))


def _orders(h: Array, size: Array, usable: Array, fine: tuple[Array, ...]) -> tuple[Array, Array]:
    """Return the orders from the second and from the third finest usable level to the finest; infinite without it."""
    last, one, two = (pick(size, index) for index in fine)
    count = usable.sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        order = np.log(one / last) / np.log(h[fine[1]] / h[fine[0]])
        longer = np.log(two / last) / np.log(h[fine[2]] / h[fine[0]])
    return np.where(count > 1, order, np.inf), np.where(count > 2, longer, np.inf)


def pick(values: Array, index: Array) -> Array:
    """Return the values at one level per place; a one-dimensional array has the same values for all places."""
    if values.ndim == 1:
        return np.asarray(values[index])
    if values.ndim <= index.ndim:
        values = np.broadcast_to(values, (*index.shape, values.shape[-1]))
    wide = values.reshape(-1, values.shape[-1])
    return np.asarray(wide[np.arange(index.size), index.ravel()].reshape(index.shape))
