"""Slopes over the levels of a record."""

from functools import cached_property
from typing import ClassVar

import numpy as np

from ..arrays import Array
from ..numerics.statistics import (
    Estimate,
    corrected_slope_weights,
    estimates,
    lower_term_weights,
    slope_weights,
    weighted_sum,
)


class Slopes:
    """Linear functionals of y_l, the base-2 logarithm of a record's values at step sizes h_l.

    Attributes
    ----------
    next_power : float
        q in y = a + p log2 h + c h^q: difference between the orders of the next and the leading term of the
        expansion.
    h : ndarray, shape (L,)
    """

    next_power: ClassVar[float] = 1.0
    h: Array

    @cached_property
    def logarithms(self) -> Array:
        """The y_l over all paths, then without one group at a time; shape (1 + G, C), levels in the first columns."""
        return self.find_logarithms()

    def find_logarithms(self) -> Array:
        """Compute the value of `logarithms`, which caches it."""
        raise NotImplementedError

    def linear(self, levels: Array, weights: Array) -> Estimate:
        """Return sum_l w_l y_l over the given levels, or other columns.

        Parameters
        ----------
        levels : ndarray of int
        weights : ndarray, shape of levels
        """
        # Also evaluated for records without errors. `take` instead of indexing keeps the C order.
        with np.errstate(invalid="ignore"):
            return estimates(weighted_sum(weights, self.logarithms.take(levels, axis=1)))[0]

    def slope(self, levels: Array) -> Estimate:
        """Return the least-squares slope on some levels."""
        return self.linear(levels, slope_weights(np.log2(self.h[levels])))

    def corrected_slope(self, levels: Array) -> Estimate:
        """Return the slope of a fit with one further term of the expansion."""
        return self.linear(levels, corrected_slope_weights(np.log2(self.h[levels]), self.next_power))

    def share_weights(self, levels: Array) -> Array:
        """Return the weights of `lower_share` on some levels, shape of levels."""
        return lower_term_weights(np.log2(self.h[levels]), self.next_power)

    def lower_share(self, levels: Array, order: float) -> Estimate:
        """Return the share of the error at the finest level that belongs to a term of half an order less.

        Parameters
        ----------
        levels : ndarray of int
            At least three.
        order : float
            p in y = p log2 h + ...; see `lower_term_weights`.
        """
        weights = self.share_weights(levels)
        found = self.linear(levels, weights)
        return found._replace(value=found.value - order * float(weights @ np.log2(self.h[levels])))

    def rise(self, levels: Array) -> Estimate:
        """Return the increase of the local order from the last pair of levels but one to the last."""
        return self.linear(levels[-3:], np.array([-1.0, 2.0, -1.0]))
