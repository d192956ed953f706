"""A geometric Brownian motion that jumps: Merton's model with marks of two values."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Control, Moment, ParameterError, Pathwise, hookimpl

from ._compound_poisson import JUMPS, CompoundPoisson
from ._jump_diffusion import JumpDiffusion

MARKS, WEIGHTS = (-0.3, 0.4), (0.5, 0.5)


def geometric_jumps(mu: float = 0.1, sigma: float = 0.4, rate: float = 2.0, horizon: float = 1.0) -> JumpDiffusion:
    """Dx = mu x dt + sigma x dW + x- dJ, x(0) = 1, with jumps at a rate whose marks are -0.3 or 0.4.

    Then x(t) = exp((mu - sigma^2/2) t + sigma W(t)) times the product of all 1 + mark.

    Parameters
    ----------
    mu, sigma : float
    rate : float
        Jumps per unit of time, not negative.
    horizon : float
        Final time.
    """
    if not rate >= 0.0:
        raise ParameterError(f"rate must not be negative, got {rate!r}")
    source = "Ito's formula"
    truth = Pathwise(
        start=lambda paths: np.ones((1, paths)),
        advance=lambda x, t, h, noise: (
            x
            * np.exp((mu - 0.5 * sigma**2) * h + sigma * noise.dW)
            * np.prod(1.0 + noise.records[JUMPS].mark, axis=-2)
        ),
        parts=lambda t, x: {"x": x},
        source=source,
    )
    marks, p = np.array(MARKS), np.array(WEIGHTS)
    rates = mu + rate * p @ marks, 2.0 * mu + sigma**2 + rate * p @ ((1.0 + marks) ** 2 - 1.0)
    return JumpDiffusion(
        drift=lambda t, x: mu * x,
        diffusion=lambda t, x: sigma * x[:, None],
        jump=lambda t, x: x,
        jumps=CompoundPoisson(rate, MARKS, WEIGHTS),
        start=[1.0],
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"diagonal-noise"}),
        observables={"x": lambda t, s: s["x"][0], "x^2": lambda t, s: s["x"][0] ** 2},
        truths=(
            truth,
            Moment(observable="x", value=_grown(rates[0]), source=source),
            Moment(observable="x^2", value=_grown(rates[1]), source=source),
        ),
        controls=(
            Control(measure="strong", order=0.5, positive="jump-euler", negative="marcus-jump-euler"),
            Control(measure="weak", order=1.0, positive="jump-euler", negative="marcus-jump-euler"),
        ),
        source="Merton 1976, with marks of two values",
    )


def _grown(rate: float) -> Callable[[float], float]:
    return lambda t: float(np.exp(rate * t))


@hookimpl
def sdaeverify_problems() -> list[Callable[..., JumpDiffusion]]:
    """Register the problem."""
    return [geometric_jumps]
