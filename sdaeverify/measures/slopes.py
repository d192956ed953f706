"""Slopes over the levels of a record: each is found once, whatever is claimed, and however often it is asked."""

from collections.abc import Callable
from functools import cached_property, wraps
from typing import Any, ClassVar, TypeVar, cast

import numpy as np

from ..arrays import Array
from ..numerics.statistics import Estimate, corrected_slope_weights, estimates, slope_weights, weighted_sum

Method = TypeVar("Method", bound=Callable[..., Any])


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


class Logarithms:
    """Logarithms to base 2 of the means that a cell's quantities measure, over all paths and without each group.

    What is asked of one quantity is asked of the others next: it is found of all of them at once.

    Parameters
    ----------
    values : ndarray, shape (1 + G, Q, C)
        Of Q quantities in C columns.
    """

    def __init__(self, values: Array) -> None:
        self.values = values
        self.known: dict[tuple[bytes, bytes], tuple[Estimate, ...]] = {}

    def linear(self, columns: Array, weights: Array) -> tuple[Estimate, ...]:
        """Return sum_c w_c y_c over some columns, of each quantity."""
        key = columns.tobytes(), weights.tobytes()
        if key not in self.known:
            # Of quantities without errors as well. Taken, and not indexed: in C order.
            with np.errstate(invalid="ignore"):
                self.known[key] = estimates(weighted_sum(weights, self.values.take(columns, axis=2)))
        return self.known[key]


def of_each(values: Array) -> list[tuple[Estimate, ...]]:
    """Return C estimates of each of Q quantities, from values of shape (1 + G, Q, C)."""
    found, columns = estimates(values.reshape(len(values), -1)), values.shape[-1]
    return [found[start : start + columns] for start in range(0, len(found), columns)]


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
    def known(self) -> dict[Any, Any]:
        """What has been found."""
        return {}

    def linear(self, levels: Array, weights: Array) -> Estimate:
        """Return sum_l w_l y_l over some levels.

        Parameters
        ----------
        levels : ndarray of int
        weights : ndarray, shape of levels
        """
        raise NotImplementedError

    @once
    def slope(self, levels: Array) -> Estimate:
        """Return the least-squares slope on some levels."""
        return self.linear(levels, slope_weights(np.log2(self.h[levels])))

    @once
    def corrected_slope(self, levels: Array) -> Estimate:
        """Return the slope with one further term of the expansion."""
        return self.linear(levels, corrected_slope_weights(np.log2(self.h[levels]), self.next_power))

    @once
    def rise(self, levels: Array) -> Estimate:
        """Return by how much the local order grows from the last but one pair of levels to the last."""
        return self.linear(levels[-3:], np.array([-1.0, 2.0, -1.0]))
