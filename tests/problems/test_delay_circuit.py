"""The noisy ladder against its own functions, and the cubic constraint."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_lyapunov

from sdaeverify import SDE, InvariantMean, Moment
from sdaeverify.arrays import Array
from sdaeverify.numerics import jacobian
from sdaeverify_problems.noisy_circuit import BOLTZMANN, noisy_circuit
from sdaeverify_problems.nonlinear_constraint import cubic_root, nonlinear_constraint

UNEQUAL = {"R_1": 2.0, "R_a": 0.3, "R_b": 0.9, "C_1": 0.5, "C_2": 3.0, "U": 0.2, "temperature": 400.0}


def equation(**parameters: float) -> tuple[Array, Array, Array]:
    """Return A, a and N of dx = (A x + a) dt + N dW, read from the problem with y eliminated."""
    view = noisy_circuit(**parameters).view(SDE)
    assert isinstance(view, SDE)
    x = np.zeros((2, 1))
    return jacobian(lambda z: view.drift(0.0, z), x)[..., 0], view.drift(0.0, x)[:, 0], view.diffusion(0.0, x)[..., 0]


@pytest.mark.parametrize("parameters", [{}, UNEQUAL], ids=["equal", "unequal"])
def test_the_invariant_law_is_the_one_of_statistical_mechanics(parameters: dict[str, float]) -> None:
    """The stationary covariance is kT/C on each node and none between them, the mean the source's voltage."""
    problem, (A, a, N) = noisy_circuit(**parameters), equation(**parameters)
    covariance, mean = solve_continuous_lyapunov(A, -N @ N.T), -np.linalg.solve(A, a)
    known = {t.observable: t.value for t in problem.truths if isinstance(t, InvariantMean)}
    kT = BOLTZMANN * parameters.get("temperature", 300.0)
    C = [parameters.get("C_1", 1.0), parameters.get("C_2", 1.0)]

    np.testing.assert_allclose(covariance, np.diag(kT / np.array(C)), rtol=1e-12, atol=1e-16)
    np.testing.assert_allclose(mean, [known["e_1"], known["e_2"]], rtol=1e-12)
    second = covariance + np.outer(mean, mean)
    found = [second[0, 0], second[0, 1], second[1, 1]]
    assert found == pytest.approx([known[name] for name in ("e_1^2", "e_1 e_2", "e_2^2")], rel=1e-12)


def test_the_fluctuations_have_their_size_in_volts() -> None:
    """At 300 K a capacitor of 1 pF fluctuates by 64 microvolts."""
    kT_in_joule = 1.380649e-23 * 300.0

    assert np.sqrt(BOLTZMANN * 300.0) * 1e-3 == pytest.approx(np.sqrt(kT_in_joule / 1e-12), rel=1e-12)
    assert np.sqrt(BOLTZMANN * 300.0) == pytest.approx(0.064, abs=0.001)


@pytest.mark.parametrize("t", [0.3, 1.0, 4.0])
def test_moments_solve_their_equations(t: float) -> None:
    """Mean and second moments agree with m' = A m + a, S' = A S + S A^T + a m^T + m a^T + N N^T, solved otherwise."""
    A, a, N = equation(**UNEQUAL)

    def rates(_: float, z: Array) -> Array:
        m, S = z[:2], z[2:].reshape(2, 2)
        change = A @ S + np.outer(a, m)
        return np.concatenate([A @ m + a, (change + change.T + N @ N.T).ravel()])

    expected = solve_ivp(rates, (0.0, t), np.zeros(6), rtol=1e-11, atol=1e-14).y[:, -1]
    known = {m.observable: m.value(t) for m in noisy_circuit(**UNEQUAL).truths if isinstance(m, Moment)}
    names = ("e_1", "e_2", "e_1^2", "e_1 e_2", "e_2^2")
    assert [known[name] for name in names] == pytest.approx(expected[[0, 1, 2, 3, 5]], rel=1e-8)


def test_the_relaxation_time_is_that_of_the_slowest_mode() -> None:
    """It is the inverse of the least rate, which a quarter of it or four times it is not."""
    problem = noisy_circuit(**UNEQUAL)

    rates = -np.linalg.eigvals(equation(**UNEQUAL)[0]).real
    assert problem.relaxation == pytest.approx(1.0 / rates.min(), rel=1e-12)


def test_the_cubic_constraint_is_solved_by_its_closed_form() -> None:
    """Y + y^3 = p for p of any size and sign, and it is the y that Newton's method finds."""
    p = np.array([[-40.0, -1.0, 0.0, 1e-8, 0.3, 5.0]])
    y = cubic_root(p)
    problem = nonlinear_constraint(tau=0.0)

    np.testing.assert_allclose(y + y**3, p, rtol=1e-14, atol=1e-22)
    np.testing.assert_allclose(problem.eliminated(0.0, 2.0 * p, 2.0 * p), y, rtol=1e-13, atol=1e-22)


def test_on_the_constraint_it_is_geometric_brownian_motion() -> None:
    """At a y that solves the constraint, drift and noise are a x and b x; beside it they are not."""
    problem, rng = nonlinear_constraint(a=-0.7, b=0.4), np.random.default_rng(3)
    x, v = rng.uniform(0.5, 2.0, (2, 1, 5))
    y = problem.eliminated(0.0, x, v)

    np.testing.assert_allclose(problem.drift(0.0, x, v, y), -0.7 * x, rtol=1e-13)
    np.testing.assert_allclose(problem.diffusion(0.0, x, v, y), 0.4 * x[:, None], rtol=1e-13)
    assert np.abs(problem.drift(0.0, x, v, y + 0.1) + 0.7 * x).min() > 0.05
