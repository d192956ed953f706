"""A point with weight on the sphere, with friction, balanced noise, and one mass for each direction."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Moment, Parts, hookimpl, in_matrix

from .. import _controls as controls
from .. import _known as known
from .._arguments import check_positive
from .._brief import BRIEF, PROJECTED
from .._inherent_truth import with_inherent_truth
from ..langevin._bath import Bath
from ..langevin._canonical_law import Canonical, invariant_means, sphere_nodes
from ..langevin._constrained_langevin import constrained_langevin
from . import _unit_sphere as unit_sphere

LATITUDE = -0.6
START = np.array([np.cos(LATITUDE), 0.0, np.sin(LATITUDE)])
VELOCITY = np.array([-0.4 * np.sin(LATITUDE), 0.5, 0.4 * np.cos(LATITUDE)])
MOMENTUM = np.cross(START, VELOCITY)
HORIZON = 0.5


@in_matrix({"m_2": 2.0, "m_3": 4.0}, schemes=PROJECTED, measures=BRIEF)
def sphere_langevin(
    c_g: float = 1.0, gamma: float = 1.0, kT: float = 0.1, m_1: float = 1.0, m_2: float = 1.0, m_3: float = 1.0
) -> HolonomicSDAE:
    """Langevin dynamics on S^2: dr = v dt, M dv = (-gamma v - c_g e_3) dt + sqrt(2 gamma kT) dw - r dmu, |r| = 1.

    M = diag(m_1, m_2, m_3) and w in R^3. The invariant law has the density exp(-c_g r_3/kT) sqrt(r^T M^{-1} r) on the
    sphere, with v normal given r. With L = r x v, E L_3 = exp(-gamma t/m) L_3(0) if m_1 = m_2 = m. If also m_3 = m,
    and without gravity,

        E L = exp(-gamma t/m) L(0),   E |v|^2 = exp(-2 gamma t/m) |v(0)|^2 + 2 (kT/m) (1 - exp(-2 gamma t/m)).

    Parameters
    ----------
    c_g : float
        Gravitational force, unit mass length/time^2; the radius of the sphere is 1.
    gamma : float
        Friction, unit mass/time, positive.
    kT : float
        Temperature, unit mass length^2/time^2, positive.
    m_1 : float
        Mass of the first horizontal direction, positive.
    m_2 : float
        Mass of the second horizontal direction, positive.
    m_3 : float
        Mass of the vertical direction, positive.

    Source
    ------
    Lindner & Stroot (2017), section 5.2, on the sphere.
    """
    masses = np.array([m_1, m_2, m_3])
    check_positive(m_1=m_1, m_2=m_2, m_3=m_3)
    M, weight, observables = np.diag(masses), c_g * np.array([[0.0], [0.0], [1.0]]), observables_of(masses)
    law = Canonical(lambda x: c_g * x[2], M, kT)
    problem = constrained_langevin(
        lambda r: weight,
        Bath(friction=gamma, kT=kT),
        controls=controls.VANISHING_SEVERAL,
        constraint=unit_sphere.constraint,
        jacobian=unit_sphere.jacobian,
        curvature=unit_sphere.curvature,
        constraint_bound=unit_sphere.constraint_bound(M),
        mass=None if np.all(masses == 1.0) else M,
        position=START,
        velocity=VELOCITY,
        horizon=HORIZON,
        observables=observables,
        truths=(*moments(masses, c_g, gamma, kT), *invariant_means(law, sphere_nodes, observables)),
        relaxation_time=2.0 * masses.max() / gamma + gamma / max(abs(c_g), 2.0 * kT),
        units="radius of the sphere 1, mass and time in the units of the masses and of gamma",
        source="Lindner & Stroot 2017, section 5.2, on the unit sphere of R^3",
    )
    return with_inherent_truth(problem)


def observables_of(masses: Array) -> dict[str, object]:
    """Return the observables, with the kinetic energy of the given masses."""

    def momentum(row: int, s: Parts) -> Array:
        return np.asarray(np.cross(s["r"], s["v"], axis=0)[row])

    return {
        **known.monomials("r_1", "r_2", "r_3", "r_1^2", "r_3^2"),
        "|v|^2": lambda t, s: (s["v"] ** 2).sum(axis=0),
        "v^T M v": lambda t, s: masses @ s["v"] ** 2,
        **{f"(r x v)_{i + 1}": lambda t, s, i=i: momentum(i, s) for i in (0, 2)},
    }


def moments(masses: Array, c_g: float, gamma: float, kT: float) -> tuple[Moment, ...]:
    """Return the expectations that satisfy closed equations, which requires equal masses.

    Parameters
    ----------
    masses : ndarray, shape (3,)
        Masses of the coordinates.
    c_g : float
        Weight, a force in direction -e_3.
    gamma : float
        Friction.
    kT : float
        Temperature in units of energy.
    """
    m, start = float(masses[0]), float(VELOCITY @ VELOCITY)
    alike, all_alike = masses[1] == m, bool(np.all(masses == m)) and c_g == 0.0

    def decay(value: float, rate: float) -> Callable[[float], float]:
        return lambda t: float(value * np.exp(-rate * t))

    def speed(t: float) -> float:
        return start + (start - 2.0 * kT / m) * float(np.expm1(-2.0 * gamma / m * t))

    values = {"(r x v)_3": decay(MOMENTUM[2], gamma / m)} if alike else {}
    if all_alike:
        values |= {"(r x v)_1": decay(MOMENTUM[0], gamma / m), "|v|^2": speed, "v^T M v": lambda t: m * speed(t)}
    return known.moments(values, "Ito's formula for r x v and |v|^2")


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [sphere_langevin]
