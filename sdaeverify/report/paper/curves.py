"""Errors of several schemes in one figure, with slope triangles of their claimed orders."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, isnan
from typing import TYPE_CHECKING, Any

import numpy as np

from ...arrays import Array
from .axes import COLUMN_WIDTH, PAPER, PAPER_HEIGHT, as_label, axes_of, label_decades, label_steps, mark_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
else:
    Axes = Any

# Factor between the lowest curve and a triangle; the same space is left for its label.
GAP = 2.0
LEGEND_COLUMNS, LEGEND_LINE = 2, 0.14


@dataclass(frozen=True)
class ErrorCurve:
    """Errors of a scheme against the step size.

    Attributes
    ----------
    label : str
    claimed_order : float
        Claimed order; NaN without a claim.
    h, error, half_width : array, (level)
        Step sizes, absolute errors, and half the width of their intervals.
    """

    label: str
    claimed_order: float
    h: Array
    error: Array
    half_width: Array


def draw_curves(curves: Sequence[ErrorCurve], labels: tuple[str, str], ax: Axes | None, style: str) -> Axes:
    """Draw error curves with intervals, slope triangles of the claimed orders, and a legend.

    Parameters
    ----------
    curves : sequence of ErrorCurve
    labels : tuple of str
        Label of the error axis, and the title, which is omitted for a paper because its caption has it.
    ax : Axes or None
    style : str
    """
    own = ax is None
    ax = axes_of(ax, _size(len(curves)) if style == PAPER else None)
    ax.set(xscale="log", yscale="log", xlabel="step size $h$", ylabel=labels[0])
    for number, curve in enumerate(curves):
        # If an interval contains 0, its lower end is off a logarithmic axis, and the bar ends at the marker.
        below = np.where(curve.half_width < curve.error, curve.half_width, 0.0)
        ends = np.array([below, curve.half_width])
        mark = mark_of(number)
        ax.errorbar(curve.h, curve.error, ends, mfc="none", label=as_label(curve.label), **mark)
    _draw_triangles(ax, curves)
    label_steps(ax, [float(size) for curve in curves for size in curve.h], style)
    label_decades(ax)
    if style != PAPER:
        ax.set_title(as_label(labels[1]))
    _add_legend(ax, own=own, style=style)
    # Ticks take their fonts from the style when they are created, at the first drawing.
    ax.figure.canvas.draw()
    return ax


def _size(curves: int) -> tuple[float, float]:
    return COLUMN_WIDTH, PAPER_HEIGHT + LEGEND_LINE * ceil(curves / LEGEND_COLUMNS)


def _add_legend(ax: Axes, *, own: bool, style: str) -> None:
    if own and style == PAPER:
        ax.figure.legend(
            loc="outside upper left", ncols=LEGEND_COLUMNS, frameon=False, columnspacing=1.0, handletextpad=0.4
        )
    else:
        ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0, frameon=False, fontsize=7)


def _draw_triangles(ax: Axes, curves: Sequence[ErrorCurve]) -> None:
    """Draw a triangle for each claimed order below all curves, from the coarsest step sizes on."""
    orders = sorted({curve.claimed_order for curve in curves if not isnan(curve.claimed_order)}, reverse=True)
    sizes = sorted({float(size) for curve in curves for size in curve.h}, reverse=True)
    for order, (coarse, fine) in zip(orders, pairwise(sizes), strict=False):
        high = min(_within(curves, fine, coarse)) / GAP
        low = high * (fine / coarse) ** order
        ax.fill([fine, coarse, coarse], [low, low, high], facecolor="0.92", edgecolor="0.4", lw=0.6)
        ax.annotate(f"{order:g}", ((coarse * fine) ** 0.5, low), (0, -2), textcoords="offset points",
                    ha="center", va="top", fontsize=6)  # fmt: skip
    low, high = ax.get_ylim()
    ax.set_ylim(low / GAP if orders else low, high)


def _within(curves: Iterable[ErrorCurve], low: float, high: float) -> list[float]:
    return [
        float(error)
        for curve in curves
        for size, error in zip(curve.h, curve.error, strict=True)
        if low <= size <= high
    ]
