"""Slopes over the levels of a record: each is found once, whatever is claimed, and however often it is asked."""

from collections.abc import Callable
from functools import cached_property, wraps
from typing import Any, ClassVar, Generic, TypeVar, cast

import numpy as np

from ..arrays import Array
from ..numerics.statistics import Estimate, corrected_slope_weights, estimates, slope_weights, weighted_sum

Method = TypeVar("Method", bound=Callable[..., Any])
Found = TypeVar("Found")


def once(method: Method) -> Method:
    """Return a method of a record, of levels and what else is given, that keeps what it finds in its `known`.

    Parameters
    ----------
    method : callable, (record, levels, *given) -> object
        A pure function; what is given beside levels can be hashed.
    """

    @wraps(method)
    def found(self: Any, levels: Any, *given: Any) -> Any:
        key = method.__name__, np.asarray(levels).tobytes(), *given
        if key not in self.known:
            self.known[key] = method(self, levels, *given)
        return self.known[key]

    return cast("Method", found)


class Record:
    """What keeps what its methods find that are asked `once`."""

    @cached_property
    def known(self) -> dict[Any, Any]:
        """What has been found."""
        return {}


class Slopes(Record, Generic[Found]):
    """What is told by y_l, the logarithm to base 2 of what a record measures at step sizes h_l.

    What is found is an estimate, or one of each of several quantities.

    Attributes
    ----------
    next_power : float
        q in y = a + p log2 h + c h^q: by how much the order of the next term of the expansion is higher.
    h : ndarray, shape (L,)
    """

    next_power: ClassVar[float] = 1.0
    h: Array

    def linear(self, levels: Array, weights: Array) -> Found:
        """Return sum_l w_l y_l over some levels.

        Parameters
        ----------
        levels : ndarray of int
        weights : ndarray, shape of levels
        """
        raise NotImplementedError

    @once
    def slope(self, levels: Array) -> Found:
        """Return the least-squares slope on some levels."""
        return self.linear(levels, slope_weights(np.log2(self.h[levels])))

    @once
    def corrected_slope(self, levels: Array) -> Found:
        """Return the slope with one further term of the expansion."""
        return self.linear(levels, corrected_slope_weights(np.log2(self.h[levels]), self.next_power))

    @once
    def rise(self, levels: Array) -> Found:
        """Return by how much the local order grows from the last but one pair of levels to the last."""
        return self.linear(levels[-3:], np.array([-1.0, 2.0, -1.0]))


class Logarithms(Slopes[tuple[Estimate, ...]]):
    """Logarithms to base 2 of the means of the quantities of a cell, over all paths and without each group.

    What is asked of one quantity is asked of the others next: it is found of all of them at once.

    Parameters
    ----------
    h : ndarray, shape (L,)
        Step sizes.
    values : ndarray, shape (1 + G, Q, C)
        Of Q quantities in C columns, those of the levels first.
    """

    def __init__(self, h: Array, values: Array) -> None:
        self.h, self.values = h, values

    def linear(self, levels: Array, weights: Array) -> tuple[Estimate, ...]:
        """Return sum_l w_l y_l over some levels, or other columns, of each quantity."""
        # Of quantities without errors as well. Taken, and not indexed: in C order.
        with np.errstate(invalid="ignore"):
            return estimates(weighted_sum(weights, self.values.take(levels, axis=2)))


class Sloped(Record):
    """One of the quantities of a cell that slopes are found of together.

    Attributes
    ----------
    place : int
        Its place among these.
    """

    place: int

    @property
    def together(self) -> Slopes[tuple[Estimate, ...]]:
        """The slopes of all of them."""
        raise NotImplementedError

    def slope(self, levels: Array) -> Estimate:
        """Return the least-squares slope on some levels."""
        return self.together.slope(levels)[self.place]

    def corrected_slope(self, levels: Array) -> Estimate:
        """Return the slope with one further term of the expansion."""
        return self.together.corrected_slope(levels)[self.place]

    def rise(self, levels: Array) -> Estimate:
        """Return by how much the local order grows from the last but one pair of levels to the last."""
        return self.together.rise(levels)[self.place]


def of_each(values: Array) -> list[tuple[Estimate, ...]]:
    """Return C estimates of each of Q quantities, from values of shape (1 + G, Q, C)."""
    found, columns = estimates(values.reshape(len(values), -1)), values.shape[-1]
    return [found[start : start + columns] for start in range(0, len(found), columns)]
