"""Figures of a result: matplotlib axes drawn from the tables."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, isnan, nan
from operator import attrgetter
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contracts.labels import is_glob, is_named, split_list
from ..errors import UsageError
from .cells import Row, number, text
from .folders import Key, key_of
from .paper.axes import SCREEN, axes_of, in_style, label_decades, label_steps, mark_of, save_figure
from .paper.curves import ErrorCurve, draw_curves
from .pictures import CLEAR, axis_of, claimed_slopes, known_order, reach
from .sentences import ABSENT, SYMBOLS
from .verdict_row import VerdictRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes
else:
    Axes = Any

# Prefix of quantities that are densities, followed by the number of the coordinate.
DENSITY = "density of coordinate"
# Height in inches of a line of tick labels of size 7, and margin around the fields of the matrix.
LINE, AROUND = 0.16, 2.2
STYLES = {"line": "-C0", "claim": "--C2", "least": ":C1"}
LabelOf = Callable[[VerdictRow], str]
PointOf = Callable[[VerdictRow, Row], tuple[float, float]]
COLOURS = {
    "refuted": "#b3261e", "diverged": "#8250df", "error": "#8250df", "inconclusive": "#e3b341",
    "not_run": "#d0d7de", "verified": "#1a7f37", "out_of_scope": "#eef1f4", "not_applicable": "#ffffff",
}  # fmt: skip


@dataclass(frozen=True, repr=False)
class Plots:
    """Figures of the tables of a run; each method returns the axes it has drawn on.

    Parameters
    ----------
    rows : sequence of VerdictRow
    levels, details : sequence of mapping
        Rows of the levels, and of the details of all measures.
    confidence : float
        Confidence of the intervals.
    """

    rows: Sequence[VerdictRow]
    levels: Sequence[Row]
    details: Sequence[Row] = ()
    confidence: float = 0.99

    def __repr__(self) -> str:
        kinds = sorted(name for name, thing in vars(Plots).items() if name[0] != "_" and callable(thing))
        return f"Pictures of {len(self.rows)} quantities at {len(self.levels)} levels:\n{', '.join(kinds)}"

    def convergence(
        self,
        schemes: str | Sequence[str] = "",
        problem: str = "",
        measure: str = "strong",
        quantity: str = "",
        ax: Axes | None = None,
        style: str = SCREEN,
    ) -> Axes:
        """Draw errors against the step size, of one scheme with its fit or of several with claimed slopes.

        For one scheme, fitted levels are filled, and the fitted slope and that of the claim are drawn. Each of
        several schemes has a marker and a colour, with its order along paths in the legend, and a triangle below the
        data for each claimed order. Bars are intervals at the confidence of the run.

        Parameters
        ----------
        schemes : str or sequence of str, optional
            Labels or globs. By default the first scheme, or in the style of a paper all schemes.
        problem, measure, quantity : str, optional
            By default the first of the result.
        ax : Axes, optional
        style : str, optional
            ``screen``, or ``paper``: the width of a column, its font sizes, no title; `save` writes PDF and PGF.

        Raises
        ------
        UsageError
            If there is no data to draw, or matplotlib is not installed.
        """
        wanted = {"problem": problem, "measure": measure, "quantity": quantity}
        with in_style(style):
            if style == SCREEN and isinstance(schemes, str) and not _is_many(schemes):
                return self._draw_fit(self._one(scheme=schemes, **wanted), ax)
            rows = self._rows_of(schemes, wanted)
            curves = [curve for row in rows if (curve := self._curve(row)).h.size]
            if not curves:
                raise UsageError(f"nothing to draw: {rows[0].key} has no levels")
            label, title = axis_of(rows[0].measure).label, " ".join(rows[0].key[2:])
            return draw_curves(curves, (label, f"{title} on {rows[0].problem}"), ax, style)

    def save(self, ax: Axes, *files: str | Path) -> None:
        """Write the figure of some axes: PDF with embedded fonts, PGF for the fonts of a LaTeX document, SVG or PNG.

        Parameters
        ----------
        ax : Axes
            Axes returned by another method.
        *files : str or Path
            Files whose suffix determines the format. PGF needs ``pdflatex``.

        Raises
        ------
        UsageError
            If a suffix is unknown, or a file cannot be written.
        """
        save_figure(ax, files)

    def _draw_fit(self, row: VerdictRow, ax: Axes | None) -> Axes:
        ax, points = axes_of(ax), list(self._points(row))
        if not points:
            raise UsageError(f"nothing to draw: {row.key} has no levels")
        h, e, spread, fitted = (np.array(column) for column in zip(*points, strict=True))
        ax.errorbar(h, np.abs(e), reach(self.confidence) * spread, fmt="none", ecolor="0.6", capsize=2)
        for chosen, face, told in ((fitted, "C0", "fitted"), (~fitted, "none", "not fitted")):
            if chosen.any():
                ax.plot(h[chosen], np.abs(e)[chosen], "o", mfc=face, color="C0", label=told)
        own = [("slope", "line", row.path.value)] if row.path.known else []
        kept = fitted if fitted.any() else np.ones_like(fitted)
        middle = (fmean(np.log(h[kept])), fmean(np.log(np.abs(e)[kept])))
        for label, style, order in (*own, *claimed_slopes(row)):
            line = np.exp(middle[1] + order * (np.log(h) - middle[0]))
            ax.plot(h, line, STYLES[style], label=f"{label} {order:.2f}")
        _label(ax, str(row.key), "step size h", "error")
        label_steps(ax, h.tolist())
        label_decades(ax)
        return ax

    def _rows_of(self, schemes: str | Sequence[str], wanted: dict[str, str]) -> list[VerdictRow]:
        """Return the rows of the given schemes on the quantity of the first row, in the order of the schemes."""
        patterns = [
            each for text in ([schemes] if isinstance(schemes, str) else schemes) for each in split_list(text)
        ]
        every: dict[Key, VerdictRow] = {}
        for pattern in patterns or ["*"]:
            rows = [row for row in self._choose(**wanted) if is_named(row.scheme, pattern)]
            every |= {row.key: row for row in rows or [self._one(scheme=pattern, **wanted)]}
        first = next(iter(every))
        return [row for key, row in every.items() if key[1:] == first[1:]]

    def _curve(self, row: VerdictRow) -> ErrorCurve:
        points = [(h, abs(e), reach(self.confidence) * s) for h, e, s, _ in self._points(row) if e]
        h, error, half = np.array(points, dtype=float).reshape(-1, 3).T
        order = f" ({row.path.value:.2f})" if row.path.known else ""
        return ErrorCurve(f"{row.scheme}{order}", row.claimed_order, h, error, half)

    def matrix(self, measure: str = "", ax: Axes | None = None) -> Axes:
        """Draw schemes against problems: the worst verdict of each cell, with its symbol and count."""
        found = self._choose(measure=measure)
        if not found:
            what = f"measure {measure!r:.200}" if measure else "rows"
            raise UsageError(f"nothing to draw: the result has no {what}")
        schemes, problems = sorted({row.scheme for row in found}), sorted({row.problem for row in found})
        # Fields are at least as wide as the height of a text line, so that labels do not overlap.
        ax = axes_of(ax, (AROUND + 1.6 * LINE * len(problems), AROUND + LINE * len(schemes)))
        for y, scheme in enumerate(schemes):
            for x, problem in enumerate(problems):
                here = [row.verdict for row in found if (row.scheme, row.problem) == (scheme, problem)]
                worst = next((verdict for verdict in SYMBOLS if verdict in here), ABSENT)
                hatch = "///" if worst == "inconclusive" else ""
                ax.add_patch(_square(x, y, COLOURS[worst], hatch))
                told = f"{SYMBOLS[worst][0]}{here.count(worst)}" if here else "·"
                ax.text(x, y, told, ha="center", va="center", fontsize=7, color="w" if worst in FULL else "k")
        ax.set_xticks(range(len(problems)), problems, rotation=60, ha="right", fontsize=7)
        ax.set_yticks(range(len(schemes)), schemes, fontsize=7)
        ax.set_xlim(-0.5, len(problems) - 0.5)
        ax.set_ylim(len(schemes) - 0.5, -0.5)
        ax.set(xlabel="problem", ylabel="scheme")
        ax.set_title(measure or "all measures", fontsize=9)
        return ax

    def orders(self, measure: str = "strong", scheme: str = "", problem: str = "", ax: Axes | None = None) -> Axes:
        """Draw orders with intervals, one row each, and claims; hollow markers are without sampling.

        Parameters
        ----------
        measure : str
            Measure whose orders are drawn.
        scheme, problem : str
            Labels or globs; all if empty.
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; by default a new figure.
        """
        chosen = self._choose(measure=measure, scheme=scheme, problem=problem)
        found = [(row, *known_order(row)) for row in chosen if isfinite(known_order(row)[0].value)]
        if not found:
            raise UsageError(f"nothing to draw: no {measure} order is known")
        ax = axes_of(ax, (6.4, max(4.8, 0.8 + LINE * len(found))))
        for y, (row, known, sampled) in enumerate(found):
            if isfinite(known.low) and isfinite(known.high):
                ax.plot([known.low, known.high], [y, y], "-", color="C0")
            ax.plot([known.value], [y], "o", color="C0", mfc="C0" if sampled else "none")
            for label, style, order in claimed_slopes(row):
                # One legend entry for each kind of tick.
                new = label not in ax.get_legend_handles_labels()[1]
                ax.plot([order], [y], "|", color=STYLES[style][-2:], ms=12, label=label if new else None)
        if ax.get_legend_handles_labels()[1]:
            ax.legend(fontsize=7)
        ax.set_yticks(range(len(found)), [str(row.key) for row, *_ in found], fontsize=7)
        ax.set_ylim(len(found) - 0.5, -0.5)
        ax.set_xlabel("order")
        return ax

    def drift(self, problem: str = "", quantity: str = "", ax: Axes | None = None) -> Axes:
        """Draw residuals of a constraint against the step size, one line for each scheme.

        Parameters
        ----------
        problem : str
            Label or glob; may be empty if there is one problem.
        quantity : str
            Name of the constraint; may be empty if there is one.
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; by default a new figure.
        """
        return self._draw_errors("drift", problem, quantity, ax)

    def invariant(self, problem: str = "", quantity: str = "", ax: Axes | None = None) -> Axes:
        """Draw errors of a stationary mean against the step size, one line for each scheme.

        Parameters
        ----------
        problem : str
            Label or glob; may be empty if there is one problem.
        quantity : str
            Name of the observable; may be empty if there is one.
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; by default a new figure.
        """
        return self._draw_errors("invariant", problem, quantity, ax)

    def work(self, problem: str = "", measure: str = "strong", quantity: str = "", ax: Axes | None = None) -> Axes:
        """Draw errors against the measured time of the steps on a path, one line for each scheme.

        Parameters
        ----------
        problem, measure, quantity : str
            Label or glob of the problem, and names; an empty one is allowed if there is only one candidate.
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; by default a new figure.
        """
        times = {key_of(row): number(row, "step_seconds") for row in self.details}

        def time_and_error(row: VerdictRow, level: Row) -> tuple[float, float]:
            return times.get(row.key, nan) * number(level, "steps"), number(level, "estimate")

        ax, title = self._draw_lines(
            self._one(measure=measure, problem=problem, quantity=quantity), time_and_error, ax, _with_claim
        )
        _label(_require_lines(ax, title), title, "seconds a path", "error")
        label_decades(ax, "x")
        label_decades(ax)
        return ax

    def density(self, scheme: str = "", problem: str = "", coordinate: int = 1, ax: Axes | None = None) -> Axes:
        """Draw the stationary density of a chart coordinate under a scheme and under the equation.

        Parameters
        ----------
        scheme, problem : str
            Labels or globs; the first matching density is drawn.
        coordinate : int
            Number of the chart coordinate, counted from 1.
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; by default a new figure.
        """
        wanted = {"scheme": scheme, "problem": problem, "quantity": f"{DENSITY} {coordinate}"}
        found = [row for row in self.levels if text(row, "at") and _fits(row, wanted)]
        if not found:
            raise UsageError(f"nothing to draw: no {wanted['quantity']} is known")
        points = [row for row in found if key_of(row) == key_of(found[0])]
        at, own, exact = ([number(row, name) for row in points] for name in ("at", "estimate", "exact"))
        ax = axes_of(ax)
        ax.plot(at, own, "-", color="C0", label=f"scheme, h = {number(points[0], 'h'):.3g}")
        ax.plot(at, exact, "--", color="0.3", label="equation")
        title = f"{text(points[0], 'scheme')} on {text(points[0], 'problem')}"
        ax.set(xlabel=f"coordinate {coordinate}", ylabel="stationary density", title=title)
        ax.legend(fontsize=7)
        return ax

    def stability(self, problem: str = "", ax: Axes | None = None) -> Axes:
        """Draw spectral radii of second-moment maps against the step size; stable below 1."""
        return self._draw_errors("stability", problem, "", ax)

    def _draw_errors(self, measure: str, problem: str, quantity: str, ax: Axes | None) -> Axes:
        def size_and_error(_: VerdictRow, level: Row) -> tuple[float, float]:
            return number(level, "h"), number(level, "estimate")

        row, axis = self._one(measure=measure, problem=problem, quantity=quantity), axis_of(measure)
        ax, title = self._draw_lines(row, size_and_error, ax)
        _label(ax, title, "step size h", axis.label)
        label_steps(ax, [float(size) for line in ax.lines for size in np.asarray(line.get_xdata())])
        ax.set_yscale("log" if axis.log else "linear")
        label_decades(ax)
        if axis.rule is not None:
            ax.axhline(axis.rule, color="0.4", ls="--")
        return ax

    def _draw_lines(
        self, row: VerdictRow, point: PointOf, ax: Axes | None, label: LabelOf = attrgetter("scheme")
    ) -> tuple[Axes, str]:
        """Draw a line for each scheme on the quantity of a row; return the axes and their title."""
        ax, names = axes_of(ax), {"measure": row.measure, "problem": row.problem, "quantity": row.quantity}
        for place, one in enumerate(self._choose(**names)):
            found = [point(one, level) for level in self._levels(one)]
            points = sorted((x, abs(y)) for x, y in found if x > 0.0 and y)
            if points:
                ax.plot(*zip(*points, strict=True), **mark_of(place), mfc="none", lw=1, label=label(one))
        return ax, f"{row.measure} {row.quantity} on {row.problem}"

    def _choose(self, **wanted: str) -> list[VerdictRow]:
        return [row for row in self.rows if _fits(row.cells, wanted)]

    def _one(self, **wanted: str) -> VerdictRow:
        found = self._choose(**wanted)
        if not found:
            told = ", ".join(f"{key} {name!r:.200}" for key, name in wanted.items() if name)
            raise UsageError(f"nothing to draw: the result has no {told}")
        return found[0]

    def _points(self, row: VerdictRow) -> Iterator[tuple[float, float, float, bool]]:
        for level in self._levels(row):
            e, spread = number(level, "estimate"), number(level, "std_error")
            told = text(level, "fitted")
            yield number(level, "h"), e, spread, told == "True" if told else not spread or abs(e) > CLEAR * spread

    def _levels(self, row: VerdictRow) -> list[Row]:
        own = [level for level in self.levels if key_of(level) == row.key]
        return [level for level in own if not isnan(number(level, "estimate"))]


FULL = {"refuted", "diverged", "error", "verified"}


def _with_claim(row: VerdictRow) -> str:
    """Return the label of a scheme with its claim and the symbol of the verdict."""
    return f"{row.scheme}: {row.claim or 'no claim'} {SYMBOLS[row.verdict][0]}"


def _is_many(schemes: str) -> bool:
    return len(split_list(schemes)) > 1 or is_glob(schemes)


def _fits(row: Row, wanted: Mapping[str, str]) -> bool:
    return all(not name or text(row, key) == name for key, name in wanted.items())


def _require_lines(ax: Axes, what: str) -> Axes:
    if not ax.lines:
        raise UsageError(f"nothing to draw: {what} has no measured times")
    return ax


def _square(x: float, y: float, colour: str, hatch: str) -> Any:
    from matplotlib.patches import Rectangle  # noqa: PLC0415 - only pictures need it

    return Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=colour, hatch=hatch, edgecolor="0.7", lw=0.4)


def _label(ax: Axes, title: str, x: str, y: str) -> Axes:
    ax.set(xscale="log", yscale="log", xlabel=x, ylabel=y, title=title)
    ax.legend(fontsize=7)
    return ax
