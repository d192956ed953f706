"""Equations and increments for tests of bridges."""

import numpy as np

from sdaeverify import SDE, Increment

H, PATHS = 0.125, 7


def curved(rate=1.0, horizon=1.0):
    """Return dx = (t - rate x^2) dt + (cos x + t) dW."""
    return SDE(
        drift=lambda t, x: t - rate * x**2,
        diffusion=lambda t, x: (np.cos(x) + t)[:, None],
        start=[1.0],
        noise_dim=1,
        horizon=horizon,
        source="a test",
    )


def drawn(problem, h, paths):
    """Return an increment of dW and H for a step of length h."""
    rng = np.random.default_rng(20261122)
    dW, areas = np.sqrt(h) * rng.standard_normal((2, problem.noise_dim, paths))
    return Increment(dW, areas / np.sqrt(12.0))


def shifted(problem):
    """Return states of all paths, each another one."""
    return problem.initial(PATHS) + 0.1 * np.arange(PATHS)
