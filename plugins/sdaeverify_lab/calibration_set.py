"""The shipped calibration set: cells with known strong order and various kinds of errors."""

from sdaeverify import hookimpl
from sdaeverify_lab import CalibrationCase

CASES = [
    # Errors uncorrelated between steps, of mean size h^(1/2), and coherent errors of size h.
    CalibrationCase(scheme="euler-maruyama", problem="gbm", order=0.5, weak=("x", "x^2")),
    CalibrationCase(scheme="milstein", problem="gbm", order=1.0),
    CalibrationCase(scheme="euler-maruyama", problem="ou", order=1.0, weak=("x", "x^2"), stationary=("x", "x^2")),
    # Heavy tails, where few paths dominate the mean.
    CalibrationCase(scheme="euler-maruyama", problem="gbm-heavy", order=0.5, heavy=True),
    CalibrationCase(scheme="milstein", problem="gbm-heavy", order=1.0, heavy=True),
    # Constraints: a large preasymptotic range, and a truth that is not exact.
    CalibrationCase(scheme="projected-euler", problem="circle", order=1.0, share=0.5),
    CalibrationCase(scheme="half-explicit-euler[truncation=none]", problem="pendulum", order=1.0, share=0.5),
    # Two wells, between which chains seldom move.
    CalibrationCase(scheme="euler-maruyama", problem="double-well", order=1.0, strong=False, stationary=("x", "x^2")),
]


@hookimpl
def sdaeverify_calibration() -> list[CalibrationCase]:
    """Register the cases."""
    return CASES
