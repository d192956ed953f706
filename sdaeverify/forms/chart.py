"""Few coordinates for a problem that looks larger: an angle and its velocity instead of positions and velocities."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array


@dataclass(frozen=True)
class Angle:
    """A coordinate of period 2 pi."""


@dataclass(frozen=True)
class Line:
    """A coordinate on the real line.

    Attributes
    ----------
    centre, scale : float
        Mean and standard deviation of its law, roughly and in its own unit, where the law is widest: functions of it
        are expanded in Hermite polynomials of (y - centre)/scale, up to some ten scales from the centre.
    """

    centre: float
    scale: float


@dataclass(frozen=True)
class Chart:
    """Coordinates z in at most two dimensions of all states a solution can have.

    Attributes
    ----------
    axes : tuple of Angle and Line
    embed : callable, ndarray of shape (k, P) -> ndarray of shape (d, P)
        The state of given coordinates: the rows of the problem's components, in the order of `ito`'s names; pure
        outputs, on which no coefficient depends, at 0. Analytic, so that complex steps can be made.
    read : callable, ndarray of shape (d, P) -> ndarray of shape (k, P)
        The coordinates of a state, with embed(read(x)) = x on all rows but pure outputs: an angle that is a component
        itself is not wrapped.
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
        Number of rows that are left out.
    """

    def read(x: Array) -> Array:
        return chart.read(np.concatenate([x, np.zeros((count, x.shape[1]))]))

    return replace(chart, embed=lambda z: chart.embed(z)[:-count], read=read)
