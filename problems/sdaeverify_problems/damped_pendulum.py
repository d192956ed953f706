"""The stochastic pendulum with friction in balance with its noise."""

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Increment, InvariantMean, hookimpl

from . import _circle as circle
from . import _controls as controls
from ._free_moments import damped_moments
from ._rotor import Rotor, damped

OBSERVABLES = {**circle.OBSERVABLES, "r_1^2": lambda t, s: s["r"][0] ** 2}


def damped_pendulum(
    c_g: float = 1.0, gamma: float = 1.0, kT: float = 0.5, theta_0: float = 0.5, horizon: float = 0.5
) -> HolonomicSDAE:
    """Damped pendulum: dr = v dt, dv = (-gamma v + (0, -c_g)) dt + sqrt(2 gamma kT) dw - r dmu, |r| = 1, w in R^2.

    In the angle theta from the lowest point, v = omega t(theta) and omega = 1/2 at the start,

        domega = (-c_g sin(theta) - gamma omega) dt + sqrt(2 gamma kT) <t, dw>,

    with the invariant density ~ exp((c_g cos(theta) - omega^2/2)/kT).

    Parameters
    ----------
    c_g : float
        Gravity, unit length/time^2, the length of the pendulum being 1.
    gamma : float
        Friction, unit 1/time, positive.
    kT : float
        Temperature, unit length^2/time^2, positive.
    theta_0 : float
        Initial angle, radian.
    horizon : float
        Final time.

    Source
    ------
    Lindner & Stroot (2017), sections 5.1 and 5.2, with the fluctuation-dissipation relation.
    """
    rotor, omega_0 = damped(c_g, gamma, np.sqrt(2.0 * gamma * max(kT, 0.0))), 0.5

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        return rotor.on_the_circle(z, h, noise)

    pathwise = circle.angle_truth(theta_0, omega_0, advance, "order 3/2 Ito-Taylor step of the angle form")
    return HolonomicSDAE(
        controls=controls.VANISHING,
        force=lambda t, r, v: np.array([[0.0], [-c_g]]) - gamma * v,
        diffusion=lambda t, r, v: rotor.sigma * np.eye(2)[..., None],
        constraint=circle.constraint,
        jacobian=circle.jacobian,
        curvature=circle.curvature,
        constraint_bound=circle.CONSTRAINT_BOUND,
        **circle.start(theta_0, omega_0),
        horizon=horizon,
        noise_dim=2,
        traits=frozenset({"additive-noise"}),
        observables=OBSERVABLES,
        truths=(pathwise, *limits(rotor), *(damped_moments(rotor, theta_0, omega_0) if c_g == 0.0 else ())),
        chart=circle.chart(0.0, np.sqrt(kT)),
        relaxation=rotor.relaxation,
        units="length of the pendulum 1, time in the unit of 1/gamma",
        source="Lindner & Stroot 2017, section 5.1, a = -gamma v - c_g e_2, B = sqrt(2 gamma kT) Id",
    )


def limits(rotor: Rotor) -> tuple[InvariantMean, ...]:
    """Return the means under von Mises' law of the angle and a normal law of the angular velocity."""
    cosine, square = rotor.cosines()
    means = {"r_1": 0.0, "r_2": -cosine, "r_1^2": 1.0 - square, "v_1": 0.0, "v_2": 0.0}
    means |= {"|v|^2": rotor.kT, "|v|^4": 3.0 * rotor.kT**2}
    return tuple(InvariantMean(observable=name, value=v, source="von Mises law") for name, v in means.items())


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [damped_pendulum]
