"""The linearised hanging fibre: transverse motion of a clamped fibre, with exact mean and covariance."""

from collections.abc import Callable
from functools import cache

import numpy as np

from sdaeverify import SDE, Array, Increment, Moment, Parts, Pathwise, hookimpl

from .. import _controls as controls
from .._gaussian_step import gaussian_step
from .._known import moments, solution
from ._chain import clamped_chain
from ._fibre import Fibre
from ._hanging_fibre import HangingFibre, hanging_fibre


def fibre_linear(
    alpha: float = 4.0, beta: float = 0.03, Dr: float = 0.1, N: int = 7, flow: float = 1.0, horizon: float = 0.01
) -> SDE:
    """Linearised hanging fibre: dy = p dt, dp = (-K y - D p + F) dt + sigma dW in R^N, from rest.

    y are the displacements perpendicular to the straight clamped fibre. K is alpha^{-2} ds^{-4} times the fourth
    difference plus the second difference weighted with the tension, Fr = 3, D is Dr^{-2} times the mean over edges,
    F_i = -Dr^{-2} flow s_i and sigma = beta Dr^{-2} ds^{-1/2}; the solution is Gaussian. With the default parameters,
    the standard deviation of the tip's speed is about its mean.

    Parameters
    ----------
    alpha : float
        Bending number, positive; small values mean a stiff fibre.
    beta : float
        Strength of the turbulence.
    Dr : float
        Drag number, positive.
    N : int
        Number of points, at least 2.
    flow : float
        Angular velocity of the flow, unit 1/time.
    horizon : float
        Final time.

    Source
    ------
    Lindner et al. (2018), (2.8) and section 4.2, linearised.
    """
    fibre = hanging_fibre(Fibre(chain=clamped_chain(N, 2), alpha=alpha, beta=beta, Dr=Dr), flow)
    linear, noise = fibre.generator[..., None], fibre.noise[..., None]
    return SDE(
        controls=controls.ADDITIVE,
        drift=lambda t, x: np.concatenate([x[N:], fibre.F[:, None] - fibre.K @ x[:N] - fibre.D @ x[N:]]),
        drift_derivative=lambda t, x: linear,
        diffusion=lambda t, x: noise,
        diffusion_derivative=lambda t, x, y: np.zeros((2 * N, N, 1)),
        start=np.zeros(2 * N),
        names={"y": slice(0, N), "p": slice(N, 2 * N)},
        noise_dim=N,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        observables={
            "tip": lambda t, s: s["y"][-1],
            "tip^2": lambda t, s: s["y"][-1] ** 2,
            "speed": lambda t, s: s["p"][-1],
            "speed^2": lambda t, s: s["p"][-1] ** 2,
        },
        truths=(_exact(fibre), *_moments(fibre)),
        units="length of the fibre 1, time in the unit in which alpha, Fr and Dr are given",
        source="Lindner et al. 2018, (2.8), linearised at the straight fibre",
    )


def _exact(fibre: HangingFibre) -> Pathwise:
    N = len(fibre.F)
    steps = cache(lambda h: gaussian_step(fibre.generator, fibre.noise, h))

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        step = steps(h)
        integral = step.of_dW @ noise.dW + step.of_H @ noise.H + step.of_xi @ noise.xi
        moved: Array = step.propagator @ x + fibre.mean(h)[:, None] + integral
        return moved

    def parts_of(t: float, x: Array) -> Parts:
        return {"y": x[:N], "p": x[N:]}

    return solution(np.zeros(2 * N), advance, "variation of constants", parts=parts_of, extra_normals=2 * N)


def _moments(fibre: HangingFibre) -> tuple[Moment, ...]:
    N = len(fibre.F)

    def first(row: int) -> Callable[[float], float]:
        return lambda t: float(fibre.mean(t)[row])

    def second(row: int) -> Callable[[float], float]:
        return lambda t: float(fibre.mean(t)[row] ** 2 + fibre.covariance(t)[row, row])

    values = {"tip": first(N - 1), "tip^2": second(N - 1), "speed": first(2 * N - 1), "speed^2": second(2 * N - 1)}
    return moments(values, "Gaussian: matrix exponentials")


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [fibre_linear]
