"""A delay problem without closed form, and states and noise of a step on every kind of mesh."""

import numpy as np

from sdaeverify import Array, DelaySDAE, DelayState, Increment

PATHS, T = 6, 0.4
# tau/h by kind of mesh.
H = 0.25
MESHES = {"m = 8": 8.0, "m = 1": 1.0, "m = 3, delta": 2.7, "m = 2, delta": 1.4, "h > tau": 0.6, "tau = 0": 0.0}


def coupling(t: float, x: Array, v: Array, y: Array) -> Array:
    """Return a drift that couples everything, for x of two rows and y of one."""
    return np.stack([np.sin(x[1]) - x[0] + t * v[1] + y[0], np.cos(v[0]) - 2.0 * x[1] + x[0] * y[0]])


def noise_of(t: float, x: Array, v: Array, y: Array) -> Array:
    """Return two columns of noise."""
    return np.stack([np.stack([0.3 * x[0], v[1]]), np.stack([0.2 * y[0], np.cos(v[0]) + t])])


def cubic(t: float, x: Array, v: Array, y: Array) -> Array:
    """Return a constraint with one solution y."""
    return (y + 0.2 * y**3 - x[:1] + 0.5 * v[1:] - 0.1 * t) * 1.0


def nonlinear(delay: float = 1.0) -> DelaySDAE:
    """Return a problem without closed form."""
    return DelaySDAE(
        drift=coupling,
        diffusion=noise_of,
        constraint=cubic,
        algebraic=1,
        delay=delay,
        history=lambda t: [1.0 + t, 0.5 - 0.2 * t],
        noise_dim=2,
        horizon=4.0,
        source="made up",
    )


def given(problem: DelaySDAE, h: float, seed: int = 3) -> tuple[DelayState, Increment]:
    """Return states and the noise of a step, with the lagged values of a random past."""
    rng = np.random.default_rng(seed)
    x = problem.initial(PATHS).x + 0.4 * rng.standard_normal((problem.dimension, PATHS))
    older, middle = x + 0.5 * rng.standard_normal((2, *x.shape))
    dW = np.sqrt(h) * rng.standard_normal((problem.noise_dim, PATHS))
    if not problem.delay:
        y = problem.eliminated(T, x, x)
        return DelayState(x, y), Increment(dW, None)
    m, delta = problem.mesh(h)
    # xb_n lies between x_{n-m} and x_{n-m+1}, which is x_n itself with m = 1.
    newer = x if m == 1 else middle
    lagged = delta * newer + (1.0 - delta) * older
    ahead = (1.0 - delta) * x if m == 1 else delta * x + (1.0 - delta) * middle
    y = problem.eliminated(T, x, lagged)
    return DelayState(x, y), Increment(dW, None, lagged=lagged, ahead=ahead)
