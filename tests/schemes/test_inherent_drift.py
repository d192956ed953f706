"""The drift of the inherent SDE with its minus sign, (2.8)-(2.9): values by hand, and steps that do not project.

A term along M^{-1} grad g does no work and is taken out by every projection: only the multiplier and steps without
projection show its sign.
"""

import numpy as np
import pytest

from facade import _unit_sphere as unit_sphere
from sdaeverify import Array, HolonomicSDAE

EPS = np.finfo(float).eps


def free(
    r: list[float], v: list[float], mass: list[float] | None = None, force: Array | None = None
) -> HolonomicSDAE:
    """Return a point on the unit sphere under a constant force."""
    n = len(r)
    a = np.zeros((n, 1)) if force is None else force[:, None]
    return HolonomicSDAE(
        force=lambda t, x, y: a,
        diffusion=lambda t, x, y: np.eye(n)[..., None],
        constraint=unit_sphere.constraint,
        jacobian=unit_sphere.jacobian,
        curvature=unit_sphere.curvature,
        position=r,
        velocity=v,
        mass=None if mass is None else np.diag(mass),
        horizon=1.0,
        noise_dim=n,
        source="made up",
    )


CIRCLE = free([0.0, -1.0], [3.0, 0.0])
SPHERE = free([1.0, 0.0, 0.0], [0.0, 2.0, 0.0])
ALONG_AXIS = free([1.0, 0.0], [0.0, 3.0], mass=[2.0, 1.0])
ASLANT = free([0.6, 0.8], [-0.8, 0.6], mass=[2.0, 1.0])
PULLED = free([0.6, 0.8], [-0.8, 0.6], mass=[2.0, 1.0], force=np.array([0.0, -4.1]))
# By hand: the acceleration and the rate of mu. A free point of unit mass is pulled towards the centre by |v|^2.
# Aslant <r, M^{-1} r> = 0.82, the pull is along M^{-1} r = (0.3, 0.8), and the force adds (1.2, -0.9) and -4 to mu.
BY_HAND: dict[str, tuple[HolonomicSDAE, list[float], float]] = {
    "circle": (CIRCLE, [0.0, 9.0], 9.0),
    "sphere": (SPHERE, [-4.0, 0.0, 0.0], 4.0),
    "masses, along an axis": (ALONG_AXIS, [-9.0, 0.0], 18.0),
    "masses, aslant": (ASLANT, [-15 / 41, -40 / 41], 50 / 41),
    "masses and a force": (PULLED, [-15 / 41 + 1.2, -40 / 41 - 0.9], 50 / 41 - 4.0),
}


@pytest.mark.parametrize("name", BY_HAND)
def test_acceleration_and_multiplier_are_those_by_hand(name: str) -> None:
    """The drift of v and of mu at one state, the latter with the minus sign of (2.8)."""
    problem, acceleration, rate = BY_HAND[name]
    r, v, _ = problem.initial(1)
    n = len(r)

    drift = problem.ito().drift(0.0, np.concatenate(problem.initial(1)))[:, 0]
    multiplier = problem.inherent_multiplier(problem.linearised(r), r, v, problem.force(0.0, r, v))[0, 0]

    assert drift[:n] == pytest.approx(v[:, 0], rel=1e-15)
    assert drift[n : 2 * n] == pytest.approx(acceleration, abs=16 * EPS * 9.0)
    assert drift[2 * n] == pytest.approx(rate, abs=16 * EPS * 18.0)
    assert multiplier == pytest.approx(rate, abs=16 * EPS * 18.0)
