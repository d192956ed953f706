"""Rounding that a step makes itself: differences of positions divided by h, a solver that stops at a tolerance."""

from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest

from facade import judge_weak, local_weak, sphere_langevin, weak_order, weak_reference
from sdaeverify import Array, Claim, HolonomicSDAE, HolonomicState, Scheme, Step
from sdaeverify.measuring import Verdict

ORDER = 1.0


def onto_sphere(r: Array, y: Array, tolerance: float) -> tuple[Array, Array]:
    """Return y + lambda r on the unit sphere and lambda, by Newton's method until (|x|^2 - 1)/2 is small enough."""
    factor = np.zeros(y.shape[1])
    for _ in range(50):
        x = y + factor * r
        g = 0.5 * ((x * x).sum(axis=0) - 1.0)
        left = np.abs(g) > tolerance
        factor = np.where(left, factor - g / (x * r).sum(axis=0), factor)
        if not left.any():
            break
    return y + factor * r, factor


class SphereShake(Scheme):
    """SHAKE on the unit sphere, velocities being differences of positions divided by h; part of the impulse."""

    name: ClassVar[str] = "sphere-shake"
    form: ClassVar[type] = HolonomicSDAE
    source: ClassVar[str] = "test"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=ORDER, source="test"),)

    part, tolerance = 1.0, 1e-14

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Any) -> Step:
        """Make one step."""
        r, v, mu = state
        w = v + self.part * (h * problem.force(t, r, v) + problem.diffused(t, r, v, noise.dW))
        new, factor = onto_sphere(r, r + h * w, self.tolerance)
        w = (new - r) / h
        c = -(w * new).sum(axis=0) / (new * new).sum(axis=0)
        return Step(HolonomicState(new, w + c * new, mu - factor / h - c))


PROBLEM, REFERENCE = sphere_langevin(kT=1.0), cache(weak_reference)


def opinion(claim, **changed):
    """Return what one step says of a claimed weak order on the sphere."""
    scheme = type("Changed", (SphereShake,), changed)()
    return judge_weak(weak_order(local_weak(scheme, PROBLEM, REFERENCE)), claim)


@pytest.mark.sweep
@pytest.mark.parametrize("tolerance", [0.0, 1e-14, 1e-13, 1e-12])
def test_the_error_of_a_solver_is_no_order(tolerance):
    """It was left open: "weak order 0.41 from one step, of E[x3 x7] at 1 of 19 probed states"."""
    assert opinion(ORDER, tolerance=tolerance).verdict is Verdict.VERIFIED


@pytest.mark.sweep
@pytest.mark.parametrize("tolerance", [0.0, 1e-14, 1e-12])
def test_an_order_less_by_one_is_refuted_with_the_same_solver(tolerance):
    """Order 1 is claimed of a step with 0.99 of its impulse, and order 2 of the right one."""
    assert opinion(ORDER, tolerance=tolerance, part=0.99).verdict is Verdict.REFUTED
    assert opinion(ORDER + 1.0, tolerance=tolerance).verdict is Verdict.REFUTED


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_a_crude_tolerance_does_not_make_a_step_exact(tolerance):
    """Errors of the solver hide what the step is off by: a high order is not verified."""
    assert opinion(ORDER + 1.0, tolerance=tolerance).verdict is not Verdict.VERIFIED
