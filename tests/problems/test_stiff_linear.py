"""Linear equations with one fast part, against dense exponentials, their limit and the joint law of their noise."""

import numpy as np
import pytest
from scipy.linalg import expm

from sdaeverify_problems.affine._stiff_linear import StiffLinear
from sdaeverify_problems.affine._stiff_modes import modes

EPS = np.finfo(float).eps
K = np.eye(4) + 0.4 * np.sin(1.0 + 2.0 * np.arange(4)[:, None] + 5.0 * np.arange(4))
N = np.linalg.qr(np.cos(np.arange(8.0) ** 2).reshape(4, 2))[0]
P = N @ N.T
SIGMA = 0.6


def law(eps: float) -> StiffLinear:
    return StiffLinear(modes(K, N, eps), np.zeros(4), SIGMA)


@pytest.mark.parametrize("eps", [0.005, 0.02, 0.1, 1.0])
def test_change_and_covariance_are_those_of_dense_exponentials(eps: float) -> None:
    """Where rounding times 1/eps is small, Van Loan's exponential of a block matrix says the same."""
    A, t = -(K + P / eps), 0.05
    block = np.block([[A, SIGMA**2 * np.eye(4)], [np.zeros((4, 4)), -A.T]])
    both = expm(t * block)
    propagator, covariance = both[:4, :4], both[:4, 4:] @ both[:4, :4].T

    # The norm of the block matrix times t is at most 13, and what cancels in it e^10.
    error = 1e5 * EPS
    assert np.abs(law(eps).change(t) + np.eye(4) - propagator).max() <= error
    assert np.abs(law(eps).covariance(t) - covariance).max() <= error


def test_the_limit_is_approached_at_first_order_without_rounding_times_one_over_eps() -> None:
    """Propagators minus their limit, divided by eps, are the same for eps = 1e-6 and 1e-10 where rounding is 1e-6."""
    (part,) = modes(K, N, 0.0)
    limit = part.E @ part.F - np.eye(4) + law(0.0).change(0.7), law(0.0).covariance(0.7)
    laws = {eps: (law(eps).change(0.7), law(eps).covariance(0.7)) for eps in (1e-6, 1e-10)}

    # 1e-6 is the next order, 1e-16/1e-10 what rounding leaves.
    for near, nearer, end in zip(*laws.values(), limit, strict=True):
        gap, same = (near - end) / 1e-6, (nearer - end) / 1e-10
        assert np.abs(gap - same).max() < 1e-4 < np.abs(gap).max()


@pytest.mark.sweep
@pytest.mark.parametrize("eps", [0.0, 1e-300, 1e-6, 0.01, 0.3, 1e300])
def test_a_step_has_the_covariance_of_the_equation(eps: float) -> None:
    """What dW, H and further normals make up is the covariance after a time h."""
    h = 0.1
    step = law(eps).step(h)
    made = h * step.of_dW @ step.of_dW.T + h / 12 * step.of_H @ step.of_H.T + step.of_xi @ step.of_xi.T

    assert np.abs(SIGMA**2 * made - law(eps).covariance(h)).max() <= 64 * EPS
    assert not law(eps).change(0.0).any()
