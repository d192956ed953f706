"""Roots of one step on a wide range of step sizes: found where the closed form has them, missed where it has none."""

import numpy as np
import pytest

from facade import HalfExplicitEuler, pendulum, pendulum_velocity_noise, where_no_root
from sdaeverify import HolonomicSDAE, HolonomicState, Increment, Step
from sdaeverify.numerics import norm
from sdaeverify_measures.solvability.root_scan import SCANNED, root_scan


@pytest.mark.parametrize("problem", [pendulum(), pendulum_velocity_noise()])
def test_truncation_leaves_a_root_at_every_step_size(problem: HolonomicSDAE) -> None:
    """With C_eta = 1/(4 C_g^3) no step fails, from 1e-6 to 1e3 and for velocities up to 1e8."""
    scan = root_scan(HalfExplicitEuler(), problem)

    assert (scan.h[0], scan.h[-1]) == pytest.approx((1e-6, 1e3))
    assert norm(scan.x[2:4]).max() == pytest.approx(1e8)
    assert not scan.failed.any()
    assert where_no_root(problem, scan) == ""


def test_without_truncation_there_is_a_root_where_the_closed_form_has_one() -> None:
    """On the circle there is a root if and only if |v| h <= 1."""
    scan = root_scan(HalfExplicitEuler(truncation="none"), pendulum())
    reach = norm(scan.x[2:4])[:, None] * scan.h

    clear = np.abs(reach - 1.0) > 1e-6
    assert np.array_equal(scan.failed[clear] > 0.0, reach[clear] > 1.0)
    assert "no root at 19 of 19 step sizes, the smallest h = 1e-06 where |r| = 1, |v| =" in where_no_root(
        pendulum(), scan
    )


def test_a_truncation_that_is_too_weak_fails_somewhere() -> None:
    """C_eta = 2 on the circle: no root where 1 < |v| < 2 at coarse steps, and nowhere else."""
    scan = root_scan(HalfExplicitEuler(truncation=2.0), pendulum())

    assert scan.failed.any()
    assert scan.h[scan.failed.any(axis=0)].min() > 0.1


class Overflowing(HalfExplicitEuler):
    """The scheme whose velocity overflows at long steps."""

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result = super().step(problem, state, t, h, noise)
        return result._replace(state=result.state._replace(v=result.state.v * np.exp(h)))


def test_states_that_are_not_finite_are_told() -> None:
    """A step that overflows at h = 1000 has a root and is shown nevertheless."""
    scan = root_scan(Overflowing(), pendulum())

    assert len(SCANNED) == 19
    assert where_no_root(pendulum(), scan).startswith("not finite at 1 of 19 step sizes, the smallest h = 1e+03")
