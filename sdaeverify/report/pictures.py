"""Common description of the pictures of a run, used by `result.plot` and, as JSON, by the page."""

from collections.abc import Iterator
from math import isfinite, isnan
from statistics import NormalDist
from typing import Any, NamedTuple

from .sentences import ATTENTION, SYMBOLS
from .verdict_row import Interval, VerdictRow

# Standard errors from which an estimate counts as nonzero, if fitted levels are not recorded.
CLEAR = 3.0
# Words for verdicts on the page, worst first, in the order of the symbols.
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
    """Axis for the estimates of a measure at each step size.

    Attributes
    ----------
    label : str
    log : bool
        Whether the axis is logarithmic.
    rule : float or None
        Value of a reference line; None without one.
    told : str
        Name of the estimates.
    paid_by_steps : bool
        Whether the estimates are errors along paths that decrease with more steps, so that work-precision plots
        apply.
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
    """Return the axis of a measure, or the default axis."""
    return AXES.get(measure, AXES[""])


def reach(confidence: float) -> float:
    """Return the half-width of an interval in standard errors of the normal law."""
    return NormalDist().inv_cdf(0.5 * (1.0 + confidence))


def claimed_slopes(row: VerdictRow) -> Iterator[tuple[str, str, float]]:
    """Yield the claimed and the least accepted order, each as label, style and order."""
    if not isnan(claim := row.claimed_order):
        yield "claim", "claim", claim
        yield "claim - margin", "least", claim - row.margin


def known_order(row: VerdictRow) -> tuple[Interval, bool]:
    """Return the order shown in a picture of orders, and whether it comes from paths."""
    if row.path.known:
        return row.path, True
    by_moments = "order" in row.value_of and isfinite(row.value)
    return (row.estimate if by_moments else Interval(row.local_order)), False


def description() -> dict[str, Any]:
    """Return the constants that the script of the page needs: symbols, axes, thresholds."""
    return {
        "verdicts": {verdict: [SYMBOLS[verdict][0], word] for verdict, word in WORDS.items()},
        "attention": ATTENTION,
        "axes": {measure: axis._asdict() for measure, axis in AXES.items()},
        "clear": CLEAR,
    }
