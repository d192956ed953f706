"""The entries on and above the diagonal of symmetric matrices, as vectors."""

from functools import cache
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Mask


class Upper(NamedTuple):
    """Where the q = p (p + 1)/2 entries on and above the diagonal are.

    Attributes
    ----------
    i, j : ndarray of int, shape (q,)
        i <= j.
    number : ndarray of int, shape (p, p)
        The entry's place among them, or that of its mirror image.
    """

    i: Array
    j: Array
    number: Array

    @property
    def diagonal(self) -> Mask:
        """Tell which entries are on the diagonal, shape (q,)."""
        return np.asarray(self.i == self.j)

    @classmethod
    @cache
    def of(cls, p: int) -> "Upper":
        """Return the places for matrices of size p."""
        i, j = np.triu_indices(p)
        number = np.empty((p, p), dtype=int)
        number[i, j] = number[j, i] = np.arange(len(i))
        return cls(i, j, number)
