"""The Kubo oscillator: a rotation by a Brownian angle, which keeps its energy on every path."""

import numpy as np

from sdaeverify import SDE, Pathwise, hookimpl

SOURCE = "Milstein, Repin & Tretyakov 2002, section 5"


def kubo_oscillator(sigma: float = 1.0, horizon: float = 1.0) -> SDE:
    """Rotation: dx = J x (dt + sigma o dW) in Stratonovich's sense, J = (0, 1; -1, 0), x(0) = (1, 0); H = |x|^2/2.

    In Ito's sense, dx = (J x - sigma^2/2 x) dt + sigma J x dW: x(t) is x(0) turned by the angle t + sigma W(t).

    Parameters
    ----------
    sigma : float
        Strength of the noise, unit 1/sqrt(time).
    horizon : float
        Final time.

    Source
    ------
    Milstein, Repin & Tretyakov (2002), section 5.
    """
    return SDE(
        drift=lambda t, x: turned(x) - 0.5 * sigma**2 * x,
        diffusion=lambda t, x: sigma * turned(x)[:, None],
        diffusion_derivative=lambda t, x, y: sigma * turned(y)[:, None],
        start=[1.0, 0.0],
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"scalar-noise"}),
        noise=frozenset({"dW"}),
        observables={"H": lambda t, s: 0.5 * (s["x"] ** 2).sum(axis=0)},
        truths=(
            Pathwise(
                start=lambda paths: np.repeat([[1.0], [0.0]], paths, axis=1),
                advance=lambda x, t, h, noise: rotated(x, h + sigma * noise.dW[0]),
                parts=lambda t, x: {"x": x},
                source=SOURCE,
            ),
        ),
        source=SOURCE,
    )


def turned(x):
    """Return J x."""
    return np.stack([x[1], -x[0]])


def rotated(x, angle):
    """Return exp(angle J) x."""
    return np.cos(angle) * x + np.sin(angle) * turned(x)


@hookimpl
def sdaeverify_problems():
    """Register the problem."""
    return [kubo_oscillator]
