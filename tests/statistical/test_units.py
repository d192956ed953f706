"""No claim is refuted because a problem is given in other units."""

from functools import wraps

import pytest

import sdaeverify
from facade import (
    delay_test,
    double_well,
    gbm,
    harmonic_langevin,
    load_registry,
    noncommuting,
    nonlinear_constraint,
    ou,
    pendulum,
    spiral,
)
from units import delay_in_units, in_units, langevin_in_units, mechanics_in_units

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


FORMS = {
    "mechanics": (mechanics_in_units, pendulum),
    "langevin": (langevin_in_units, harmonic_langevin),
    "delay": (delay_in_units, delay_test),
    "index-1": (delay_in_units, nonlinear_constraint),
}
FAR = {
    "large": {"scale": 1e6},
    "small": {"scale": 1e-6},
    "slow": {"time": 1e5},
    "fast": {"time": 1e-5},
    "molecules": {"scale": 1e-9, "time": 1e-12},
    "planets": {"scale": 1e8, "time": 1e7},
}
# Its line search compares lengths with constraints, and ends early where they are of other sizes.
MIXES_UNITS = "implicit-euler-ggl"


@pytest.mark.slow
@pytest.mark.parametrize("units", FAR)
@pytest.mark.parametrize("form", FORMS)
def test_other_forms_are_judged_alike_in_other_units(form, units):
    """All measures of all schemes refute nothing, on mechanics, Langevin dynamics and delays."""
    change, problem = FORMS[form]

    def changed():
        return change(problem(), **FAR[units])

    schemes = [name for name in load_registry(environ={}).schemes if name != MIXES_UNITS]
    rows = sdaeverify.verify(schemes, [changed], paths=256).verdicts

    assert (rows["verdict"] == "verified").sum() > 20
    assert not rows[rows["verdict"].isin(["refuted", "error"])]["reason"].tolist()
