"""How often the half-explicit step without truncation has no root."""

import numpy as np
from scipy.stats import binom

from facade import HalfExplicitEuler, pendulum
from sdaeverify import Array, Increment

NONE = HalfExplicitEuler(truncation="none")
OMEGA_0, PATHS = 5.0, 2000


def share_by_operator(k: int, nodes: int = 600) -> float:
    """Return the probability that |omega_j| h >= 1 for some j < N, h = 2^-k, N = 2^k.

    Without gravity and truncation omega_{j+1} is normal with mean omega/cos(phi) and standard deviation
    sqrt(h)/cos(phi), sin(phi) = omega h, whatever theta: its density where there are roots is an integral over the
    density before, by Gauss' rule.
    """
    h, steps = 2.0**-k, 2**k
    if OMEGA_0 * h >= 1.0:
        return 1.0
    x, w = np.polynomial.legendre.leggauss(nodes)
    x, w = x / h, w / h

    def after(omega: Array) -> Array:
        cosine = np.sqrt(1.0 - (omega * h) ** 2)
        s = (x[:, None] * cosine - omega) / np.sqrt(h)
        return np.exp(-0.5 * s**2) * cosine / np.sqrt(2 * np.pi * h)

    density, kernel = after(np.array([OMEGA_0]))[:, 0], after(x) * w
    for _ in range(steps - 2):
        density = kernel @ density
    return float(1.0 - w @ density)


def failed_paths(k: int) -> int:
    """Return how many paths of the free pendulum meet a step without root within T = 1 at h = 2^-k."""
    problem, h, rng = pendulum(c_g=0.0, omega_0=OMEGA_0, horizon=1.0), 2.0**-k, np.random.default_rng(k)
    state, failed = problem.initial(PATHS), np.zeros(PATHS, dtype=bool)
    with np.errstate(all="ignore"):
        for n in range(2**k):
            step = NONE.step(problem, state, n * h, h, Increment(np.sqrt(h) * rng.standard_normal((2, PATHS)), None))
            state, failed = step.state, failed | step.failed
    return int(failed.sum())


def plausible(count: int, paths: int, share: float) -> bool:
    """Tell whether a binomial count is inside its interval of probability 1 - 1e-6."""
    share = min(max(share, 0.0), 1.0)
    return bool(binom.ppf(0.5e-6, paths, share) <= count <= binom.ppf(1.0 - 0.5e-6, paths, share))


def test_the_share_without_root_is_that_of_the_exact_chain() -> None:
    """Without truncation all paths fail for h >= 2^-3, 98.6 % at 2^-4, 10.2 % at 2^-5 and none at 2^-6."""
    shares = {k: share_by_operator(k) for k in range(2, 6)}

    assert [round(share, 3) for share in shares.values()] == [1.0, 1.0, 0.986, 0.102]
    for k, share in [*shares.items(), (6, 0.0)]:
        assert plausible(failed_paths(k), PATHS, share), (k, share)
