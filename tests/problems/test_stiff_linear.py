"""Linear equations with one fast part, against dense exponentials, their limit and the joint law of their noise."""

import numpy as np
import pytest
from scipy.linalg import expm

from sdaeverify.arrays import Array
from sdaeverify_problems import _stiff_linear
from sdaeverify_problems._stiff_linear import StiffLinear
from sdaeverify_problems._stiff_modes import modes

EPS = np.finfo(float).eps
K = np.eye(4) + 0.4 * np.sin(1.0 + 2.0 * np.arange(4)[:, None] + 5.0 * np.arange(4))
N = np.linalg.qr(np.cos(np.arange(8.0) ** 2).reshape(4, 2))[0]
P = N @ N.T
SIGMA = 0.6


def law(eps: float) -> StiffLinear:
    return StiffLinear(modes(K, N, eps), np.zeros(4), SIGMA)


@pytest.mark.parametrize("eps", [1e-8, 1e-3, 0.02, 0.1, 1.0, 1e6])
def test_the_parts_make_up_the_matrix(eps: float) -> None:
    """E_i A_i F_i add up to K + P/eps, with F_i E_j = delta_ij Id, to rounding of the matrix."""
    parts = modes(K, N, eps)
    E, F = np.concatenate([part.E for part in parts], axis=1), np.concatenate([part.F for part in parts])
    total = sum(part.E @ part.matrix @ part.F for part in parts)

    assert len(parts) == (2 if eps < 0.05 else 1)
    assert np.abs(F @ E - np.eye(4)).max() <= 16 * EPS
    assert np.abs(total - K - P / eps).max() <= 32 * EPS * np.abs(K + P / eps).max()


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
    limit, (part,) = law(0.0), modes(K, N, 0.0)
    propagator = part.E @ part.F + limit.change(0.7)
    gaps = [(law(eps).change(0.7) + np.eye(4) - propagator) / eps for eps in (1e-6, 1e-10)]
    covariances = [(law(eps).covariance(0.7) - limit.covariance(0.7)) / eps for eps in (1e-6, 1e-10)]

    # 1e-6 is the next order, 1e-16/1e-10 what rounding leaves.
    assert np.abs(gaps[0] - gaps[1]).max() < 1e-4 < np.abs(gaps[0]).max()
    assert np.abs(covariances[0] - covariances[1]).max() < 1e-4 < np.abs(covariances[0]).max()


@pytest.mark.parametrize("eps", [0.0, 1e-300, 1e-6, 0.01, 0.3, 1e300])
def test_a_step_has_the_covariance_of_the_equation(eps: float) -> None:
    """What dW, H and further normals make up is the covariance after a time h."""
    h = 0.1
    step = law(eps).step(h)
    made = h * step.of_dW @ step.of_dW.T + h / 12 * step.of_H @ step.of_H.T + step.of_xi @ step.of_xi.T

    assert np.abs(SIGMA**2 * made - law(eps).covariance(h)).max() <= 64 * EPS
    assert not law(eps).change(0.0).any()


def test_a_quadrature_that_does_not_shrink_misses_the_covariance(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sixteen nodes on the whole step do not see a kernel e^{-q h/eps} with h/eps = 1000."""
    graded = _stiff_linear._graded_rule
    monkeypatch.setattr(_stiff_linear, "_graded_rule", lambda z: graded(1.0))
    with pytest.raises(AssertionError):
        test_a_step_has_the_covariance_of_the_equation(1e-4)


def joint_covariance(eps: float, h: float) -> Array:
    """Return the covariance of (dW, H, Y), Y being the step's integral."""
    step, zero, one = law(eps).step(h), np.zeros((4, 4)), np.eye(4)
    root = np.block([[one, zero, zero], [zero, one, zero], [step.of_dW, step.of_H, step.of_xi]])
    return root @ np.diag(np.repeat([h, h / 12, 1.0], 4)) @ root.T


@pytest.mark.parametrize("eps", [0.0, 1e-4, 0.01, 0.3])
def test_steps_compose(eps: float) -> None:
    """The law of (dW, H, Y) over a step is that of two halves joined, Y = e^{-Ah/2} Y_1 + Y_2."""
    h, one, zero = 0.4, np.eye(4), np.zeros((4, 4))
    (part, *_) = modes(K, N, eps)
    idle = np.eye(4) - part.E @ part.F if eps == 0.0 else zero
    half = np.eye(4) - idle + law(eps).change(h / 2)
    halves = np.kron(np.eye(2), joint_covariance(eps, h / 2))
    join = np.block(
        [
            [one, zero, zero, one, zero, zero],
            [0.25 * one, 0.5 * one, zero, -0.25 * one, 0.5 * one, zero],
            [zero, zero, half, zero, zero, one],
        ]
    )

    assert np.abs(join @ halves @ join.T - joint_covariance(eps, h)).max() <= 64 * EPS
