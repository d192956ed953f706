"""What the pictures of a run have in common: `result.plot` draws from it, and the page, to which it goes as JSON."""

from collections.abc import Iterator
from math import isfinite, isnan
from statistics import NormalDist
from typing import Any, NamedTuple

from .sentences import ATTENTION, SYMBOLS
from .verdict_row import Interval, VerdictRow

# Standard errors from which on an estimate differs from 0, where it is not recorded which levels are fitted.
CLEAR = 3.0
# The words of the page for verdicts, worst first, as the symbols.
WORDS = {
    "refuted": "refuted",
    "diverged": "failed",
    "error": "in error",
    "inconclusive": "inconclusive",
    "not_run": "not run",
    "verified": "verified",
    "out_of_scope": "no claim",
    "not_applicable": "does not apply",
}


class Axis(NamedTuple):
    """The axis of what a measure estimates at each step size.

    Attributes
    ----------
    label : str
    log : bool
        Whether it is logarithmic.
    rule : float or None
        Where a line crosses the picture.
    told : str
        The estimates in words.
    paid_by_steps : bool
        Whether they are errors along paths that more steps make smaller, so that work is compared with them.
    """

    label: str = "error"
    log: bool = True
    rule: float | None = None
    told: str = "Values"
    paid_by_steps: bool = False


AXES = {
    "": Axis(),
    "strong": Axis(told="Errors", paid_by_steps=True),
    "weak": Axis("|error of the mean|", told="Absolute errors of means", paid_by_steps=True),
    "invariant": Axis("|error of the mean|", told="Absolute errors of stationary means"),
    "drift": Axis("residual", told="Residuals"),
    "moments": Axis("moment"),
    "solvability": Axis("share of paths"),
    "stability": Axis("spectral radius", log=False, rule=1.0, told="Spectral radii"),
}


def axis_of(measure: str) -> Axis:
    """Return the axis of a measure."""
    return AXES.get(measure, AXES[""])


def reach(confidence: float) -> float:
    """Return by how many standard errors an interval reaches."""
    return NormalDist().inv_cdf(0.5 * (1.0 + confidence))


def claimed_slopes(row: VerdictRow) -> Iterator[tuple[str, str, float]]:
    """Yield the order that a claim names, and the least that it allows, each behind its label and its style."""
    if not isnan(claim := row.claimed_order):
        yield "claim", "claim", claim
        yield "claim - margin", "least", claim - row.margin


def known_order(row: VerdictRow) -> tuple[Interval, bool]:
    """Return the order that a picture of orders shows, and whether it is of paths."""
    if row.path.known:
        return row.path, True
    by_moments = "order" in row.value_of and isfinite(row.value)
    return (row.estimate if by_moments else Interval(row.local_order)), False


def description() -> dict[str, Any]:
    """Return the description for the page."""
    return {
        "verdicts": {verdict: [SYMBOLS[verdict][0], word] for verdict, word in WORDS.items()},
        "attention": ATTENTION,
        "axes": {measure: axis._asdict() for measure, axis in AXES.items()},
        "clear": CLEAR,
    }
