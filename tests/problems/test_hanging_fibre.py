"""The linearised hanging fibre against the fibre itself, and the stability of schemes on it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from problems.fibre_chains import derivative
from sdaeverify.contracts.specs import matrix_specs
from sdaeverify.forms import SDE, HolonomicState
from sdaeverify.noise.brownian import Increment, Source, brownian_steps
from sdaeverify_problems._chain import clamped_chain
from sdaeverify_problems._fibre import Fibre, rotation
from sdaeverify_problems._fibre_problem import fibre_problem
from sdaeverify_problems._hanging_fibre import hanging_fibre
from sdaeverify_problems.fibre_clamped import fibre_clamped
from sdaeverify_schemes.explicit_projection_euler import ExplicitProjectionEuler
from sdaeverify_schemes.half_explicit_euler import HalfExplicitEuler
from sdaeverify_schemes.semi_implicit_projection_euler import SemiImplicitProjectionEuler

N = 7


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


def test_flow_and_noise_are_those_of_the_fibre():
    """F is the force across the fibre at rest, and sigma the noise on each point."""
    problem = clamped(beta=0.3, flow=0.7)
    r, v, _ = problem.initial(1)
    fibre = hanging(beta=0.3, flow=0.7)

    np.testing.assert_allclose(across(problem.force(0.0, r, v))[:, 0], fibre.F, rtol=1e-12)
    np.testing.assert_allclose(problem.diffusion(0.0, r, v)[..., 0], fibre.sigma * np.eye(2 * N), rtol=1e-14)


@pytest.mark.parametrize("alpha", [0.4, 4.0])
def test_mean_and_covariance_solve_their_equations(alpha):
    """They are m' = A m + (0, F) and C' = A C + C A^T + (0, sigma^2), integrated numerically."""
    fibre, n = hanging(alpha), 2 * N
    A, force, Q = fibre.generator, np.concatenate([np.zeros(N), fibre.F]), fibre.noise @ fibre.noise.T

    def rates(t, x):
        C = x[n:].reshape(n, n)
        return np.concatenate([A @ x[:n] + force, (A @ C + C @ A.T + Q).ravel()])

    end = solve_ivp(rates, (0.0, 0.05), np.zeros(n + n * n), method="LSODA", rtol=1e-10, atol=1e-13).y[:, -1]
    scale = np.sqrt(np.diag(fibre.covariance(0.05)))

    np.testing.assert_allclose(fibre.mean(0.05), end[:n], rtol=1e-7)
    difference = (fibre.covariance(0.05) - end[n:].reshape(n, n)) / np.outer(scale, scale)
    assert np.abs(difference).max() < 1e-7


@pytest.mark.parametrize("t", [1e-6, 0.01, 0.25, 3.0])
def test_covariance_is_that_of_two_halves(t):
    """C(t) = C(s) + e^{sA} C(t - s) e^{sA^T}, for times short and long, in every component."""
    fibre, s = hanging(0.4), 0.3 * t
    values, vectors = np.linalg.eig(fibre.generator)
    flow = ((vectors * np.exp(s * values)) @ np.linalg.inv(vectors)).real
    expected = fibre.covariance(s) + flow @ fibre.covariance(t - s) @ flow.T
    scale = np.sqrt(np.diag(expected))

    assert np.abs((fibre.covariance(t) - expected) / np.outer(scale, scale)).max() < 1e-9


def step_matrix(fibre, h, semi_implicit):
    """Return the step y+ = y + h p, p+ = p - h (K y + D p), or with y+ in the second equation."""
    columns = []
    for z in np.eye(2 * len(fibre.F)):
        y, p = np.split(z, 2)
        moved = y + h * p
        columns.append(np.concatenate([moved, p - h * (fibre.K @ (moved if semi_implicit else y) + fibre.D @ p)]))
    return np.array(columns).T


def radius(fibre, h, semi_implicit):
    """Return the spectral radius of one step."""
    return np.abs(np.linalg.eigvals(step_matrix(fibre, h, semi_implicit))).max()


@pytest.mark.parametrize("points", [2, 7, 12])
@pytest.mark.parametrize("alpha", [0.4, 4.0])
@pytest.mark.parametrize("semi_implicit", [False, True])
def test_limits_are_where_the_spectral_radius_passes_one(points, alpha, semi_implicit):
    """All smaller steps are stable, and the next larger ones are not."""
    fibre = hanging(alpha, N=points)
    limit = fibre.semi_implicit_limit() if semi_implicit else fibre.explicit_limit()

    assert max(radius(fibre, share * limit, semi_implicit) for share in np.linspace(0.01, 0.999, 60)) < 1.0
    assert radius(fibre, 1.001 * limit, semi_implicit) > 1.0


def test_limits_go_with_the_distance_of_points_as_they_should():
    """(B) loses stability like ds^6, (B') like ds^2, where bending is stiff: (B') near 2/K_max^{1/2}."""
    coarse, fine = (hanging(0.4, N=points) for points in (15, 31))
    explicit = np.log2(coarse.explicit_limit() / fine.explicit_limit())
    semi_implicit = np.log2(coarse.semi_implicit_limit() / fine.semi_implicit_limit())
    stiffest = 2.0 / np.sqrt(np.linalg.eigvalsh(fine.K)[-1])

    assert explicit == pytest.approx(6.0, abs=0.2)
    assert semi_implicit == pytest.approx(2.0, abs=0.05)
    assert fine.semi_implicit_limit() == pytest.approx(stiffest, rel=0.01)


def growth(scheme, alpha, h, semi_implicit):
    """Return by how much noise-free steps multiply the mode that is lost first, and what their matrix says."""
    problem, fibre = clamped(alpha=alpha, beta=0.0, flow=0.0), hanging(alpha)
    limit = fibre.semi_implicit_limit() if semi_implicit else fibre.explicit_limit()
    lost = np.linalg.eigvals(step_matrix(fibre, 1.01 * limit, semi_implicit))
    values, vectors = np.linalg.eig(step_matrix(fibre, h, semi_implicit))
    worst = np.argmin(np.abs(values - lost[np.argmax(np.abs(lost))]))
    reading, mode = np.linalg.inv(vectors)[worst], vectors[:, worst].real
    y, p = np.split(1e-6 * mode / np.abs(mode).max(), 2)
    state = scheme.enter(problem, consistent(y, p), 0.0, h)
    still = Increment(np.zeros((2 * N, 1)), None)
    steps, amplitudes = 12, []
    for n in range(steps + 1):
        parts = scheme.parts(problem, state)
        amplitudes.append(abs(reading @ np.concatenate([across(parts["r"]), across(parts["v"])])[:, 0]))
        state = scheme.step(problem, state, n * h, h, still).state
    return (amplitudes[-1] / amplitudes[0]) ** (1 / steps), np.abs(values[worst])


def consistent(y, p):
    """Return the chain with displacements y and velocities p across it."""
    ds = 1.0 / (N + 1)
    bend, turn = np.diff(y, prepend=0.0), np.diff(p, prepend=0.0)
    down = np.sqrt(ds**2 - bend**2)
    r = np.stack([y, -0.5 * ds - np.cumsum(down)], axis=1)
    v = np.stack([p, np.cumsum(bend * turn / down)], axis=1)
    return HolonomicState(r.reshape(-1, 1), v.reshape(-1, 1), np.zeros((N, 1)))


SCHEMES = {
    "half-explicit": (HalfExplicitEuler(truncation="none"), False),
    "(B)": (ExplicitProjectionEuler(), False),
    "(B')": (SemiImplicitProjectionEuler(), True),
}


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("alpha", [0.4, 4.0])
def test_schemes_gain_and_lose_stability_at_their_limits(name, alpha):
    """Just below, steps damp the least stable mode; just above, they amplify it; both by the factor computed."""
    scheme, semi_implicit = SCHEMES[name]
    fibre = hanging(alpha)
    limit = fibre.semi_implicit_limit() if semi_implicit else fibre.explicit_limit()
    below, expected_below = growth(scheme, alpha, 0.99 * limit, semi_implicit)
    above, expected_above = growth(scheme, alpha, 1.01 * limit, semi_implicit)

    assert below < 1.0 < above
    # Amplitudes of 1e-6 leave relative errors of 1e-10 for rounding and 1e-12 for what is not linear.
    assert (below, above) == pytest.approx((expected_below, expected_above), abs=1e-9)


def test_another_scheme_is_refuted():
    """Just above the explicit limit, the semi-implicit scheme does not amplify what the explicit matrix does."""
    limit = hanging().explicit_limit()
    found, expected = growth(SemiImplicitProjectionEuler(), 4.0, 1.01 * limit, semi_implicit=False)

    assert found < 0.999
    assert expected > 1.0


@pytest.mark.parametrize("parameters", [spec.parameters for spec in matrix_specs(fibre_clamped)])
def test_steps_in_the_matrix_are_stable_for_explicit_schemes(parameters):
    """The coarsest of the default levels, 8 steps up to the horizon, is below the explicit limit."""
    given = dict(parameters)

    assert given["horizon"] / 8 < hanging(N=given["N"], alpha=given["alpha"]).explicit_limit()


def noise_free(flow, steps=400, horizon=0.25):
    """Return the tip at the horizon by the fine reference."""
    problem = clamped(beta=0.0, flow=flow, horizon=horizon)
    h, z, still = horizon / steps, problem.pathwise.start(1), np.zeros((problem.noise_dim, 1))
    for n in range(steps):
        z = problem.pathwise.advance(z, n * h, h, Increment(still, still))
    return z[2 * N - 2, 0]


def test_mean_tip_position_is_that_of_the_linear_fibre():
    """At flow 0.1 and time 1/4 they differ by 0.012 per cent, and a hundred times as much at flow 1."""
    errors = [noise_free(flow) / hanging(flow=flow).mean(0.25)[N - 1] - 1.0 for flow in (0.1, 1.0)]

    assert abs(errors[0]) < 2e-4
    assert errors[1] / errors[0] == pytest.approx(100.0, rel=0.05)


def test_mean_of_a_stiffer_fibre_is_refuted():
    """The comparison of means tells another bending number, drag or flow."""
    tip = noise_free(0.1)
    for others in ({"alpha": 0.4}, {"Dr": 0.101}, {"flow": 0.1001}, {"N": 8}):
        wrong = hanging(**{"flow": 0.1, **others})
        assert abs(tip / wrong.mean(0.25)[len(wrong.F) - 1] - 1.0) > 2e-4


@pytest.mark.slow
def test_sampled_tip_has_the_mean_and_the_variance_of_the_linear_fibre():
    """With little noise, 4000 paths of (B') agree with both within four standard errors and the errors they have."""
    horizon, steps, paths, beta, flow = 0.25, 512, 4000, 2e-3, 0.1
    problem = clamped(beta=beta, flow=flow, horizon=horizon)
    scheme, state, h = SemiImplicitProjectionEuler(), problem.initial(paths), horizon / steps
    noise = next(brownian_steps(Source(5, "fibre", 0, paths), 2 * N, horizon, 9))[-1]
    for n in range(steps):
        state = scheme.step(problem, state, n * h, h, noise.increment(n)).state
    tip, fibre = across(state.r)[-1], hanging(beta=beta, flow=flow)
    mean, variance = fibre.mean(horizon)[N - 1], fibre.covariance(horizon)[N - 1, N - 1]

    # One step of (B) or (B') has a relative error of some h/horizon.
    assert tip.mean() == pytest.approx(mean, abs=4 * np.sqrt(variance / paths) + (2e-4 + h / horizon) * abs(mean))
    assert tip.var() == pytest.approx(variance, rel=4 * np.sqrt(2 / paths) + 3 * h / horizon)
