"""The stochastic pendulum: the unit circle, gravity and isotropic noise."""

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Increment, Moment, hookimpl

from .. import _controls as controls
from ..curves import _circle as circle
from ._free_moments import free_moments
from ._rotor import Rotor

SHEET = "Lindner & Stroot 2017, section 5.1"


def pendulum(c_g: float = 1.0, theta_0: float = 0.5, omega_0: float = 0.5, horizon: float = 0.5) -> HolonomicSDAE:
    """Pendulum: dr = v dt, dv = (0, -c_g) dt + dw - r dmu, (1 - |r|^2)/2 = 0, w in R^2.

    With r = (sin theta, -cos theta), t = (cos theta, sin theta) and v = omega t,

        dtheta = omega dt,  domega = -c_g sin(theta) dt + <t, dw>,  dmu = (c_g cos(theta) + omega^2) dt + <r, dw>.

    Parameters
    ----------
    c_g : float
        Gravity, unit length/time^2; the length of the pendulum is 1.
    theta_0 : float
        Initial angle from the lowest point, radian.
    omega_0 : float
        Initial angular velocity, unit 1/time.
    horizon : float
        Final time.

    Source
    ------
    Lindner & Stroot (2017), section 5.1, (5.77).
    """
    rotor, weight, unit = Rotor(c_g, 0.0, 1.0), np.array([[0.0], [-c_g]]), np.eye(2)[..., None]

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        return rotor.on_the_circle(z, h, noise)

    def energy(t: float, s: dict[str, Array]) -> Array:
        return 0.5 * (s["v"] ** 2).sum(axis=0) + c_g * s["r"][1]

    H_0 = 0.5 * omega_0**2 - c_g * np.cos(theta_0)
    balance = Moment(observable="energy", value=lambda t: H_0 + 0.5 * t, source="Ito's formula for the energy")
    pathwise = circle.angle_truth(theta_0, omega_0, advance, "order 3/2 Ito-Taylor step of the angle form")
    return HolonomicSDAE(
        controls=controls.VANISHING_SEVERAL,
        force=lambda t, r, v: weight,
        diffusion=lambda t, r, v: unit,
        diffusion_product=lambda t, r, v, w: w,
        **circle.MECHANICS,
        **circle.start(theta_0, omega_0),
        horizon=horizon,
        noise_dim=2,
        traits=frozenset({"additive-noise"}),
        observables={**circle.OBSERVABLES, "energy": energy},
        truths=(pathwise, balance, *(free_moments(theta_0, omega_0, 1.0) if c_g == 0.0 else ())),
        # Without gravity, omega - omega_0 is Brownian motion.
        chart=circle.chart(omega_0, np.sqrt(horizon)),
        units="length of the pendulum 1, time so that the noise has unit strength",
        source=SHEET,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [pendulum]
