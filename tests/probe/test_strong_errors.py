"""Mean-square errors along paths of linear equations are exact, at each step size."""

import numpy as np
import pytest

from facade import (
    LinearEquation,
    gbm,
    strong_errors,
    weighted_flow,
    why_not_strong_errors,
)
from sdaeverify import SDE
from sdaeverify.probe.linear.pair import mean_square_distance
from sdaeverify.probing import OneStep
from sdaeverify_schemes.balanced_euler import BalancedEuler
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama, TamedEuler
from sdaeverify_schemes.heun import HeunAdditive
from sdaeverify_schemes.sra1 import SRA1

A, B, T = 0.5, 0.6, 1.0
STEPS = (4, 8)


def ou(rate: float = -0.8, strength: float = 0.7) -> SDE:
    """Return dx = rate x dt + strength dW, x_0 = 1.5."""
    return SDE(
        drift=lambda t, x: rate * x,
        diffusion=lambda t, x: np.full((1, 1, 1), strength),
        start=[1.5],
        noise_dim=1,
        horizon=1.0,
        traits=frozenset({"additive-noise"}),
        source="test",
    )


def rotating() -> SDE:
    """Return a linear equation with two components, two motions and additive noise."""
    drift, noise = np.array([[-0.5, 1.3], [-0.9, -0.2]]), np.array([[0.6, 0.1], [-0.3, 0.8]])
    return SDE(
        drift=lambda t, x: drift @ x,
        diffusion=lambda t, x: noise[..., None],
        start=[1.0, -0.5],
        noise_dim=2,
        horizon=1.0,
        traits=frozenset({"additive-noise"}),
        source="test",
    )


def test_euler_maruyama_on_geometric_brownian_motion():
    """E Y^2, E X Y and E X^2 after n steps are n-th powers of those after one."""
    found = strong_errors(EulerMaruyama(), gbm(), STEPS)
    n = np.round(T / found.h)
    one = 1.0 + A * found.h
    own, cross, exact = one**2 + B**2 * found.h, (one + B**2 * found.h) * np.exp(A * found.h), np.exp(2.0 * A + B**2)

    assert found.squares[:, 0] == pytest.approx(own**n - 2.0 * cross**n + exact, rel=1e-9)
    assert found.size == pytest.approx([exact], rel=1e-12)


@pytest.mark.parametrize("scheme", [EulerMaruyama(), HeunAdditive(), StochasticTheta()], ids=str)
@pytest.mark.parametrize("problem", [ou(), rotating()], ids=["ou", "rotating"])
def test_additive_noise(scheme, problem):
    """The pair of linear recursions with Gaussian noise gives the same distance."""
    found = strong_errors(scheme, problem, STEPS)
    wanted = [mean_square_distance(OneStep(scheme, problem), 1.0 / n, n)[0] for n in STEPS]

    assert found.squares[:2].sum(axis=1) == pytest.approx(wanted, rel=1e-9)


def test_a_step_with_a_time_integral():
    """One step of SRA1 is a x + b W + c J; the covariances of int e^(r (1 - s)) dW with W and J are known."""
    r, s = -0.8, 0.7
    found = strong_errors(SRA1(), ou(r, s), [1])
    # y = x + 3/4 r x + 3/2 s J; x+ = x + r (x + 2 y)/3 + s W.
    kept, by_W, by_J = 1.0 + r + 0.5 * r**2, s, r * s
    decay, own = np.exp(r), s**2 * np.expm1(2.0 * r) / (2.0 * r)
    with_W = s * np.expm1(r) / r
    with_J = s * (np.exp(r) * (r - 1.0) + 1.0) / r**2
    noise = by_W**2 + by_W * by_J + by_J**2 / 3.0 - 2.0 * (by_W * with_W + by_J * with_J) + own

    assert found.squares[0] == pytest.approx([(kept - decay) ** 2 * 1.5**2 + noise], rel=1e-10)


def test_means_of_polynomials_times_the_flow():
    """By Girsanov's theorem E[m(W, J) e^(bW - b^2/2)] = E m(W + b, J + b/2), for W and J = int W ds."""
    a, b = 0.3, 0.9
    powers = [(i, j) for i in range(5) for j in range(5 - i)]
    flow = weighted_flow(LinearEquation(np.array([[a]]), np.array([[[b]]])), powers)
    # E (W + b)^2 = 1 + b^2, Cov(W, J) = 1/2, E (J + b/2)^2 = 1/3 + b^2/4; odd central moments vanish.
    u, v = b, b / 2.0
    wanted = {
        (0, 0): 1.0,
        (1, 0): u,
        (0, 1): v,
        (1, 1): 0.5 + u * v,
        (2, 1): (1.0 + u**2) * v + u,
        (0, 4): 3.0 / 9.0 + 6.0 * v**2 / 3.0 + v**4,
        (2, 2): 1.0 / 3.0 + 0.5 + u**2 / 3.0 + v**2 + 2.0 * u * v + u**2 * v**2,
    }

    for each, value in wanted.items():
        assert flow[each] == pytest.approx(np.exp(a) * np.array([[value]]), rel=1e-12)


@pytest.mark.parametrize("scheme", [BalancedEuler(), TamedEuler()], ids=str)
def test_other_steps_have_no_known_error(scheme):
    """A step with |dW| is no polynomial, although one agrees with it at all nodes; a tamed one is not linear."""
    assert why_not_strong_errors(scheme, gbm()) == ""
    assert np.isnan(strong_errors(scheme, gbm(), STEPS).squares).all()
