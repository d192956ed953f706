"""Charts: few coordinates for problems on low-dimensional sets, such as an angle and its velocity for a pendulum."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array


@dataclass(frozen=True)
class Angle:
    """A coordinate with period 2 pi."""


@dataclass(frozen=True)
class Line:
    """A coordinate on the real line.

    Attributes
    ----------
    centre, scale : float
        Rough mean and standard deviation of the coordinate's law at its widest, in the unit of the coordinate.
        Functions of it are expanded in Hermite polynomials of (y - centre)/scale, up to about ten scales from the
        centre.
    """

    centre: float
    scale: float


@dataclass(frozen=True)
class Chart:
    """Coordinates z, in at most two dimensions, of all states that a solution can reach.

    Attributes
    ----------
    axes : tuple of Angle and Line
    embed : callable, ndarray of shape (k, P) -> ndarray of shape (d, P)
        The state at given coordinates: the rows of the problem's components, in the order of `ito`'s names; pure
        outputs, on which no coefficient depends, are 0. Analytic, so that complex steps can be made.
    read : callable, ndarray of shape (d, P) -> ndarray of shape (k, P)
        The coordinates of a state, with embed(read(x)) = x on all rows except pure outputs. An angle that is itself a
        component is not wrapped.
    """

    axes: tuple[Angle | Line, ...]
    embed: Callable[[Array], Array]
    read: Callable[[Array], Array]


def without_rows(chart: Chart, count: int) -> Chart:
    """Return a chart whose states lack the last rows, which are pure outputs.

    Parameters
    ----------
    chart : Chart
    count : int
        Number of rows to omit.
    """

    def read(x: Array) -> Array:
        return chart.read(np.concatenate([x, np.zeros((count, x.shape[1]))]))

    return replace(chart, embed=lambda z: chart.embed(z)[:-count], read=read)
