"""The equation whose constraint depends on time: its moments, and the bug that no other delay problem shows."""

import numpy as np
import pytest

from facade import delay_forced
from sdaeverify import DelaySDAE, Moment

OTHER = {"a": -0.3, "B": 0.4, "q": -0.7, "amplitude": 1.3, "omega": 1.7, "sigma": 0.4, "tau": 0.6}


def known(problem: DelaySDAE, name: str, t: float) -> float:
    """Return a moment at some time, that of the history where it is before 0."""
    if t <= 0.0:
        return float(problem.past(t)[0, 0])
    return next(m.value(t) for m in problem.truths if isinstance(m, Moment) and m.observable == name)


@pytest.mark.parametrize("parameters", [{}, OTHER], ids=["shipped", "other"])
@pytest.mark.parametrize("part", [0.13, 0.45, 0.8])
def test_means_solve_the_equation_and_its_constraint(parameters: dict[str, float], part: float) -> None:
    """By differences of the declared E x, and by the problem's own drift and constraint at it."""
    problem = delay_forced(**parameters)
    t, e = part * problem.horizon, 1e-3
    x, v, y = (np.array([[known(problem, name, s)]]) for name, s in (("x", t), ("x", t - problem.delay), ("y", t)))
    assert problem.constraint is not None

    rate = (known(problem, "x", t + e) - known(problem, "x", t - e)) / (2.0 * e)

    assert problem.drift(t, x, v, y)[0, 0] == pytest.approx(rate, abs=1e-5)
    assert problem.constraint(t, x, v, y)[0, 0] == pytest.approx(0.0, abs=1e-13)
