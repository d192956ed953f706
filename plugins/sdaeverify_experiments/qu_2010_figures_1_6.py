"""Figures 1 to 6 of Qu, Huang & Liu (2010): E x_n^2 in time for six sets of coefficients."""

from collections.abc import Iterator
from typing import NamedTuple

from sdaeverify import Experiment, MeanTable, Row, hookimpl

HORIZON, PER_TIME = 10, 32
TIMES = (1, 2, 4, 6, 8, 10)


class Figure(NamedTuple):
    """The coefficients of a figure, as parameters of ``delay-test``, and its theta.

    Attributes
    ----------
    parameters, theta : str
    linear : tuple of str
        The parameters with l -> 0 and with sin v -> v; empty where l = 0.
    """

    parameters: str
    theta: str
    linear: tuple[str, ...] = ()


# With l -> 0, and with b + l in the place of b; the last is no figure of the paper.
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
    "With l = 0 the equation is linear, and exact means are known. Where l is not 0, rows with l -> 0, and with "
    "sin v -> v, that is b + l in the place of b, are beside it.",
    "Where our mean disagrees with that of the scheme, or few paths are effective, the average lies: the paths that "
    "carry E x^2 are too rare to be drawn. Its standard error, taken from the same paths, lies with it.",
    "Set I with c = 1.6 is no figure of the paper: it is not mean-square stable, and averages of 1000 paths decay.",
)


def rows(figure: Figure) -> Iterator[Row]:
    """Yield the means in time of a figure and of its linear brackets."""
    for parameters in (figure.parameters, *figure.linear):
        for t in TIMES:
            yield Row(
                problem=f"delay-test[{parameters},horizon={HORIZON}.0]",
                scheme=f"stochastic-theta[theta={figure.theta}]",
                steps=HORIZON * PER_TIME,
                observable="x^2",
                at=t * PER_TIME,
            )


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the figures."""
    return [
        MeanTable(
            name="qu-2010-figures-1-6",
            title="E x_n^2 in time, sets I to VI, h = 1/32, by averages of 1000 paths and exactly",
            source="Qu, Huang & Liu 2010, Figures 1 to 6",
            rows=tuple(row for figure in FIGURES for row in rows(figure)),
            notes=NOTES,
        )
    ]
