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
    """What is told by y_l, the logarithm to base 2 of what a record measures at step sizes h_l.

    Attributes
    ----------
    next_power : float
        q in y = a + p log2 h + c h^q: by how much the order of the next term of the expansion is higher.
    h : ndarray, shape (L,)
    """

    next_power: ClassVar[float] = 1.0
    h: Array

    @cached_property
    def logarithms(self) -> Array:
        """Y over all paths and without each group, shape (1 + G, C): in columns, those of the levels first."""
        return self.find_logarithms()

    def find_logarithms(self) -> Array:
        """Return the `logarithms`; they are asked for once."""
        raise NotImplementedError

    def linear(self, levels: Array, weights: Array) -> Estimate:
        """Return sum_l w_l y_l over some levels, or other columns.

        Parameters
        ----------
        levels : ndarray of int
        weights : ndarray, shape of levels
        """
        # Of a record without errors as well. Taken, and not indexed: in C order.
        with np.errstate(invalid="ignore"):
            return estimates(weighted_sum(weights, self.logarithms.take(levels, axis=1)))[0]

    def slope(self, levels: Array) -> Estimate:
        """Return the least-squares slope on some levels."""
        return self.linear(levels, slope_weights(np.log2(self.h[levels])))

    def corrected_slope(self, levels: Array) -> Estimate:
        """Return the slope with one further term of the expansion."""
        return self.linear(levels, corrected_slope_weights(np.log2(self.h[levels]), self.next_power))

    def share_weights(self, levels: Array) -> Array:
        """Return the weights of `lower_share` on some levels, shape of levels."""
        return lower_term_weights(np.log2(self.h[levels]), self.next_power)

    def lower_share(self, levels: Array, order: float) -> Estimate:
        """Return the share of the error at the finest level that a term of half an order less has.

        Parameters
        ----------
        levels : ndarray of int
            Three at least.
        order : float
            p in y = p log2 h + ...; see `lower_term_weights`.
        """
        weights = self.share_weights(levels)
        found = self.linear(levels, weights)
        return found._replace(value=found.value - order * float(weights @ np.log2(self.h[levels])))

    def rise(self, levels: Array) -> Estimate:
        """Return by how much the local order grows from the last but one pair of levels to the last."""
        return self.linear(levels[-3:], np.array([-1.0, 2.0, -1.0]))
