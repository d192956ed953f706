"""The linearised hanging fibre against the fibre itself, and the stability of schemes on it."""

import numpy as np
import pytest

from facade import (
    ExplicitProjectionEuler,
    Fibre,
    HalfExplicitEuler,
    SemiImplicitProjectionEuler,
    clamped_chain,
    fibre_problem,
    gaussian_step,
    hanging_fibre,
    rotation,
)
from problems.fibre_chains import derivative
from problems.linear_moments import moments_at
from sdaeverify import SDE, HolonomicState, Increment

N, EPS = 7, np.finfo(float).eps


def hanging(alpha=4.0, Fr=3.0, Dr=0.1, beta=0.1, flow=1.0, N=N):
    return hanging_fibre(Fibre(chain=clamped_chain(N, 2), alpha=alpha, Fr=Fr, Dr=Dr, beta=beta), flow)


def clamped(flow, horizon=0.01, alpha=4.0, **others):
    return fibre_problem(Fibre(chain=clamped_chain(N, 2), flow=rotation(flow), alpha=alpha, **others), horizon)


def across(x):
    """Return the first components of points, shape (n, P) -> (N, P)."""
    return x.reshape(-1, 2, x.shape[-1])[:, 0]


@pytest.mark.parametrize("alpha", [0.4, 4.0])
def test_matrices_are_derivatives_of_the_inherent_drift(alpha):
    """At the straight fibre at rest without flow, y'' depends on y by -K and on y' by -D, tension included."""
    view = clamped(alpha=alpha, Fr=0.6, flow=0.0).view(SDE)
    x = view.initial(1)
    A = derivative(lambda z: view.drift(0.0, z), x)[..., 0]
    rows = np.concatenate([2 * np.arange(N), 2 * N + 2 * np.arange(N)])
    expected = hanging(alpha, Fr=0.6).generator

    np.testing.assert_allclose(A[np.ix_(rows, rows)], expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
    assert not np.delete(A, rows, axis=1)[rows].any()


@pytest.mark.parametrize("alpha", [0.4, 4.0])
def test_mean_and_covariance_solve_their_equations(alpha):
    """They are m' = A m + (0, F) and C' = A C + C A^T + (0, sigma^2), integrated numerically."""
    fibre, n = hanging(alpha), 2 * N
    A, force, Q = fibre.generator, np.concatenate([np.zeros(N), fibre.F]), fibre.noise @ fibre.noise.T
    m, C = moments_at(A, force, Q, np.zeros(n), 0.05)
    scale = np.sqrt(np.diag(fibre.covariance(0.05)))

    np.testing.assert_allclose(fibre.mean(0.05), m, rtol=1e-7)
    difference = (fibre.covariance(0.05) - C) / np.outer(scale, scale)
    assert np.abs(difference).max() < 1e-7


@pytest.mark.parametrize("h", [1e-7, 1e-4, 1e-2])
def test_exact_steps_have_the_covariance_of_the_solution(h):
    """The parts made of dW, H and further normals add up to C(h), in every component."""
    linear = hanging(0.5, N=3)
    step, expected = gaussian_step(linear.generator, linear.noise, h), linear.covariance(h)
    parts = h * step.of_dW @ step.of_dW.T + h / 12 * step.of_H @ step.of_H.T + step.of_xi @ step.of_xi.T
    scale = np.sqrt(np.diag(expected))

    assert np.abs((parts - expected) / np.outer(scale, scale)).max() < 1e-11


def step_matrix(fibre, h, semi_implicit):
    """Return the step y+ = y + h p, p+ = p - h (K y + D p), or with y+ in the second equation."""
    columns = []
    for z in np.eye(2 * len(fibre.F)):
        y, p = np.split(z, 2)
        moved = y + h * p
        columns.append(np.concatenate([moved, p - h * (fibre.K @ (moved if semi_implicit else y) + fibre.D @ p)]))
    return np.array(columns).T


def radius(fibre, h):
    """Return the spectral radius of one explicit step."""
    return np.abs(np.linalg.eigvals(step_matrix(fibre, h, semi_implicit=False))).max()


@pytest.mark.parametrize("points", [2, 7, 12])
@pytest.mark.parametrize("alpha", [0.4, 4.0])
def test_the_limit_is_where_the_spectral_radius_passes_one(points, alpha):
    """All smaller steps are stable, and the next larger ones are not."""
    fibre = hanging(alpha, N=points)
    limit = fibre.explicit_limit()

    assert max(radius(fibre, share * limit) for share in np.linspace(0.01, 0.999, 60)) < 1.0
    assert radius(fibre, 1.001 * limit) > 1.0


def consistent(y, p):
    """Return chains with displacements y and velocities p across them, shapes (N, P)."""
    ds = 1.0 / (N + 1)
    bend, turn = (np.diff(z, axis=0, prepend=0.0) for z in (y, p))
    down = np.sqrt(ds**2 - bend**2)
    r = np.stack([y, -0.5 * ds - np.cumsum(down, axis=0)], axis=1)
    v = np.stack([p, np.cumsum(bend * turn / down, axis=0)], axis=1)
    return HolonomicState(r.reshape(2 * N, -1), v.reshape(2 * N, -1), np.zeros((N, y.shape[1])))


SCHEMES = {
    "half-explicit": (HalfExplicitEuler(truncation="none"), False),
    "(B)": (ExplicitProjectionEuler(), False),
    "(B')": (SemiImplicitProjectionEuler(), True),
}


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("alpha", [0.4, 4.0])
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_schemes_move_a_hanging_fibre_by_their_matrix(name, alpha, share):
    """Around the explicit limit, steps without noise from small displacements are those of the linearised fibre."""
    (scheme, semi_implicit), fibre = SCHEMES[name], hanging(alpha)
    problem = clamped(alpha=alpha, beta=0.0, flow=0.0)
    h = share * fibre.explicit_limit()
    size, still = 1e-6, Increment(np.zeros((2 * N, 2 * N)), None)
    y, p = np.split(size * np.eye(2 * N), 2)
    step = scheme.prepare(problem, h)(scheme.enter(problem, consistent(y, p), 0.0, h), 0.0, still)
    parts = scheme.parts(problem, step.state)
    expected = step_matrix(fibre, h, semi_implicit)

    # Fourth differences add up 16 roundings of positions of size 1; what is not linear is 1e-12.
    moved = np.concatenate([across(parts["r"]), across(parts["v"])]) / size
    assert np.abs(moved - expected).max() <= 32 * EPS / size * np.abs(expected).max()
