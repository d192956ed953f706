"""The noisy ladder against its own functions, and the cubic constraint."""

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from facade import BOLTZMANN, noisy_circuit
from sdaeverify import SDE, Array, InvariantMean
from sdaeverify.numerics import jacobian

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
