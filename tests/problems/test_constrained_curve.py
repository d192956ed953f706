"""Closed curves: printed means, and quadrature over the arc length with another inverse."""

import numpy as np
import pytest

from sdaeverify import ConstrainedLangevin, Moment
from sdaeverify_problems.curves.constrained_curve import constrained_curve

# sigma = 0.8, T = 1.
PRINTED = {
    ("ellipse", np.pi / 3): {"x_1": 0.93983231, "x_2": 0.75257412, "x_1^2": 1.36695308},
    ("space", 0.4): {"x_1": 0.70399762, "x_2": 0.31706535},
}


def moments(problem: ConstrainedLangevin, t: float) -> dict[str, float]:
    return {truth.observable: truth.value(t) for truth in problem.truths if isinstance(truth, Moment)}


@pytest.mark.parametrize(("shape", "theta"), PRINTED)
def test_means_are_those_printed(shape: str, theta: float) -> None:
    """Expectations at t = 1 agree with the formula sheet to its eight digits."""
    known = moments(constrained_curve(0.0, shape, 0.8, theta), 1.0)
    for name, value in PRINTED[shape, theta].items():
        assert known[name] == pytest.approx(value, abs=6e-9)
