"""Sizes of errors as measures give them for a comparison, from one block of paths."""

from dataclasses import replace

import numpy as np
import pytest

from sdaeverify import Settings
from sdaeverify.contracts.matching import match
from sdaeverify.contracts.measure import Evidence, Measure
from sdaeverify.contracts.specs import problem_spec
from sdaeverify.contracts.tally import Tally
from sdaeverify.measures.drift import Drift
from sdaeverify.measures.invariant import Invariant
from sdaeverify.measures.strong import Strong
from sdaeverify.measures.uniform import Uniform
from sdaeverify.measures.weak import Weak
from sdaeverify.simulate.ensemble import Entry, Task, run_block
from sdaeverify_problems.double_well import double_well
from sdaeverify_problems.gbm import gbm
from sdaeverify_problems.ou import ou
from sdaeverify_problems.pendulum import pendulum
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.half_explicit_euler import HalfExplicitEuler
from sdaeverify_schemes.milstein import Milstein

SETTINGS = Settings(paths=120, coarsest=8, levels=4, looks=1)


def sizes(scheme, family, measure, **parameters):
    """Return the sizes of the errors of a cell, with its evidence."""
    spec = problem_spec(family, {name: str(value) for name, value in parameters.items()})
    (lane,) = run_block(Task(spec, (Entry(scheme, (measure,)),), SETTINGS), 0)
    assert not lane.errors[0]
    problem = spec.build()
    tally = lane.tallies[0].merge(lane.probes[0])
    evidence = Evidence(scheme, problem, match(scheme, problem).problem, SETTINGS, tally, lane.health)
    return measure.error_sizes(evidence), evidence


def test_errors_along_paths_are_their_means():
    """A size is log2 E e at each step size, with as many replicates as there are groups of paths."""
    found, evidence = sizes(EulerMaruyama(), gbm, Strong())
    means = evidence.tally.sums["error x@T"][..., 1].sum(axis=0) / 120

    assert list(found["x@T"].h) == evidence.step_sizes
    assert found["x@T"].log2 == pytest.approx(np.log2(means))
    assert found["x@T"].replicates.shape == (20, 4)
    assert found["x@T"].counts.sum() == 120


def test_levels_that_went_wrong_have_no_size():
    """Where paths failed or steps were truncated there is no error to be compared, and the remark says so."""
    _, evidence = sizes(EulerMaruyama(), gbm, Strong())
    wrong = {**evidence.health.sums, "failed": np.array([0.0, 1.0, 0.0, 0.0])}
    (again, *_) = Strong().error_sizes(replace(evidence, health=Tally(sums=wrong))).values()

    assert list(again.h) == evidence.step_sizes[2:]
    assert again.remark == "failed paths at 1 level"


def test_defects_of_one_step():
    """Of Euler-Maruyama for gbm without drift the defect against two half steps is b^2 x dW_1 dW_2: b^2 h/2."""
    found, _ = sizes(EulerMaruyama(), gbm, Strong(), a=0, b=0.5)
    step = found["one step: root mean square of x"]

    assert step.replicates is None
    assert np.diff(step.log2) / np.diff(np.log2(step.h)) == pytest.approx(1.0, abs=1e-6)
    assert found["one step: mean of x"].exact


def test_an_exact_scheme_has_no_error():
    """Where errors are rounding there is none to be compared, and that is said."""
    found, _ = sizes(Milstein(), ou, Strong(), a=1e-30, sigma=0.5)

    assert found["x"].exact
    assert not len(found["x"].h)


def test_errors_of_moments_are_exact():
    """For gbm, E x after n steps of Euler-Maruyama is (1 + a/n)^n, that of the solution e^a."""
    found, evidence = sizes(EulerMaruyama(), gbm, Weak(), a=0.5)
    first = found["first moments at T"]
    n = np.round(evidence.problem.horizon / first.h)
    start = evidence.problem.initial(1)[0, 0]

    T = evidence.problem.horizon
    error = start * np.abs((1 + 0.5 * T / n) ** n - np.exp(0.5 * T))
    assert 2.0 ** first.log2[:6] == pytest.approx(error[:6], rel=1e-6)
    assert len(found["one step"].h) > 3


def test_mean_differences_need_to_be_resolved():
    """A mean difference within three standard errors of 0 has no size, one beyond has that of its estimate."""
    found, evidence = sizes(EulerMaruyama(), gbm, Weak(), a=0)
    for name in evidence.problem.observables:
        sums = evidence.tally.sums
        differences = np.abs((sums[f"values {name}"].sum(axis=0) - sums[f"truth {name}"].sum()) / 120)
        places = [evidence.step_sizes.index(h) for h in found[name].h]
        assert 2.0 ** found[name].log2 == pytest.approx(differences[places])
    # Without drift the scheme is a martingale as the solution is: its first moment has no error.
    assert found["x"].remark == "mean differences of less than 3 standard errors"


def test_biases_of_the_invariant_law():
    """They are those of the transition operator, of the observables that tell an order."""
    found, _ = sizes(EulerMaruyama(), double_well, Invariant())

    assert found
    assert all(name.startswith("by the operator: ") for name in found)
    for each in found.values():
        assert np.diff(each.log2) / np.diff(np.log2(each.h)) == pytest.approx(1.0, abs=0.5)
        assert each.replicates is None


def test_residuals_of_constraints():
    """They are the suprema of root mean squares at each level; a projection leaves rounding, which is no error."""
    drifting, evidence = sizes(EulerMaruyama(), pendulum, Drift())
    squares = evidence.tally.sums["squares g 3"].sum(axis=0) / 120

    assert 2.0 ** drifting["g"].log2[-1] == pytest.approx(np.sqrt(squares.max()))
    assert drifting["g"].replicates.shape == (20, len(drifting["g"].h))
    projected, _ = sizes(HalfExplicitEuler(), pendulum, Drift())
    assert projected["g"].exact


def test_largest_errors_in_time():
    """On the grid they are those of the strong order."""
    uniform, _ = sizes(EulerMaruyama(), gbm, Uniform())
    strong, _ = sizes(EulerMaruyama(), gbm, Strong())

    ((name, found),) = uniform.items()
    assert name.startswith("x")
    assert list(found.log2) == list(strong["x"].log2)


def test_a_measure_without_sizes():
    """Most measures size nothing, and are not compared."""
    assert Measure().error_sizes(None) == {}
