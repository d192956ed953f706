"""Solvability of the half-explicit step: for every h with truncation, Theorem 3.4, and how often not without."""

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom

from facade import HalfExplicitEuler, damped_pendulum, pendulum, sphere_langevin
from sdaeverify import Array, HolonomicSDAE, HolonomicState, Increment, verify

THEORY, NONE = HalfExplicitEuler(), HalfExplicitEuler(truncation="none")
PROBLEMS: dict[str, Callable[[], HolonomicSDAE]] = {
    "pendulum": pendulum,
    "pendulum with masses": lambda: damped_pendulum(mass=5.0),
    "sphere": sphere_langevin,
    "sphere with masses": lambda: sphere_langevin(m_1=1.0, m_2=2.0, m_3=4.0),
    "sphere with light masses": lambda: sphere_langevin(m_1=0.1, m_2=1.0, m_3=0.5),
}
SPEEDS = np.geomspace(1e-6, 1e12, 73)
STEPS = (1e-6, 1e-4, 1e-2, 0.3, 1.0, 30.0, 1e3)


def fast(problem: HolonomicSDAE) -> HolonomicState:
    """Return random states on the manifold, one for each of the speeds."""
    n, rng = problem.dimension, np.random.default_rng(9)
    states = problem.admissible(rng.standard_normal((2 * n + 1, SPEEDS.size)))
    v = states[n : 2 * n]
    return HolonomicState(states[:n], SPEEDS * v / np.linalg.norm(v, axis=0), states[2 * n :])


def failures(scheme: HalfExplicitEuler, problem: HolonomicSDAE, h: float) -> Array:
    """Return which of the speeds meet a step without root; Newton's method may overflow on its way there."""
    state = fast(problem)
    dW = np.sqrt(h) * np.random.default_rng(2).standard_normal((problem.noise_dim, SPEEDS.size))
    with np.errstate(all="ignore"):
        step = scheme.step(problem, state, 0.0, h, Increment(dW, None))
    assert step.failed is not None
    return np.asarray(step.failed)


@pytest.mark.parametrize("name", PROBLEMS)
def test_with_truncation_every_step_has_its_root(name: str) -> None:
    """At any speed and any step size, with masses too; without truncation the fast paths fail."""
    problem = PROBLEMS[name]()

    assert not np.any([failures(THEORY, problem, h) for h in STEPS])
    assert all(failures(NONE, problem, h)[h * SPEEDS > 10.0].all() for h in STEPS)


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


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    """Return the levels of the strong order of the velocity, coarsest first."""
    problem = f"pendulum[c_g=0,omega_0={OMEGA_0},horizon=1]"
    settings = {"coarsest": 4, "levels": 7, "paths": 256, "block": 256}
    result = verify("half-explicit-euler[truncation=none]", problem, "strong", **settings)
    reasons = result.verdicts.set_index("quantity")["reason"]
    assert "failed paths at 4 levels" in reasons["v"]
    return result.levels[result.levels["quantity"] == "v"].reset_index()


@pytest.mark.slow
def test_a_run_reports_the_paths_without_root(table: pd.DataFrame) -> None:
    """The levels say how many paths failed, in agreement with the exact chain."""
    for row in table.itertuples():
        k = round(-np.log2(row.h))
        assert plausible(row.failed_paths, row.paths, share_by_operator(k) if k < 6 else 0.0), row.h
