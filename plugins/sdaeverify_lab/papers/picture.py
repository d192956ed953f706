"""Figures of the panels of an experiment, by matplotlib (extra `plot`)."""

from collections.abc import Sequence
from itertools import count, cycle
from math import ceil, floor, log10
from pathlib import Path
from typing import Any

import numpy as np

from sdaeverify import Array, UsageError

from .exhibit import Curve, Panel

MISSING = "no picture without matplotlib: pip install 'sdaeverify[plot]'"
# Size of a panel in inches.
WIDTH, HEIGHT = 5.2, 3.9
COLUMNS, IN_A_ROW = 2, 3
# Colour-blind safe colours of Okabe and Ito, and marks that distinguish curves without colour.
HUES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8B6F47")
MARKS = "os^vDPX*"
GREY, DASHES = "0.45", ("--", ":", "-.")
# Largest number of labels that fit inside the axes.
FEW = 4
# Text stays text in SVG, so that it can be searched and the file is half as large.
SETTINGS: Any = {"font.size": 9.0, "axes.titlesize": 9.5, "legend.fontsize": 7.5, "svg.fonttype": "none"}
SETTINGS["svg.hashsalt"] = "sdaeverify"


def draw(panels: Sequence[Panel], title: str, path: Path) -> None:
    """Draw panels into a file; the suffix determines the format.

    Parameters
    ----------
    panels : sequence of Panel
    title : str
        Title of the whole figure.
    path : Path
        File with a suffix of a format that matplotlib supports.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    try:
        from matplotlib import rc_context  # noqa: PLC0415 - only pictures need it
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
        from matplotlib.figure import Figure  # noqa: PLC0415
    except ImportError as error:
        raise UsageError(MISSING) from error
    columns = len(panels) if len(panels) <= IN_A_ROW else COLUMNS
    rows = ceil(len(panels) / columns)
    with rc_context(SETTINGS):
        figure = Figure(layout="constrained", figsize=(WIDTH * columns, HEIGHT * rows + 0.4))
        FigureCanvasAgg(figure)
        figure.suptitle(title, fontsize=10.0, wrap=True)
        axes = np.ravel(figure.subplots(rows, columns, squeeze=False))
        for panel, ax in zip(panels, axes, strict=False):
            _draw_panel(panel, ax)
        for ax in axes[len(panels) :]:
            ax.set_visible(False)
        # Without a date, so that the same numbers give the same file.
        figure.savefig(path, dpi=110, metadata={"Date": None} if path.suffix in {".svg", ".pdf"} else None)


def _draw_panel(panel: Panel, ax: Any) -> None:
    ax.set(title=panel.title, xlabel=panel.x, ylabel=panel.y)
    for axis in panel.log:
        getattr(ax, f"set_{axis}scale")("log")
    if panel.equal:
        ax.set_aspect("equal", adjustable="datalim")
    for each in panel.ranges:
        ax.axvspan(each.low, each.high, color="0.88", lw=0, zorder=0, label=each.label)
    if not panel.y:
        ax.set_yticks([])
    ax.grid(visible=True, which="major", color="0.9", lw=0.6)
    hues, dashes = count(), cycle(DASHES)
    for curve in panel.curves:
        guide = curve.kind == "guide"
        hue = next(hues) if curve.hue is None and not guide else curve.hue
        _draw_curve(curve, ax, hue, next(dashes) if guide and hue is None else "--")
    for axis in panel.log:
        _unclutter(getattr(ax, f"{axis}axis"), *getattr(ax, f"get_{axis}lim")())
    _explain(panel, ax)


def _unclutter(axis: Any, low: float, high: float) -> None:
    """Label powers of 10 if an axis has two of them, otherwise 2 and 5 times a power as well."""
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator  # noqa: PLC0415 - only pictures need it

    if floor(log10(high)) > ceil(log10(low)):
        axis.set_tick_params(which="minor", labelbottom=False, labelleft=False)
    else:
        axis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
        axis.set_minor_formatter(LogFormatterSciNotation(minor_thresholds=(np.inf, np.inf)))


def _explain(panel: Panel, ax: Any) -> None:
    """Place the legend inside the axes if it fits, otherwise below."""
    labels = [each for each in (*(c.label for c in panel.curves), *(r.label for r in panel.ranges)) if each]
    if len(labels) > FEW:
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, frameon=False)
    elif labels:
        ax.legend(frameon=True, framealpha=0.8, edgecolor="none")


def _draw_curve(curve: Curve, ax: Any, hue: int | None, dash: str) -> None:
    colour = GREY if hue is None else HUES[hue % len(HUES)]
    mark, label = MARKS[(hue or 0) % len(MARKS)], curve.label or None
    if curve.kind == "band":
        ax.fill_between(curve.x, curve.low, curve.high, color=colour, alpha=0.18, lw=0)
        ax.plot(curve.x, curve.y, color=colour, lw=1.3, label=label)
        return
    styles: dict[str, dict[str, Any]] = {
        "points": {"marker": mark, "ms": 4.0, "lw": 1.1},
        "marks": {"marker": mark, "ms": 4.5, "ls": "none"},
        "line": {"lw": 1.4},
        "guide": {"lw": 1.0, "ls": dash},
        "printed": {"marker": "x", "ms": 7.0, "mew": 1.6, "ls": "none"},
    }
    ax.errorbar(curve.x, curve.y, yerr=_bars(curve), color=colour, capsize=2.0, label=label, **styles[curve.kind])


def _bars(curve: Curve) -> Array | None:
    if curve.low is None or curve.high is None:
        return None
    return np.asarray(np.maximum(np.stack([curve.y - curve.low, curve.high - curve.y]), 0.0))
