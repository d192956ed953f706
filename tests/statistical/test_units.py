"""No claim is refuted because a problem is given in other units."""

from functools import wraps

import pytest

import sdaeverify
from facade import double_well, gbm, noncommuting, ou, spiral
from units import in_units

PROBLEMS = (double_well, gbm, noncommuting, ou, spiral)
UNITS = {
    "large": {"scale": 1e8},
    "small": {"scale": 1e-8},
    "slow": {"time": 1e6},
    "days": {"time": 250.0},
    "fast": {"time": 1e-6},
    "shifted": {"shift": 1e4},
    "warm": {"shift": 300.0},
    "all": {"scale": -7.0, "shift": -40.0, "time": 30.0},
}


def recipe(problem, units):
    """Return a function that returns a problem in other units, under its name."""

    @wraps(problem)
    def changed():
        return in_units(problem(), **units)

    del changed.__wrapped__
    return changed


@pytest.mark.slow
@pytest.mark.parametrize("name", UNITS)
def test_no_claim_is_refuted_in_other_units(name):
    """Strong and weak orders of all schemes on five equations, which are right in the units of their authors."""
    problems = [recipe(problem, UNITS[name]) for problem in PROBLEMS]
    rows = sdaeverify.verify(problems=problems, measures=["strong", "weak"], paths=256).verdicts

    assert (rows["verdict"] == "verified").sum() > 50
    assert not rows[rows["verdict"] == "refuted"]["reason"].tolist()
