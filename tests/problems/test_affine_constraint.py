"""The affine problem: its law against moment equations, and the schemes against their closed recursions."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sdaeverify import Moment, Scheme
from sdaeverify.arrays import Array
from sdaeverify.probe.linear.second_moments import smat, svec
from sdaeverify.probe.linear.step_moments import step_moments
from sdaeverify.probe.step.one_step import OneStep
from sdaeverify_problems._affine_langevin import AffineLangevin, Recursion
from sdaeverify_problems.affine_constraint import affine_constraint, affine_langevin
from sdaeverify_schemes.constrained_euler import ConstrainedEuler
from sdaeverify_schemes.penalised_euler import PenalisedEuler
from sdaeverify_schemes.uniform_expansion import UniformExpansion
from sdaeverify_schemes.uniformly_accurate import UniformlyAccurate

EPS = np.finfo(float).eps
SIZES = [(2, 1), (3, 1), (3, 2), (5, 3)]


def equation(eps: float, d: int, q: int) -> tuple[Array, Array, Array]:
    """Return A, a and B B^T of the problem's Ito equation dx = (A x + a) dt + B dW."""
    ito = affine_constraint(eps, d, q).ito()
    x = np.concatenate([np.zeros((d, 1)), np.eye(d)], axis=1)
    values, B = ito.drift(0.0, x), np.broadcast_to(ito.diffusion(0.0, x), (d, d, d + 1))[..., 0]
    return values[:, 1:] - values[:, :1], values[:, 0], B @ B.T


@pytest.mark.parametrize(("d", "q"), SIZES)
@pytest.mark.parametrize("eps", [0.0, 0.02, 0.25])
def test_moments_solve_their_equations(eps: float, d: int, q: int) -> None:
    """Expectations at time t follow from m' = A m + a, C' = A C + C A^T + B B^T, integrated numerically."""
    problem, t = affine_constraint(eps, d, q), 0.4
    A, a, noise = equation(eps, d, q)

    def rates(_: float, y: Array) -> Array:
        m, C = y[:d], y[d:].reshape(d, d)
        return np.concatenate([A @ m + a, (A @ C + C @ A.T + noise).ravel()])

    start = np.concatenate([problem.initial(1)[:, 0], np.zeros(d * d)])
    end = solve_ivp(rates, (0.0, t), start, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    m, second = end[:d], end[d:].reshape(d, d) + np.outer(end[:d], end[:d])
    known = {truth.observable: truth.value(t) for truth in problem.truths if isinstance(truth, Moment)}

    assert known["x_1"] == pytest.approx(m[0], rel=1e-9)
    assert known["x_2"] == pytest.approx(m[1], rel=1e-9)
    assert known["x_1^2"] == pytest.approx(second[0, 0], rel=1e-9)
    assert known["x_1 x_2"] == pytest.approx(second[0, 1], rel=1e-9)


SCHEMES: dict[str, tuple[Scheme, Callable[[AffineLangevin, float], Recursion]]] = {
    "explicit": (PenalisedEuler(), AffineLangevin.explicit_euler),
    "constrained": (ConstrainedEuler(), AffineLangevin.constrained_euler),
    "constrained, implicit direction": (ConstrainedEuler(direction="new"), AffineLangevin.constrained_euler),
    "theta = 0": (UniformlyAccurate(), AffineLangevin.uniformly_accurate),
    "theta = 1/2": (UniformlyAccurate(theta=0.5), AffineLangevin.uniformly_accurate),
    "theta = 1": (UniformlyAccurate(theta=1.0), AffineLangevin.uniformly_accurate),
    "three points": (UniformlyAccurate(xi="three-point"), AffineLangevin.uniformly_accurate),
    "expansion": (UniformExpansion(), AffineLangevin.uniformly_accurate),
}


def propagated(scheme: Scheme, eps: float, d: int, q: int) -> tuple[Array, Array]:
    """Return mean and covariance of a scheme after eight steps, by its operator on second moments."""
    problem = affine_constraint(eps, d, q)
    one_step = OneStep(scheme, problem.view(scheme.form))
    found = step_moments(one_step, problem.horizon / 8)
    z = np.append(problem.initial(1)[:, 0], 1.0)
    moments = smat(np.linalg.matrix_power(found.operator.dense(), 8) @ svec(np.outer(z, z)), d + 1)
    m = moments[:-1, -1]
    assert not found.failed
    return m, moments[:-1, :-1] - np.outer(m, m)


@pytest.mark.parametrize(("d", "q"), [(2, 1), (3, 2)])
@pytest.mark.parametrize("eps", [1e-6, 0.05, 0.25, 1e300])
@pytest.mark.parametrize("name", SCHEMES)
def test_schemes_have_the_moments_of_their_recursions(name: str, eps: float, d: int, q: int) -> None:
    """Mean and covariance after eight steps agree to rounding, found without sampling."""
    scheme, recursion = SCHEMES[name]
    given = affine_langevin(eps, d, q, 0.5, 0.7)
    m, C = propagated(scheme, eps, d, q)
    mean, covariance = recursion(given, 0.5 / 8).moments(affine_constraint(eps, d, q).initial(1)[:, 0], 8)

    # Rounding of the step, of the operator found from it and of eight powers, each relative to what is propagated.
    growth = max(1.0, np.linalg.norm(recursion(given, 0.5 / 8).M, 2) ** 16)
    assert np.abs(m - mean).max() <= 256 * EPS * growth
    assert np.abs(C - covariance).max() <= 256 * EPS * growth
