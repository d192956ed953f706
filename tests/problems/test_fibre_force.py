"""Force and noise of fibres against Lindner et al. (2018), (2.8), written out point by point."""

import numpy as np
import pytest

from facade import Fibre
from problems.fibre_chains import CHAINS, curved
from sdaeverify_problems.fibres._noise import FibreNoise

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


@pytest.mark.parametrize("chain", CHAINS)
@pytest.mark.parametrize("name", FIBRES)
def test_force_and_noise_are_those_of_the_paper(chain, name):
    """At curved chains in motion, a, B and B w agree with (2.8) written out point by point."""
    chain = CHAINS[chain]
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
