"""The linearised fibre as an equation with an exact solution on each path."""

import numpy as np
import pytest

from facade import Fibre, clamped_chain, gaussian_step, hanging_fibre

N = 3


def fibre(alpha=4.0, **others):
    return hanging_fibre(Fibre(chain=clamped_chain(N, 2), alpha=alpha, **others), 1.0)


@pytest.mark.parametrize("h", [1e-7, 1e-4, 1e-2])
def test_exact_steps_have_the_covariance_of_the_solution(h):
    """The parts made of dW, H and further normals add up to C(h), in every component."""
    linear = fibre(alpha=0.5)
    step = gaussian_step(linear.generator, linear.noise, h)
    parts = h * step.of_dW @ step.of_dW.T + h / 12 * step.of_H @ step.of_H.T + step.of_xi @ step.of_xi.T
    expected = linear.covariance(h)
    scale = np.sqrt(np.diag(expected))

    assert np.abs((parts - expected) / np.outer(scale, scale)).max() < 1e-11
