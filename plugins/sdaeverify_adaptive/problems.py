"""Two equations that depend on a Levy area, one with and one without reflection symmetry."""

from collections.abc import Callable

import numpy as np

from sdaeverify import SDE, Array, Increment, Moment, Pathwise, Truth, hookimpl, on_request

SOURCE = "Ito's formula; Gaines & Lyons 1997, section 4, for the role of the area"
# Source of the truth; given dW and H, the area of a step of length h has variance h^2/12.
AREA = "W exactly; of each area what dW and H tell on the grid, which leaves a variance of h T/12"
OBSERVABLES = {
    "x_3": lambda t, s: s["x"][2],
    "x_3^2": lambda t, s: s["x"][2] ** 2,
}


@on_request
def heisenberg(horizon: float = 1.0) -> SDE:
    """Levy area: dx_1 = dW_1, dx_2 = dW_2, dx_3 = x_1 dW_2; the same in the senses of Ito and of Stratonovich.

    The noise is not commutative. The reflection W_1 -> -W_1, x_3 -> -x_3 leaves the equation invariant: an error of
    the area that occurs with both signs alike has mean zero here, even if the law of the solver is wrong.

    Parameters
    ----------
    horizon : float
        Final time T, in any unit: E x_3^2 = T^2/2.

    Source
    ------
    Gaines & Lyons (1997), Variable step size control in the numerical solution of SDEs.
    """

    def diffusion(t: float, x: Array) -> Array:
        return _rows(np.stack([0.0 * x[0], x[0]]))

    def derivative(t: float, x: Array, y: Array) -> Array:
        return _rows(np.stack([0.0 * y[0], y[0]]), motion=0.0)

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        return np.asarray(z + np.stack([*noise.dW, z[0] * noise.dW[1] + _integral(noise)]))

    truths = _truths(advance, mean=lambda t: 0.0, square=lambda t: 0.5 * t * t)
    return _area_equation(lambda t, x: 0.0 * x, diffusion, derivative, truths, horizon)


@on_request
def shear(horizon: float = 1.0) -> SDE:
    """Shear: dx_1 = dW_1, dx_2 = dW_2, dx_3 = x_1 o (dW_1 + dW_2) = x_1 dW_1 + x_1 dW_2 + dt/2.

    No reflection leaves the equation invariant: x_3 = W_1^2/2 + int W_1 dW_2, and an error of the area that depends
    on the sign of an increment has a nonzero mean.

    Parameters
    ----------
    horizon : float
        Final time T, in any unit: E x_3 = T/2, E x_3^2 = 5 T^2/4.

    Source
    ------
    Ito's formula.
    """

    def drift(t: float, x: Array) -> Array:
        return np.stack([0.0 * x[0], 0.0 * x[0], 0.0 * x[0] + 0.5])

    def diffusion(t: float, x: Array) -> Array:
        return _rows(np.stack([x[0], x[0]]))

    def derivative(t: float, x: Array, y: Array) -> Array:
        return _rows(np.stack([y[0], y[0]]), motion=0.0)

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        dW_1, dW_2 = noise.dW
        return np.asarray(z + np.stack([dW_1, dW_2, z[0] * (dW_1 + dW_2) + 0.5 * dW_1**2 + _integral(noise)]))

    truths = _truths(advance, mean=lambda t: 0.5 * t, square=lambda t: 1.25 * t * t)
    return _area_equation(drift, diffusion, derivative, truths, horizon)


def _rows(third: Array, motion: float = 1.0) -> Array:
    """Return a given third row below a multiple of the identity, shape (3, 2, P)."""
    nothing = 0.0 * third[0]
    one = nothing + motion
    return np.stack([np.stack([one, nothing]), np.stack([nothing, one]), third])


def _integral(noise: Increment) -> Array:
    """Return E[int W_1 dW_2 | dW, H] = dW_1 dW_2/2 + H_1 dW_2 - H_2 dW_1 over a step that begins with W = 0."""
    assert noise.H is not None
    (dW_1, dW_2), (H_1, H_2) = noise.dW, noise.H
    return np.asarray(0.5 * dW_1 * dW_2 + H_1 * dW_2 - H_2 * dW_1)


def _area_equation(
    drift: Callable[[float, Array], Array],
    diffusion: Callable[[float, Array], Array],
    derivative: Callable[[float, Array, Array], Array],
    truths: tuple[Truth, ...],
    horizon: float,
) -> SDE:
    return SDE(
        drift=drift,
        diffusion=diffusion,
        diffusion_derivative=derivative,
        start=np.zeros(3),
        noise_dim=2,
        horizon=horizon,
        observables=OBSERVABLES,
        truths=truths,
        units="x_1 and x_2 in the unit of the square root of time, x_3 in that of time",
        source=SOURCE,
    )


def _truths(
    advance: Callable[[Array, float, float, Increment], Array], **moments: Callable[[float], float]
) -> tuple[Truth, ...]:
    path = Pathwise(
        start=lambda paths: np.zeros((3, paths)),
        advance=advance,
        parts=lambda t, z: {"x": z},
        source=AREA,
        order=0.5,
    )
    named = zip(OBSERVABLES, moments.values(), strict=True)
    return (path, *(Moment(observable=name, value=value, source="Ito's isometry") for name, value in named))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register both problems."""
    return [heisenberg, shear]
