"""Local orders: how fast defects vanish with h, above rounding and above the tolerance of a scheme's own solver."""

from typing import NamedTuple

import numpy as np

from ...arrays import Array

# Defects that stop decreasing below this part of the solution's size are a solver's tolerance.
TOLERANCE = 1e-6
FLAT = 0.35
# A level is used where it is so many times a plateau: the plateau then moves a local order by less than 0.03.
# Rounding: log2 of (1 + 1/30)/(1 + 1/60) is 0.023, where defects halve.
CLEAR = 30.0
# Rounding errors of a defect stay some hundred times below this part of the solution's size.
ROUNDING = 6e-14
# An order that changes by less from one level to the next has settled.
SETTLED = 0.05


class LocalOrders(NamedTuple):
    """The orders of some defects in h, each between the two finest usable levels.

    Attributes
    ----------
    order : ndarray, shape (...)
        Infinite where fewer than two levels are above the floor: the defect is rounding. NaN where the finest
        level is not finite, and where a plateau leaves fewer than two levels.
    ahead : ndarray, shape (...)
        What the next order would be if it changed as much again as it did since the last one.
    plateau_h : ndarray, shape (...)
        The largest h at which a plateau shows; 0 where there is none.
    """

    order: Array
    ahead: Array
    plateau_h: Array


def last_orders(h: Array, size: Array, floor: Array, scale: Array, used: int | None = None) -> LocalOrders:
    """Return the last local orders log(size_j/size_k) / log(h_j/h_k) above the floors.

    A tolerance shows as a plateau only once the defect is well below it. Finer levels than those that orders are
    taken from show it; where they do not, and the order has settled on them, it is taken there.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes, coarsest first.
    size : ndarray, shape (..., H)
        Defects, not negative.
    floor, scale : ndarray, shape (H,) or (..., H)
        Below the first, a defect is rounding; the second is the size of what it is a defect of.
    used : int, optional
        Number of levels that orders are taken from, coarsest first; all if left out.

    Returns
    -------
    LocalOrders
    """
    finite = np.isfinite(size)
    usable = finite & (size > floor)
    fine = finest_usable(usable)
    order, longer = _orders(h, size, usable, fine)
    # Over two or three levels, so that errors that jump about below a tolerance are seen as well.
    flat = ((order < FLAT) | (longer < FLAT)) & (pick(size, fine[0]) < TOLERANCE * pick(scale, fine[0]))
    plateau = np.where(flat, np.maximum(pick(size, fine[0]), pick(size, fine[1])), -1.0)
    hidden = usable & (size <= CLEAR * plateau[..., None])
    clear, wanted = usable & ~hidden, np.arange(len(h)) < (used or len(h))
    # What is asked of the same levels once more is known.
    every = _extrapolate_order(h, size, clear) if hidden.any() else _extrapolate(order, longer)
    first = every if wanted.all() else _extrapolate_order(h, size, clear & wanted)
    with np.errstate(invalid="ignore"):
        settled = ~flat & (np.abs(every[1] - every[0]) < SETTLED)
    order, ahead = (np.where(settled, a, b) for a, b in zip(every, first, strict=True))
    known = finite[..., -1] & (finite.sum(axis=-1) > 1) & ~(flat & np.isinf(order))
    order, ahead = (np.where(known, part, np.nan) for part in (order, ahead))
    return LocalOrders(order, ahead, np.where(hidden, h, 0.0).max(axis=-1))


def worst_order(h: Array, size: Array, scale: Array) -> float:
    """Return the order of the largest defects of all states; infinite if they are rounding, NaN if not finite.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes, coarsest first.
    size, scale : ndarray, shape (S, H)
        Defects at S states, not negative, and the size of what they are defects of.
    """
    worst = scale.max(axis=0)
    return float(last_orders(h, size.max(axis=0), ROUNDING * worst, worst).order)


def _extrapolate_order(h: Array, size: Array, usable: Array) -> tuple[Array, Array]:
    return _extrapolate(*_orders(h, size, usable, finest_usable(usable)))


def _extrapolate(order: Array, longer: Array) -> tuple[Array, Array]:
    """Return the last order, and the next one if it changes as much again."""
    with np.errstate(invalid="ignore"):
        # The order over three levels is the mean of two local ones: the last changed by twice what lies between.
        return order, np.where(np.isfinite(longer), order + 2.0 * (order - longer), order)


def finest_usable(usable: Array) -> tuple[Array, ...]:
    """Return the indices of the three finest usable levels, finest first; 0 where there are fewer."""
    behind = np.cumsum(usable[..., ::-1], axis=-1)[..., ::-1]
    return tuple((usable & (behind == rank)).argmax(axis=-1) for rank in (1, 2, 3))


def _orders(h: Array, size: Array, usable: Array, fine: tuple[Array, ...]) -> tuple[Array, Array]:
    """Return the orders between the finest usable level and the first and the second one before it."""
    last, one, two = (pick(size, index) for index in fine)
    count = usable.sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        order = np.log(one / last) / np.log(h[fine[1]] / h[fine[0]])
        longer = np.log(two / last) / np.log(h[fine[2]] / h[fine[0]])
    return np.where(count > 1, order, np.inf), np.where(count > 2, longer, np.inf)


def pick(values: Array, index: Array) -> Array:
    """Return the values at a level of its own in each place; those of one row are the same for all places."""
    if values.ndim == 1:
        return np.asarray(values[index])
    if values.ndim <= index.ndim:
        values = np.broadcast_to(values, (*index.shape, values.shape[-1]))
    wide = values.reshape(-1, values.shape[-1])
    return np.asarray(wide[np.arange(index.size), index.ravel()].reshape(index.shape))
