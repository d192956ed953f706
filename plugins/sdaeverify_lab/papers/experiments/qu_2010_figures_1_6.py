"""Figures 1 to 6 of Qu, Huang & Liu (2010): E x_n^2 in time for six sets of coefficients."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from sdaeverify import hookimpl
from sdaeverify_lab.papers import Curve, Exhibit, Experiment, ExperimentEvidence, MeanLine, MeanTable, Panel, Row

HORIZON, PER_TIME = 10, 32
# Times of the figures, every half unit, and fewer times of the table.
TIMES, SHOWN = tuple(0.5 * k for k in range(1, 21)), (1.0, 2.0, 4.0, 6.0, 8.0, 10.0)


class Figure(NamedTuple):
    """Coefficients of a figure as parameters of ``delay-test``, and its theta.

    Attributes
    ----------
    parameters, theta : str
    linear : tuple of str
        Parameters with l -> 0 and with sin v -> v; empty if l = 0.
    """

    parameters: str
    theta: str
    linear: tuple[str, ...] = ()


# With the brackets l -> 0, and b + l in place of b; the last entry is not in the paper.
FIGURES = (
    Figure("set=I", "0.2"),
    Figure("set=II", "0.2"),
    Figure("set=III", "0.2", ("set=III,l=0.0", "set=III,b=1.1,l=0.0")),
    Figure("set=IV", "0.0", ("set=IV,l=0.0", "set=IV,b=3.0,l=0.0")),
    Figure("set=V", "1.0", ("set=V,l=0.0", "set=V,b=2.0,l=0.0")),
    Figure("set=VI", "0.5", ("set=VI,l=0.0", "set=VI,b=1.2,l=0.0")),
    Figure("set=I,c=1.6", "0.2"),
)
NOTES = (
    "Dashed: the mean of the scheme, found without sampling; solid black: of the equation.",
    "With l = 0 the equation is linear, and exact means are known. Where l is not 0, rows with l -> 0, and with "
    "sin v -> v, that is b + l in the place of b, are beside it.",
    "Where our mean disagrees with that of the scheme, or few paths are effective, the average lies: the paths that "
    "carry E x^2 are too rare to be drawn. Its standard error, taken from the same paths, lies with it.",
    "Set I with c = 1.6 is no figure of the paper: it is not mean-square stable, and averages of 1000 paths decay.",
)


def problem(parameters: str) -> str:
    """Return the label of a set."""
    return f"delay-test[{parameters},horizon={HORIZON}.0]"


def rows(figure: Figure) -> Iterator[Row]:
    """Yield the means in time for a figure and for its linear brackets."""
    for parameters in (figure.parameters, *figure.linear):
        for t in TIMES:
            yield Row(
                problem=problem(parameters),
                scheme=f"stochastic-theta[theta={figure.theta}]",
                steps=HORIZON * PER_TIME,
                observable="x^2",
                at=round(t * PER_TIME),
            )


class MeanSquares(MeanTable):
    """E x^2 in time: exact, exact for the scheme, and by averages."""

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the table at some of the times."""
        whole = super().exhibit(evidence)
        shown = tuple(entry for entry in whole.entries if entry.more["time"] in SHOWN)
        return whole._replace(entries=shown)

    def panels(self, found: Sequence[MeanLine], evidence: ExperimentEvidence) -> tuple[Panel, ...]:
        """Return a panel for each set of coefficients."""
        return tuple(_panel(number, figure, found) for number, figure in enumerate(FIGURES, start=1))


def _panel(number: int, figure: Figure, found: Sequence[MeanLine]) -> Panel:
    curves = []
    for hue, parameters in enumerate((figure.parameters, *figure.linear)):
        lines = [line for line in found if line.row.problem == problem(parameters)]
        t = np.array([line.time for line in lines])
        curves += _curves(_name(parameters, figure), t, lines, hue)
    title = f"Figure {number}" if number <= 6 else "no figure of the paper"
    return Panel(f"{title}: {figure.parameters}, theta = {figure.theta}", "t", "E x^2", tuple(curves), "y")


def _name(parameters: str, figure: Figure) -> str:
    if parameters == figure.parameters:
        return "average"
    return "average, l = 0" if "b=" not in parameters else "average, sin v = v"


def _curves(name: str, t: np.ndarray, lines: Sequence[MeanLine], hue: int) -> list[Curve]:
    means, errors = (np.array([getattr(line.sample, part) for line in lines]) for part in ("value", "std_error"))
    scheme = np.array([line.scheme_mean.value for line in lines])
    exact = np.array([line.exact for line in lines])
    fewest = min(line.sample.effective for line in lines)
    label = f"{name} of {lines[0].sample.paths} paths, at least {fewest:.0f} effective"
    low = np.maximum(means - 2.0 * errors, 0.05 * means)
    curves = [Curve(label, t, means, low, means + 2.0 * errors, "marks", hue)]
    if np.isfinite(exact).any():
        curves.append(Curve("exact" if hue == 0 else "", t, exact, kind="line", hue=6))
    if np.isfinite(scheme).any():
        curves.append(Curve("", t, scheme, kind="guide", hue=hue))
    return curves


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the figures."""
    return [
        MeanSquares(
            name="qu-2010-figures-1-6",
            title="E x_n^2 in time, sets I to VI, h = 1/32, by averages of 1000 paths and exactly",
            source="Qu, Huang & Liu 2010, Figures 1 to 6",
            rows=tuple(row for figure in FIGURES for row in rows(figure)),
            notes=NOTES,
        )
    ]
