"""Solvers of tinydiffeq as schemes; skipped where it is not installed."""

import numpy as np
import pytest

from bridges.equations import curved, drawn
from facade import (
    SRA1,
    EulerMaruyama,
    Milstein,
    StochasticTheta,
    gbm,
    gbm_algebraic,
    hyperbolic_pair,
    noncommuting,
    ou,
)
from sdaeverify import ParameterError
from sdaeverify_bridges.tinydiffeq import TinyDiffEq, TinyDiffEqSDAE
from sdaeverify_problems.nonlinear_constraint import nonlinear_constraint

pytestmark = pytest.mark.filterwarnings("default:os.fork:RuntimeWarning")
H, PATHS, EPS = 0.125, 7, np.finfo(float).eps


@pytest.fixture(scope="module", autouse=True)
def library():
    """Skip where tinydiffeq is not installed."""
    return pytest.importorskip("tinydiffeq", reason="tinydiffeq is not installed; pip install '.[tinydiffeq]'")


@pytest.mark.parametrize(
    ("solver", "ours", "family"),
    [
        ("EulerMaruyama", EulerMaruyama(), gbm),
        ("EulerMaruyama", EulerMaruyama(), hyperbolic_pair),
        ("Milstein", Milstein(), gbm),
        ("SRA1", SRA1(), ou),
    ],
)
def test_our_schemes_agree_to_rounding(solver, ours, family):
    """On the same noise tinydiffeq makes the step that ours makes, whoever takes the derivatives."""
    problem = family()
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)

    found, expected = (scheme.step(problem, x, 0.5, H, noise).state for scheme in (TinyDiffEq(solver), ours))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=4.0 * EPS * np.abs(expected).max())


@pytest.mark.parametrize("family", [gbm_algebraic, nonlinear_constraint], ids=lambda family: family.__name__)
def test_algebraic_component_is_solved_for(family):
    """Euler's method for SDAEs is our explicit one, up to the tolerance to which its roots are found."""
    problem = family(tau=0.0)
    start, noise = problem.initial(PATHS), drawn(problem, H, PATHS)

    found, expected = (s.prepare(problem, H)(start, 0.5, noise) for s in (TinyDiffEqSDAE(), StochasticTheta(0.0)))
    assert not found.failed.any()
    for theirs, ours in zip(found.state, expected.state, strict=True):
        np.testing.assert_allclose(theirs, ours, rtol=1e-7)


def test_what_it_is_not_made_for_is_refused():
    """Noise that is not diagonal, multiplicative noise for SRA1, delays and equations without y."""
    assert TinyDiffEq().refuses(noncommuting()) == "the noise is not declared diagonal"
    assert TinyDiffEq("SRA1").refuses(gbm()) == "the noise is not declared additive"
    assert TinyDiffEqSDAE().refuses(gbm_algebraic(tau=0.5)) == "it has a delay"
    assert not TinyDiffEqSDAE().refuses(gbm_algebraic())
    assert TinyDiffEq().refuses(curved()) == "the noise is not declared diagonal"


def test_solver_is_checked():
    """Milstein's method is not among those for SDAEs."""
    with pytest.raises(ParameterError, match="solver must be one of EulerMaruyama, got 'Milstein'"):
        TinyDiffEqSDAE("Milstein")
