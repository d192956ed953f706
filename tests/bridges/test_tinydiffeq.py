"""Solvers of tinydiffeq as schemes; skipped where it is not installed."""

import numpy as np
import pytest

from bridges.equations import PATHS, H, curved, drawn
from facade import (
    StochasticTheta,
    gbm,
    gbm_algebraic,
    noncommuting,
)
from sdaeverify_bridges.tinydiffeq import TinyDiffEq, TinyDiffEqSDAE
from sdaeverify_problems.nonlinear_constraint import nonlinear_constraint

pytest.importorskip("tinydiffeq", reason="needs the extra: pip install .[tinydiffeq]")
pytestmark = pytest.mark.filterwarnings("default:os.fork:RuntimeWarning")


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
