"""The orders that schemes claim are those of their one-step maps: each scheme where it is sharp."""

from collections.abc import Callable

import numpy as np
import pytest

from schemes.local_order import strong_order
from sdaeverify.contracts.scheme import Scheme
from sdaeverify.forms import SDE, Problem
from sdaeverify.probe.local.weak_defects import local_weak
from sdaeverify.probe.local.weak_order import weak_order
from sdaeverify.verdicts.coverage import claim_for
from sdaeverify_problems.angle_pendulum import angle_pendulum
from sdaeverify_problems.circle import circle
from sdaeverify_problems.damped_pendulum import damped_pendulum
from sdaeverify_problems.double_well import double_well
from sdaeverify_problems.ellipse import ellipse
from sdaeverify_problems.gbm import gbm, linear_test
from sdaeverify_problems.growing_volatility import growing_volatility
from sdaeverify_problems.hyperbolic import hyperbolic
from sdaeverify_problems.noncommuting import noncommuting
from sdaeverify_problems.ou import ou
from sdaeverify_problems.pendulum_velocity_noise import pendulum_velocity_noise
from sdaeverify_problems.sphere import sphere
from sdaeverify_problems.spiral import spiral
from sdaeverify_schemes.balanced_euler import BalancedEuler
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.euler_maruyama import DriftTruncatedEuler, EulerMaruyama, TamedEuler
from sdaeverify_schemes.half_explicit_euler import HalfExplicitEuler
from sdaeverify_schemes.heun import Heun, HeunAdditive
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from sdaeverify_schemes.projected_euler import ProjectedEuler
from sdaeverify_schemes.sra1 import SRA1
from sdaeverify_schemes.sri1w1 import SRI1W1
from sdaeverify_schemes.stochastic_theta import StochasticTheta

Family = Callable[[], Problem]
STRONG: list[tuple[Scheme, Family, float]] = [
    (BalancedEuler(), gbm, 0.5),
    (BalancedEuler(), ou, 0.5),
    (BAOAB(), angle_pendulum, 1.0),
    (DriftTruncatedEuler(), double_well, 1.0),
    (EulerMaruyama(), gbm, 0.5),
    (EulerMaruyama(), circle, 0.5),
    (EulerMaruyama(), angle_pendulum, 1.0),
    (HalfExplicitEuler(), pendulum_velocity_noise, 0.5),
    (HalfExplicitEuler(), damped_pendulum, 1.0),
    (Heun(), gbm, 1.0),
    (Heun(), circle, 1.0),
    (Heun(), pendulum_velocity_noise, 1.0),
    (Heun(), noncommuting, 0.5),
    (HeunAdditive(), double_well, 1.0),
    (Milstein(), ellipse, 1.0),
    (ProjectedEuler(), circle, 1.0),
    (ProjectedEuler(), ellipse, 1.0),
    (ProjectedEuler(), sphere, 0.5),
    (SRA1(), double_well, 1.5),
    (SRI1W1(), hyperbolic, 1.5),
    (SRI1W1(), spiral, 1.5),
    (SRI1W1(), growing_volatility, 1.5),
    (StochasticTheta(), linear_test, 0.5),
    (StochasticTheta(), double_well, 1.0),
    (TamedEuler(), double_well, 1.0),
    (TamedEuler(), noncommuting, 0.5),
]
WEAK: list[tuple[Scheme, Family, float]] = [
    (BalancedEuler(), linear_test, 0.5),
    (BAOAB(), angle_pendulum, 2.0),
    (DriftTruncatedEuler(), double_well, 1.0),
    (EulerMaruyama(), gbm, 1.0),
    (EulerMaruyama(), noncommuting, 1.0),
    (HalfExplicitEuler(), damped_pendulum, 1.0),
    (HalfExplicitEuler(), pendulum_velocity_noise, 1.0),
    (Heun(), ellipse, 1.0),
    (Heun(), noncommuting, 1.0),
    (Heun(), double_well, 2.0),
    (HeunAdditive(), double_well, 2.0),
    (Milstein(), gbm, 1.0),
    (PlatenWeak2(), gbm, 2.0),
    (PlatenWeak2(), ellipse, 2.0),
    (PlatenWeak2General(), noncommuting, 2.0),
    (PlatenWeak2(), pendulum_velocity_noise, 2.0),
    (ProjectedEuler(), circle, 1.0),
    (ProjectedEuler(), ellipse, 1.0),
    (ProjectedEuler(), sphere, 1.0),
    (SRA1(), double_well, 2.0),
    (StochasticTheta(), gbm, 1.0),
    (StochasticTheta(), double_well, 2.0),
    (StochasticTheta(0.7), double_well, 1.0),
    (TamedEuler(), double_well, 1.0),
]


def named(case: tuple[Scheme, Family, float]) -> str:
    return f"{case[0].label} on {case[1].__name__}"


def seen(scheme: Scheme, family: Family) -> Problem:
    view = family().view(scheme.form)
    assert view is not None
    assert not scheme.refuses(view)
    return view


@pytest.mark.parametrize(("scheme", "family", "order"), STRONG, ids=map(named, STRONG))
def test_strong_orders_are_those_claimed(scheme: Scheme, family: Family, order: float) -> None:
    """A step, two half steps and Euler's agree to the claimed order and no better.

    The smallest step is 4^-7: half powers of h beside the leading one leave up to 0.06 of the order there.
    """
    view = seen(scheme, family)
    found = strong_order(scheme, view)
    claim = claim_for(scheme, view.traits, "strong", "x").claim

    assert found.consistent
    assert found.order == pytest.approx(order, abs=0.06)
    assert claim is not None
    assert claim.value.least == order


@pytest.mark.parametrize(("scheme", "family", "order"), WEAK, ids=map(named, WEAK))
def test_weak_orders_are_those_claimed(scheme: Scheme, family: Family, order: float) -> None:
    """Expectations after one step agree with the equation's to the claimed order and no better."""
    view = seen(scheme, family)
    found = weak_order(local_weak(scheme, view))
    claim = claim_for(scheme, view.traits, "weak", "x").claim

    assert np.min(found.orders, where=found.settled, initial=np.inf) == pytest.approx(order, abs=0.07)
    assert claim is not None
    assert claim.value.least == order


def test_roessler_s_scheme_is_better_where_noise_enters_velocities_only() -> None:
    """On second-order systems SRA1 is of strong order 2, which is not claimed."""
    view = angle_pendulum().view(SDE)

    assert strong_order(SRA1(), view).order == pytest.approx(2.0, abs=0.03)
    claim = claim_for(SRA1(), view.traits, "strong", "q").claim
    assert claim is not None
    assert claim.value.least == 1.5
