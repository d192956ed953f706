"""The stochastic pendulum with friction and noise related by the fluctuation-dissipation theorem."""

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Increment, Truth, hookimpl

from .. import _controls as controls
from .._arguments import check_positive
from .._inherent_truth import with_inherent_truth
from ..curves import _circle as circle
from ..langevin._bath import Bath
from ..langevin._canonical_law import Canonical, circle_nodes, invariant_means
from ..langevin._constrained_langevin import constrained_langevin
from ..spheres._unit_sphere import constraint_bound
from ._free_moments import damped_moments
from ._rotor import Rotor, damped_rotor

OBSERVABLES = {**circle.OBSERVABLES, "r_1^2": lambda t, s: s["r"][0] ** 2}
OMEGA_0 = 0.5


def damped_pendulum(
    c_g: float = 1.0,
    gamma: float = 1.0,
    kT: float = 0.5,
    theta_0: float = 0.5,
    horizon: float = 0.5,
    mass: float = 1.0,
) -> HolonomicSDAE:
    """Damped pendulum: dr = v dt, M dv = (-gamma v + (0, -c_g)) dt + sqrt(2 gamma kT) dw - r dmu, |r| = 1, w in R^2.

    M = diag(1, mass). In the angle theta from the lowest point, v = omega t(theta) and omega = 1/2 at the start,

        <t, M t> domega = (omega^2 <t, M r> - c_g sin(theta) - gamma omega) dt + sqrt(2 gamma kT) <t, dw>,

    with the invariant density ~ <t, M t> exp((c_g cos(theta) - omega^2 <t, M t>/2)/kT).

    Parameters
    ----------
    c_g : float
        Gravity, unit length/time^2; the length of the pendulum and the mass of the horizontal motion are 1.
    gamma : float
        Friction, unit 1/time, positive.
    kT : float
        Temperature, unit length^2/time^2, positive.
    theta_0 : float
        Initial angle, radian.
    horizon : float
        Final time.
    mass : float
        Mass of the vertical motion, positive, in units of the mass of the horizontal motion.

    Source
    ------
    Lindner & Stroot (2017), sections 5.1 and 5.2, with the fluctuation-dissipation relation.
    """
    rotor, M = damped_rotor(c_g, gamma, np.sqrt(2.0 * gamma * max(kT, 0.0))), np.diag([1.0, mass])
    check_positive(mass=mass)
    law, weight = Canonical(lambda x: c_g * x[1], M, kT), np.array([[0.0], [c_g]])
    stiffness, drag = np.zeros((2, 2, 1)), gamma * np.eye(2)[..., None]
    problem = constrained_langevin(
        lambda r: weight,
        Bath(friction=gamma, kT=kT),
        force_derivatives=lambda t, r, v: (stiffness, -drag),
        controls=controls.VANISHING_SEVERAL,
        constraint=circle.constraint,
        jacobian=circle.jacobian,
        curvature=circle.curvature,
        constraint_bound=constraint_bound(M),
        mass=None if mass == 1.0 else M,
        **circle.start(theta_0, OMEGA_0),
        horizon=horizon,
        observables=OBSERVABLES,
        truths=(
            *(by_angle(rotor, theta_0) if mass == 1.0 else ()),
            *invariant_means(law, circle_nodes, OBSERVABLES),
        ),
        # The law of omega is widest at the angle with the smallest <t, M t>.
        chart=circle.chart(0.0, np.sqrt(kT / min(1.0, mass))),
        relaxation_time=rotor.relaxation + 2.0 * (max(1.0, mass) - 1.0) / gamma,
        units="length of the pendulum 1, time in the unit of 1/gamma",
        source="Lindner & Stroot 2017, section 5.1, a = -gamma v - c_g e_2, B = sqrt(2 gamma kT) Id",
    )
    return problem if mass == 1.0 else with_inherent_truth(problem)


def by_angle(rotor: Rotor, theta_0: float) -> tuple[Truth, ...]:
    """Return the truths from the angle form if M = Id: the solution, and its moments without gravity."""

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        return rotor.on_the_circle(z, h, noise)

    pathwise = circle.angle_truth(theta_0, OMEGA_0, advance, "order 3/2 Ito-Taylor step of the angle form")
    return (pathwise, *(damped_moments(rotor, theta_0, OMEGA_0) if rotor.c == 0.0 else ()))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [damped_pendulum]
