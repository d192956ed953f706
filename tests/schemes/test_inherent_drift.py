"""The drift of the inherent SDE with its minus sign, (2.8)-(2.9): values by hand, and steps that do not project.

A term along M^{-1} grad g does no work and is taken out by every projection: only the multiplier and steps without
projection show its sign.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sdaeverify import SDE, HolonomicSDAE, Increment
from sdaeverify.arrays import Array
from sdaeverify_problems import _unit_sphere as unit_sphere
from sdaeverify_schemes.euler_maruyama import DriftTruncatedEuler, EulerMaruyama

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


def equation(problem: HolonomicSDAE) -> SDE:
    view = problem.view(SDE)
    assert isinstance(view, SDE)
    return view


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


def with_plus(problem: HolonomicSDAE) -> SDE:
    """Return the inherent SDE with + grad g G_M^{-1} D^2 g(v, v), as it is printed at one place."""
    right, n = equation(problem), problem.dimension

    def drift(t: float, x: Array) -> Array:
        r, v = x[:n], x[n:]
        J = problem.linearised(r)
        turning = problem.push(J, problem.inherent_multiplier(J, r, v, 0.0 * v))
        return right.drift(t, x) - 2.0 * np.concatenate([0.0 * r, turning])

    return replace(right, drift=drift)


def step(view: SDE, x: Array, h: float) -> Array:
    """Make one Euler step without noise."""
    still = Increment(np.zeros((view.noise_dim, x.shape[1])), None)
    return np.asarray(EulerMaruyama().step(view, x, 0.0, h, still).state)


@pytest.mark.parametrize("problem", [CIRCLE, SPHERE], ids=["circle", "sphere"])
@pytest.mark.parametrize("h", [0.1, 1e-3])
def test_an_unprojected_step_turns_the_velocity(problem: HolonomicSDAE, h: float) -> None:
    """After one step <r, v> = 0 and after two g = -h^2 |v|^2 - h^4 |v|^4/2; with a plus sign both are off.

    One step leads to r + h v and v - h |v|^2 r, which are orthogonal, and two to (1 - h^2 |v|^2) r + 2 h v. With the
    plus sign <r, v> = 2 h |v|^2 and g = -3 h^2 |v|^2 - h^4 |v|^4/2.
    """
    n, size = problem.dimension, float(np.sum(np.square(problem.velocity)))
    found = {}
    for name, view in (("right", equation(problem)), ("wrong", with_plus(problem))):
        once = step(view, np.concatenate(problem.initial(1)[:2]), h)
        twice = step(view, once, h)
        found[name] = float((once[:n] * once[n:]).sum()), float(problem.constraint(twice[:n])[0, 0])

    error = 16 * EPS
    assert found["right"] == pytest.approx((0.0, -(h**2) * size - 0.5 * h**4 * size**2), abs=error)
    assert found["wrong"] == pytest.approx((2.0 * h * size, -3.0 * h**2 * size - 0.5 * h**4 * size**2), abs=error)


def hidden(problem: HolonomicSDAE, view: SDE, x: Array, h: float) -> float:
    """Return the largest |Dg(r) v| after one step."""
    n = problem.dimension
    new = step(view, x, h)
    return float(np.abs(problem.linearised(new[:n]).times(new[n:])).max())


def test_the_hidden_constraint_is_left_at_order_two(body: Any) -> None:
    """With masses and several constraints one step moves Dg v by O(h^2), with a plus sign by O(h).

    The next term of either expansion changes an exponent between h = 2^-9 and 2^-11 by about |next/leading| h.
    """
    problem, x = body.problem, np.concatenate(body.state[:2])

    def exponent(view: SDE) -> float:
        coarse, fine = (hidden(problem, view, x, 2.0**-k) for k in (9, 11))
        return 0.5 * float(np.log2(coarse / fine))

    assert exponent(equation(problem)) == pytest.approx(2.0, abs=0.05)
    assert exponent(with_plus(problem)) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("h", [0.01, 0.5])
def test_the_truncated_step_uses_the_same_drift(h: float) -> None:
    """One step of the drift-truncated scheme is min(h, 1/|drift|) times the drift by hand, Remark 3.3."""
    x = np.concatenate(ASLANT.initial(1)[:2])
    drift = np.array([-0.8, 0.6, -15 / 41, -40 / 41])

    new = DriftTruncatedEuler().step(equation(ASLANT), x, 0.0, h, Increment(np.zeros((2, 1)), None)).state

    eta = min(1.0, 1.0 / (h * np.linalg.norm(drift)))
    assert new[:, 0] == pytest.approx(x[:, 0] + eta * h * drift, abs=16 * EPS)
