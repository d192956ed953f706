"""Matrices near x^T x = Id: closed forms against the dense ones, and what is known of their laws."""

import numpy as np
import pytest

from facade import orthogonal_group
from sdaeverify_problems.matrices import _lyapunov
from sdaeverify_problems.matrices._eigenangle_law import mean_trace
from sdaeverify_problems.matrices._lyapunov import Lyapunov, dense
from sdaeverify_problems.matrices._polar_law import PolarLaw

ROOT = 2.0**0.5
# E tr x under the invariant law, kappa = 100: printed values and half of a unit of their last digits, or as stated.
LIMIT = {2: 1.9949937185, 3: 2.9849811079, 4: 3.9699621198, 5: 4.9499367055}
FLAT = {2: 1.7270452220, 3: 2.1636105347, 4: 2.3074332356, 5: 2.2425482845}
PRINTED = [(1e-4, 2, 1.9954871718, 6e-11), (1e-3, 2, 1.9994092856, 6e-11), (5e-3, 2, 2.0099269859, 6e-11)]
PRINTED += [(5e-2, 2, 2.0259708609, 6e-11), (1e-4, 3, 2.9860173, 1e-7), (1e-3, 3, 2.994260, 1e-6)]
PRINTED += [(5e-3, 3, 3.0164269, 6e-8), (5e-2, 3, 3.050646, 3e-6)]


def test_the_equation_is_solved_where_its_series_does_not_converge():
    """Beside paths on which it does: eigenvalues with negative real parts, or far from 1, need the dense matrix."""
    M = np.stack([np.eye(3), np.diag([1.0, -0.5, 2.0]), np.diag([1e-6, 1.0, 1.0]), -np.eye(3) + 0.1], axis=-1)
    b = np.random.default_rng(0).standard_normal((6, 4))
    system = Lyapunov.of(M)

    assert system.poor.tolist() == [False, True, True, True]
    residual = np.einsum("ijp,jp->ip", dense(M), system.solve(b)) - b
    assert np.abs(residual).max() < 1e-9
    assert np.array_equal(system.positive(), np.linalg.det(np.moveaxis(dense(M), -1, 0)) > 0.0)
    assert len(system.powers) == _lyapunov.MOST


@pytest.mark.parametrize("m", [2, 3, 4, 5])
def test_means_on_the_group_are_the_printed_ones(m):
    """Weyl's integration formula, for a narrow and for a broad law."""
    assert mean_trace(m, 100.0) == pytest.approx(LIMIT[m], abs=6e-11)
    assert mean_trace(m, 2.0) == pytest.approx(FLAT[m], abs=6e-11)


@pytest.mark.parametrize(("eps", "m", "value", "accuracy"), PRINTED)
def test_means_around_the_group_are_the_printed_ones(eps, m, value, accuracy):
    """Quadrature over singular values and rotations."""
    assert PolarLaw(eps, 100.0, ROOT, m).trace() == pytest.approx(value, abs=accuracy)


def test_tabulated_means_are_known_for_their_parameters_only():
    """Sizes 4 and 5, stiffness 100, four values of eps."""
    (mean, square) = (truth.value for truth in orthogonal_group(5e-3, 4, 100.0).truths)
    assert mean == 4.023898
    assert 2.0 * square == pytest.approx(4.0 + 5e-3 * (200.0 * mean + 2.0 * 26.0), rel=1e-14)
    assert orthogonal_group(5e-3, 4).truths == ()
    assert orthogonal_group(6e-3, 4, 100.0).truths == ()
