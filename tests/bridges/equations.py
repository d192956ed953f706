"""Equations for tests of bridges."""

import numpy as np

from sdaeverify import SDE


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
