"""Shot noise: a relaxing quantity that is kicked by jumps and shaken by noise; its first two moments are exact."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Control, Moment, ParameterError, hookimpl

from ._compound_poisson import CompoundPoisson
from ._jump_diffusion import JumpDiffusion

MARKS, WEIGHTS = (0.2, 0.6), (0.7, 0.3)


def shot_noise(
    gamma: float = 1.0, sigma: float = 0.3, kick: float = 0.4, rate: float = 3.0, horizon: float = 1.0
) -> JumpDiffusion:
    """Dx = -gamma x dt + sigma dW + (1 + kick x-) dJ, x(0) = 0, with jumps at a rate whose marks are 0.2 or 0.6.

    With the moments m_1, m_2 of a mark, the first two of x obey

        E' = rate m_1 + a E,    a = rate kick m_1 - gamma,
        S' = sigma^2 + rate m_2 + 2 rate (m_1 + kick m_2) E + b S,    b = rate (2 kick m_1 + kick^2 m_2) - 2 gamma.

    Parameters
    ----------
    gamma, sigma, kick : float
    rate : float
        Jumps per unit of time, positive.
    horizon : float
        Final time.
    """
    if not rate > 0.0:
        raise ParameterError(f"rate must be positive, got {rate!r}")
    m1, m2 = (float(np.dot(WEIGHTS, np.power(MARKS, k))) for k in (1, 2))
    rows = [
        [0.0, 0.0, 0.0],
        [rate * m1, rate * kick * m1 - gamma, 0.0],
        [sigma**2 + rate * m2, 2.0 * rate * (m1 + kick * m2), rate * (2.0 * kick * m1 + kick**2 * m2) - 2.0 * gamma],
    ]
    growth, vectors = np.linalg.eig(np.array(rows))
    begin = np.linalg.solve(vectors, np.array([1.0, 0.0, 0.0]))

    def moment(index: int) -> Callable[[float], float]:
        return lambda t: float(np.real(vectors[index] @ (np.exp(growth * t) * begin)))

    source = "the linear equations of the moments"
    return JumpDiffusion(
        drift=lambda t, x: -gamma * x,
        diffusion=lambda t, x: sigma + 0.0 * x[:, None],
        jump=lambda t, x: 1.0 + kick * x,
        jumps=CompoundPoisson(rate, MARKS, WEIGHTS),
        start=[0.0],
        noise_dim=1,
        horizon=horizon,
        observables={"x": lambda t, s: s["x"][0], "x^2": lambda t, s: s["x"][0] ** 2},
        truths=(
            Moment(observable="x", value=moment(1), source=source),
            Moment(observable="x^2", value=moment(2), source=source),
        ),
        controls=(Control(measure="weak", order=1.0, positive="jump-euler", negative="marcus-jump-euler"),),
        source="Campbell's shot noise, with kicks that grow with the state",
    )


@hookimpl
def sdaeverify_problems() -> list[Callable[..., JumpDiffusion]]:
    """Register the problem."""
    return [shot_noise]
