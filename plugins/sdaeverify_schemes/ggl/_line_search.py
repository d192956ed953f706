"""One Newton update for implicit Euler steps in GGL form, with Armijo's line search."""

from typing import NamedTuple, TypeVar

import numpy as np

from sdaeverify import Array, Mask

from ._equations import Defects, Equations, Unknowns
from ._linearised import Linearised

# Required fraction of the decrease of |F|^2 predicted by the linearisation.
ARMIJO = 1e-4
# Shortest fraction of the update.
SHORTEST = 1e-3

Record = TypeVar("Record", Unknowns, Defects)


class Iterate(NamedTuple):
    """The present iterate on some paths.

    Attributes
    ----------
    equations : Equations
    x : Unknowns
    F : Defects
        Residuals at x.
    """

    equations: Equations
    x: Unknowns
    F: Defects

    def of(self, paths: Array) -> "Iterate":
        """Return a subset of the paths."""
        return Iterate(self.equations.of(paths), take_paths(self.x, paths), take_paths(self.F, paths))


class Searched(NamedTuple):
    """The first of s = 1, 1/2, 1/4, ... with |F(x + s update)|^2 <= (1 - 2 c s) |F(x)|^2.

    Attributes
    ----------
    here : Iterate
    lower : ndarray of bool, shape (P,)
        Whether there is such a point; otherwise the path stays at x.
    halvings : ndarray of int, shape (P,)
    """

    here: Iterate
    lower: Mask
    halvings: Array


def search_line(old: Iterate, L: Linearised) -> Searched:
    """Follow Newton's update as long as it decreases |F|^2, or changes it by less than its rounding error."""
    update = L.update(old.F)
    x = Unknowns(*map(np.add, old.x, update))
    F = old.equations.defects(x)
    low = F.square <= bound(old, 0.0, 1.0)
    if low.all():
        return Searched(Iterate(old.equations, x, F), low, np.zeros(low.size, dtype=np.int64))
    return _halve(old, update, Iterate(old.equations, x, F), _bound_rounding(old, L))


def _halve(old: Iterate, update: Unknowns, full: Iterate, known: Array) -> Searched:
    (_, x, F), s = full, np.ones_like(known)
    high = np.flatnonzero(~(F.square <= bound(old, known, s)))
    while high.size and s.min() > SHORTEST:
        s[high] *= 0.5
        nearer = take_paths(old.x, high).moved(s[high], take_paths(update, high))
        x, F = replace_paths(x, high, nearer), replace_paths(F, high, old.equations.of(high).defects(nearer))
        high = high[~(F.square <= bound(old, known, s))[high]]
    lower = np.ones(s.size, dtype=bool)
    lower[high] = False
    if high.size:
        x, F = replace_paths(x, high, take_paths(old.x, high)), replace_paths(F, high, take_paths(old.F, high))
    return Searched(Iterate(old.equations, x, F), lower, np.round(-np.log2(s)).astype(np.int64))


def bound(old: Iterate, known: Array | float, s: Array | float) -> Array:
    """Return the largest |F|^2 that is accepted after a fraction s of the update."""
    return np.asarray((1.0 - 2.0 * ARMIJO * s) * old.F.square + known)


def _bound_rounding(old: Iterate, L: Linearised) -> Array:
    # Rounding error of |F|^2.
    of_each = zip(old.F.parts, L.rounding(old.x, old.F), strict=True)
    return np.asarray(sum(len(part) * rounding**2 for part, rounding in of_each))


def take_paths(record: Record, paths: Array) -> Record:
    """Return a record of arrays restricted to some paths."""
    return type(record)(*(part[..., paths] for part in record))


def replace_paths(record: Record, paths: Array, other: Record) -> Record:
    """Return a record of arrays with some paths replaced by those of another record, in order."""
    if paths.size == record[0].shape[-1]:
        return other
    parts = [np.array(part) for part in record]
    for part, new in zip(parts, other, strict=True):
        part[..., paths] = new
    return type(record)(*parts)
