"""Mean-square distances of linear pairs: closed sums, and what has none."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import UniformlyAccurate, exponential_strip
from sdaeverify import SDE, ConstrainedLangevin, Scheme, Step
from sdaeverify.probe.linear.pair import affine_step
from sdaeverify.probing import OneStep, mean_square_distance, why_not_linear_pair

KAPPA, SIGMA, START, T = 1.3, 0.7, 0.8, 0.5


def axes(eps):
    """Return the problem zeta = x_1, f = -kappa x, whose two components have nothing to do with each other."""
    return ConstrainedLangevin(
        drift=lambda x: -KAPPA * x,
        strength=SIGMA,
        eps=eps,
        constraint=lambda x: x[:1],
        hessians=np.zeros((1, 2, 2)),
        start=[0.0, START],
        horizon=T,
        source="test",
    )


def component(rate, step, start, h, count):
    """Return E D^2 of dx = -rate x dt + sigma dW and y+ = m y + n xi, summed step by step."""
    (m, n), decay = step, np.exp(-rate * h)
    shared = SIGMA * -np.expm1(-rate * h) / rate / np.sqrt(h)
    rest = SIGMA**2 * -np.expm1(-2.0 * rate * h) / (2.0 * rate) - shared**2
    j = np.arange(count)
    squares = (m**j * n - decay**j * shared) ** 2 + decay ** (2 * j) * rest
    return squares.sum() + start**2 * (m**count - decay**count) ** 2


@pytest.mark.sweep
@pytest.mark.parametrize("eps", [1e-6, 1e-3, 0.05, 10.0])
@pytest.mark.parametrize("count", [8, 24, 512])
def test_distance_is_the_closed_sum(eps, count):
    """E |Y - X|^2 of the uniformly accurate step is a sum over both components, for any penalty."""
    h = T / count
    e, slow = np.exp(-h / eps), eps * -np.expm1(-h / eps)
    root = SIGMA * np.sqrt(-0.5 * eps * np.expm1(-2.0 * h / eps))
    expected = component(KAPPA + 1.0 / eps, (e - KAPPA * slow, root), 0.0, h, count)
    expected += component(KAPPA, (1.0 - KAPPA * h, SIGMA * np.sqrt(h)), START, h, count)

    found, off = mean_square_distance(OneStep(UniformlyAccurate(), axes(eps)), h, count)

    assert abs(found - expected) <= off
    assert off < 1e-7


def test_the_step_is_read_off():
    """M, r and N of the uniformly accurate step are those of the sheet's table."""
    eps, h = 0.05, 0.02
    step = affine_step(OneStep(UniformlyAccurate(), axes(eps)), h)
    slow = eps * -np.expm1(-h / eps)

    np.testing.assert_allclose(step.M, np.diag([np.exp(-h / eps) - KAPPA * slow, 1.0 - KAPPA * h]), atol=1e-13)
    np.testing.assert_allclose(step.r, 0.0, atol=1e-13)
    normal = np.sqrt(-0.5 * eps * np.expm1(-2.0 * h / eps))
    np.testing.assert_allclose(step.N, SIGMA * np.diag([normal, np.sqrt(h)]), atol=1e-13)
    assert step.defect < 1e-10


@dataclass(frozen=True)
class Curved(Scheme):
    """Euler's step with a power of the noise, or with noise that depends on the state."""

    turned: bool = False

    name: ClassVar[str] = "curved"
    form: ClassVar[type[SDE]] = SDE

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        more = state * noise.dW if self.turned else 0.01 * noise.dW**2
        return Step(state + h * problem.drift(t, state) + SIGMA * noise.dW + more)


@pytest.mark.parametrize("turned", [True, False])
def test_steps_that_are_not_affine_have_no_bound(turned):
    """A square of the noise and a product of state and noise are both noticed."""
    one_step = OneStep(Curved(turned), axes(0.1).ito())

    assert mean_square_distance(one_step, 0.05, 10)[1] == np.inf


def test_what_has_no_pair_is_refused():
    """Bounded noise, and equations that are not linear."""
    assert "other noise" in why_not_linear_pair(UniformlyAccurate(xi="three-point"), axes(0.1))
    assert why_not_linear_pair(UniformlyAccurate(), exponential_strip()) != ""
    assert why_not_linear_pair(UniformlyAccurate(), axes(0.1)) == ""
