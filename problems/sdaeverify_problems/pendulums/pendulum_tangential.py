"""The free pendulum with tangential noise, whose solution is a function of W and its time integral."""

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Increment, Moment, hookimpl

from .. import _controls as controls
from ..curves import _circle as circle
from ._free_moments import free_moments


def pendulum_tangential(theta_0: float = 0.5, omega_0: float = 0.5, horizon: float = 0.5) -> HolonomicSDAE:
    """Free pendulum with tangential noise: dr = v dt, dv = J r dW - r dmu, (1 - |r|^2)/2 = 0, W in R.

    J = [[0, -1], [1, 0]]. On the circle J r = t, so that, exactly on any grid,

        omega = omega_0 + W(t),   theta = theta_0 + omega_0 t + int_0^t W ds,   dmu = omega^2 dt.

    (r, v) has the law of the pendulum with c_g = 0. mu is computed to order 3/2, from the expectation of int W^2 ds
    given dW and H on the reference grid.

    Parameters
    ----------
    theta_0 : float
        Initial angle from the lowest point, radian.
    omega_0 : float
        Initial angular velocity, unit 1/time.
    horizon : float
        Final time.

    Source
    ------
    Lindner & Stroot (2017), section 5.1, with B(r) = J r in place of B = Id.
    """

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        theta, omega, mu = z
        integral = noise.time_integral(h)[0]
        square = omega**2 * h + 2.0 * omega * integral + circle.square_integral(h, noise)[0]
        return np.stack([theta + omega * h + integral, omega + noise.dW[0], mu + square])

    energy = Moment(
        observable="energy", value=lambda t: 0.5 * omega_0**2 + 0.5 * t, source="Ito's formula for the energy"
    )
    truth = circle.angle_truth(theta_0, omega_0, advance, "exact for r and v, order 3/2 for mu")
    return HolonomicSDAE(
        controls=controls.VANISHING_SCALAR,
        force=lambda t, r, v: np.zeros((2, 1)),
        diffusion=lambda t, r, v: np.stack([-r[1], r[0]])[:, None],
        **circle.MECHANICS,
        **circle.start(theta_0, omega_0),
        horizon=horizon,
        noise_dim=1,
        traits=frozenset({"vanishing-milstein-term"}),
        observables={**circle.OBSERVABLES, "energy": lambda t, s: 0.5 * (s["v"] ** 2).sum(axis=0)},
        truths=(truth, energy, *free_moments(theta_0, omega_0, 0.0)),
        # omega - omega_0 is Brownian motion.
        chart=circle.chart(omega_0, np.sqrt(horizon)),
        units="length of the pendulum 1, time so that the noise has unit strength",
        source="Lindner & Stroot 2017, section 5.1, B(r) = J r",
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [pendulum_tangential]
