"""QUICSORT and the damped oscillator that tells its order."""

import numpy as np
import pytest

from facade import QUICSORT, harmonic_langevin, weights, why_not_stability


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


def test_its_moments_are_left_to_paths():
    """Nodes have no K: neither moments nor stability are asked of a step that uses it."""
    assert (
        why_not_stability(QUICSORT(), QUICSORT().view_of(harmonic_langevin()))
        == "a step uses noise K; quadrature supports only dW and H"
    )
