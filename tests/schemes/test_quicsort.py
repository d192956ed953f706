"""QUICSORT and the damped oscillator that tells its order."""

import numpy as np
import pytest

from sdaeverify import SDE
from sdaeverify.noise.brownian import Source, brownian_steps
from sdaeverify.probe.stability.stability import why_not_stability
from sdaeverify_problems.harmonic_langevin import harmonic_langevin, weights
from sdaeverify_schemes.quicsort import QUICSORT
from sdaeverify_schemes.sra1 import SRA1

PATHS, LEVELS = 200, 6
FIELDS = frozenset({"dW", "H", "K"})


@pytest.fixture(scope="module")
def noise():
    """Return the noise of a unit of time at seven levels."""
    return next(brownian_steps(Source(2, "oscillator", 0, PATHS), 1, 1.0, LEVELS, FIELDS))


def errors(scheme, noise):
    """Return the root mean square distance from the exact solution at each level, without what no step knows."""
    problem = harmonic_langevin()
    view, ends, truths = scheme.view_of(problem), [], []
    for level, steps in enumerate(noise):
        h, x, z = 0.5**level, view.initial(PATHS), problem.pathwise.start(PATHS)
        for n in range(2**level):
            increment = steps.increment(n)
            x = scheme.step(view, x, n * h, h, increment).state
            z = problem.pathwise.advance(z, n * h, h, increment._replace(xi=np.zeros((2, PATHS))))
        ends.append(x)
        truths.append(z)
    return np.sqrt(((np.array(ends) - truths[-1]) ** 2).mean(axis=(1, 2)))


@pytest.mark.parametrize(("scheme", "order"), [(QUICSORT(), 3.0), (SRA1(), 2.0)], ids=["quicsort", "sra1"])
def test_order_on_the_oscillator(scheme, order, noise):
    """QUICSORT has strong order 3 on the same noise on which SRA1 has order 2."""
    found = np.diff(np.log2(errors(scheme, noise)))[1:-1]

    np.testing.assert_allclose(found, -order, atol=0.3)


@pytest.mark.parametrize("h", [1.0, 0.125])
def test_weights_have_the_variance_of_the_integral(h):
    """The weights of the first five polynomials leave less than a millionth of the variance."""
    M = np.array([[0.0, 1.0], [-2.25, -1.0]])
    found = weights(M, h)
    variances = found**2 @ np.array([h, h / 12.0, h / 720.0, 1.0, 1.0])
    s = np.linspace(0.0, h, 2001)
    values, vectors = np.linalg.eig(M)
    kernel = np.einsum("ij,jn,j->in", vectors, np.exp(np.outer(values, s)), np.linalg.inv(vectors)[:, 1]).real

    np.testing.assert_allclose(variances, np.trapezoid(kernel**2, s), rtol=1e-5)


def test_problem_is_an_sde_too():
    """Schemes for SDEs see its first-order system, with K among what is drawn."""
    assert harmonic_langevin().view(SDE).noise == FIELDS


def test_its_moments_are_left_to_paths():
    """Nodes have no K: neither moments nor stability are asked of a step that uses it."""
    assert (
        why_not_stability(QUICSORT(), QUICSORT().view_of(harmonic_langevin()))
        == "a step uses K: nodes are of dW and H alone"
    )
