"""Force and noise of fibres against Lindner et al. (2018), (2.8), written out point by point."""

import numpy as np
import pytest

from problems.fibre_chains import CHAINS, curved, derivative
from sdaeverify.numerics import is_analytic
from sdaeverify_problems._chain import clamped_chain, free_chain
from sdaeverify_problems._chain_matrices import scalar_matrices
from sdaeverify_problems._fibre import Fibre, rotation
from sdaeverify_problems._fibre_noise import FibreNoise
from sdaeverify_problems._fibre_observables import potential
from sdaeverify_problems._fibre_problem import fibre_problem

EPS = np.finfo(float).eps
PATHS = 3
T = 0.3


def swirl(x, t):
    """Return a flow that is neither linear nor steady."""
    return np.stack([np.sin(x[1] + t), x[0] * x[1], *np.cos(x[2:] - t)])


def C(r, tau, t):
    """Return a drag that differs along and across the fibre and from place to place, and is not symmetric."""
    one = np.eye(len(r))[..., None, None]
    return (1.0 + 0.3 * np.sin(r[0] + t)) * (one - 0.5 * tau[:, None] * tau[None] + 0.1 * tau[:, None] * r[None])


def D(r, v, tau, t):
    """Return a turbulence that depends on velocities and is not symmetric."""
    one = np.eye(len(r))[..., None, None]
    return one * (1.0 + 0.1 * v[0]) + 0.2 * r[:, None] * tau[None]


@pytest.fixture(params=CHAINS, name="chain")
def given_chain(request):
    return CHAINS[request.param]


def ghosts(chain, x, moving):
    """Return the points -1..N+2 in a dictionary by their number; velocities at a clamp vanish."""
    N = chain.N
    points = dict(enumerate(x.reshape(N, chain.d, -1), start=1))
    points[N + 1] = 2 * points[N] - points[N - 1]
    points[N + 2] = 3 * points[N] - 2 * points[N - 1]
    if chain.root is None:
        points[0] = 2 * points[1] - points[2]
        points[-1] = 3 * points[1] - 2 * points[2]
    else:
        points[-1], points[0] = (0.0 * points[1] if moving else place + 0.0 * points[1] for place in chain.root)
    return points


def on_edge(fibre, t, x, y, i):
    """Return f and A on the edge i - 1/2, in the notation of the paper."""
    r, v, tau = 0.5 * (x[i] + x[i - 1]), 0.5 * (y[i] + y[i - 1]), (x[i] - x[i - 1]) / fibre.chain.ds
    edge = [z[:, None] for z in (r, v, tau)]
    one = np.eye(len(r))[..., None] * np.ones(r.shape[-1])
    drag = one if fibre.C is None else fibre.C(edge[0], edge[2], t)[:, :, 0]
    turbulence = one if fibre.D is None else fibre.D(*edge, t)[:, :, 0]
    wind = fibre.flow(edge[0], t)[:, 0] - v
    gravity = -np.eye(len(r))[1][:, None] / fibre.Fr**2
    f = gravity + np.einsum("abp,bp->ap", drag, wind) / fibre.Dr**2
    return f, fibre.beta / fibre.Dr**2 * np.einsum("abp,bcp->acp", drag, turbulence)


def written_out(fibre, t, r, v):
    """Return a, shape (n, P), and B, shape (n, n, P), of (2.8) without multipliers."""
    chain = fibre.chain
    x, y = ghosts(chain, r, moving=False), ghosts(chain, v, moving=True)
    a, B = [], np.zeros((chain.N, chain.d, chain.N, chain.d, r.shape[-1]))
    for i in range(1, chain.N + 1):
        (f, A), (g, A_next) = (on_edge(fibre, t, x, y, k) for k in (i, i + 1))
        fourth = x[i + 2] - 4 * x[i + 1] + 6 * x[i] - 4 * x[i - 1] + x[i - 2]
        a.append(-fourth / (fibre.alpha**2 * chain.ds**4) + 0.5 * (f + g))
        B[i - 1, :, i - 1] = (A + A_next) / (2 * np.sqrt(chain.ds))
    return np.concatenate(a), B.reshape(len(r), len(r), -1)


FIBRES = {
    "plain": {},
    "swirl": {"flow": swirl, "Fr": 1.3, "Dr": 0.4, "alpha": 0.7},
    "drag": {"flow": swirl, "C": C},
    "turbulence": {"D": D},
    "both": {"flow": swirl, "C": C, "D": D},
}


@pytest.mark.parametrize("name", FIBRES)
def test_force_and_noise_are_those_of_the_paper(chain, name):
    """At curved chains in motion, a, B and B w agree with (2.8) written out point by point."""
    fibre = Fibre(chain=chain, **FIBRES[name])
    noise, r = FibreNoise(fibre), curved(chain, PATHS)
    v, w = np.random.default_rng(2).standard_normal((2, *r.shape))
    a, B = written_out(fibre, T, r, v)

    np.testing.assert_allclose(fibre.force(T, r, v), a, rtol=0.0, atol=64 * EPS * 16 / (fibre.alpha**2 * chain.ds**4))
    np.testing.assert_allclose(
        np.broadcast_to(noise.matrix(T, r, v), B.shape), B, rtol=0.0, atol=64 * EPS * np.abs(B).max()
    )
    kick = np.einsum("nlp,lp->np", B, w)
    np.testing.assert_allclose(noise.product(T, r, v, w), kick, rtol=0.0, atol=256 * EPS * np.abs(kick).max())


@pytest.mark.parametrize("name", FIBRES)
def test_force_and_noise_can_be_differentiated_by_complex_steps(chain, name):
    """Nothing in them takes a real part."""
    fibre = Fibre(chain=chain, **FIBRES[name])
    noise, r = FibreNoise(fibre), curved(chain, 1)
    n, v = len(r), np.random.default_rng(2).standard_normal(r.shape)
    x = np.concatenate([r, v])

    assert is_analytic(lambda z: fibre.force(T, z[:n], z[n:]), x)
    assert is_analytic(lambda z: noise.product(T, z[:n], z[n:], v) + 0.0 * z[:n], x)
    assert is_analytic(lambda z: noise.matrix(T, z[:n], z[n:]) + 0.0 * z[:n], x)


@pytest.mark.parametrize("d", [2, 3])
def test_hanging_fibre_is_at_rest_without_flow(d):
    """The multiplier takes all of gravity: accelerations vanish, and its rate is Fr^{-2} (1 - s)."""
    problem = fibre_problem(Fibre(chain=clamped_chain(7, d), flow=rotation(0.0), Fr=0.8), 0.01)
    r, v, _ = problem.initial(1)
    J, a = problem.linearised(r), problem.force(0.0, r, v)
    rate = problem.inherent_multiplier(J, r, v, a)

    np.testing.assert_allclose(rate[:, 0], (1.0 - np.arange(1, 8) / 8) / 0.8**2, rtol=1e-12)
    np.testing.assert_allclose(a + J.transposed(rate), 0.0, atol=1e-12 * np.abs(a).max())


def still(chain, **others):
    """Return a fibre in air that does not drag it."""
    return Fibre(
        chain=chain, flow=lambda r, t: 0.0 * r, C=lambda r, tau, t: np.zeros((chain.d, chain.d, 1, 1)), **others
    )


def test_bending_and_gravity_are_a_potential_force(chain):
    """The force at rest in still air is -1/ds times the gradient of the potential energy."""
    fibre, r = still(chain, alpha=0.9, Fr=0.7), curved(chain, PATHS)
    gradient = derivative(lambda x: potential(fibre, x)[None], r)[0]
    force = fibre.force(0.0, r, 0.0 * r)

    np.testing.assert_allclose(chain.ds * force, -gradient, rtol=0.0, atol=256 * EPS * np.abs(gradient).max())


@pytest.mark.parametrize("d", [2, 3])
def test_nothing_inside_a_free_fibre_moves_or_turns_it(d):
    """Without gravity and drag, bending forces and multipliers have no resultant and no moment."""
    fibre = still(free_chain(6, d), Fr=np.inf)
    problem = fibre_problem(fibre, 0.01)
    r = curved(fibre.chain, PATHS)
    c = np.random.default_rng(4).standard_normal((problem.constraints, PATHS))
    x = r.reshape(6, d, PATHS)
    for impulse in (fibre.force(0.0, r, 0.0 * r), problem.linearised(r).transposed(c)):
        pull = impulse.reshape(6, d, PATHS)
        moment = np.einsum("iap,ibp->abp", x, pull)
        size = np.abs(pull).max() * np.abs(x).max()
        np.testing.assert_allclose(pull.sum(axis=0), 0.0, atol=256 * EPS * np.abs(pull).max())
        np.testing.assert_allclose(moment - np.swapaxes(moment, 0, 1), 0.0, atol=256 * EPS * size)


def test_free_fibre_moves_with_what_it_is_seen_from():
    """Without gravity and flow, its force turns with it, and does not notice where it is."""
    fibre = Fibre(chain=free_chain(5, 2), Fr=np.inf, flow=rotation(0.0))
    r = curved(fibre.chain, PATHS)
    v = np.random.default_rng(5).standard_normal(r.shape)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])

    def turned(x):
        return np.einsum("ab,ibp->iap", turn, x.reshape(5, 2, PATHS)).reshape(r.shape)

    force = fibre.force(0.0, r, v)
    moved = fibre.force(0.0, turned(r) + 3.0, turned(v))
    np.testing.assert_allclose(moved, turned(force), rtol=0.0, atol=1024 * EPS * np.abs(force).max())


def test_clamped_fibre_is_held_by_its_clamp():
    """The same is not true of it: its clamp pulls and turns it back."""
    fibre = still(clamped_chain(6, 2), Fr=np.inf)
    r = curved(fibre.chain, PATHS)
    force = fibre.force(0.0, r, 0.0 * r)

    assert np.abs(force.reshape(6, 2, PATHS).sum(axis=0)).min() > 1e-3 * np.abs(force).max()


@pytest.mark.parametrize("make", [clamped_chain, free_chain])
def test_bending_matrix_is_the_one_with_stress_free_ends(make):
    """It is symmetric, its last rows are (1, -4, 5, -2) and (1, -2, 1), and only rigid motions have no energy."""
    chain = make(6, 2)
    S, _ = scalar_matrices(chain)
    s = chain.arc_lengths
    rigid = [] if chain.root is not None else [np.ones(6), s]

    np.testing.assert_array_equal(S, S.T)
    np.testing.assert_array_equal(S[-2, -4:], [1, -4, 5, -2])
    np.testing.assert_array_equal(S[-1, -4:], [0, 1, -2, 1])
    assert sum(np.linalg.eigvalsh(S) < 1e-9) == len(rigid)
    for motion in rigid:
        np.testing.assert_allclose(S @ motion, 0.0, atol=64 * EPS)


def test_drag_on_points_is_the_mean_over_two_edges():
    """Where C is the identity, it is -Dr^{-2} (v_{i+1} + 2 v_i + v_{i-1})/4, and -Dr^{-2} v_N at the end."""
    _, W = scalar_matrices(clamped_chain(5, 2))
    drag = 0.5 * (W[1:] + W[:-1])
    expected = (2 * np.eye(5) + np.eye(5, k=1) + np.eye(5, k=-1)) / 4
    expected[-1] = np.eye(5)[-1]

    np.testing.assert_array_equal(drag, expected)


@pytest.mark.parametrize("make", [clamped_chain, free_chain])
def test_finer_fibres_feel_the_same_white_noise(make):
    """The momentum sum ds (B dw)_i of coarse and of finer cells is beta Dr^{-2} times xi of their sum."""
    chain = make(7, 2)
    sums = []
    for finer in (chain, chain._replace(N=4 * chain.N, ds=chain.ds / 4)):
        noise = FibreNoise(Fibre(chain=finer, beta=0.2, Dr=0.5))
        xi = np.random.default_rng(6).standard_normal((chain.N, 4, 2)) * np.sqrt(chain.ds / 4)
        cells = xi.sum(axis=1) if finer is chain else xi.reshape(-1, 2)
        r = finer.straight()[:, None]
        kick = noise.product(0.0, r, 0.0 * r, cells.reshape(-1, 1) / np.sqrt(finer.ds))
        sums.append(finer.ds * kick.reshape(-1, 2).sum(axis=0) - 0.2 / 0.5**2 * xi.sum(axis=(0, 1)))

    np.testing.assert_allclose(sums, 0.0, atol=64 * EPS)
