"""The point that is turned by a Levy area, and Milstein's scheme with areas and without them."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

import sdaeverify
from sdaeverify import Increment
from sdaeverify.noise.brownian import Source, brownian_steps
from sdaeverify_problems.gbm import gbm
from sdaeverify_problems.levy_area import levy_area
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.milstein_areas import MilsteinAreas

FIELDS = frozenset({"dW", "H", "A"})
H = 0.125


def test_point_stays_on_the_circle():
    """Drift and diffusion are those of a rotation: d(u^2 + v^2) = 0 by Ito's formula."""
    problem, x = levy_area(), np.array([[0.3], [-0.7], [0.6], [0.8]])
    f, B = problem.drift(0.0, x), problem.diffusion(0.0, x)

    np.testing.assert_allclose(np.einsum("dp,dlp->lp", x[2:], B[2:]), 0.0, atol=1e-15)
    np.testing.assert_allclose(2.0 * (x[2:] * f[2:]).sum() + (B[2:] ** 2).sum(), 0.0, atol=1e-15)


def test_noises_do_not_commute():
    """DB_2 B_1 - DB_1 B_2 turns the point by c."""
    problem, x = levy_area(c=2.0), np.array([[0.3], [-0.7], [0.6], [0.8]])
    B = problem.diffusion(0.0, x)
    first, second = (problem.derivative_of_diffusion(0.0, x, B[:, j]) for j in (0, 1))

    bracket = first[:, 1] - second[:, 0]
    np.testing.assert_allclose(bracket[:, 0], [0.0, 0.0, -2.0 * x[3, 0], 2.0 * x[2, 0]], atol=1e-15)


def test_truth_does_not_depend_on_the_level():
    """Chen's relation: steps of any level lead to the same point."""
    problem = levy_area()
    truth, ends = problem.pathwise, []
    for level, noise in enumerate(next(brownian_steps(Source(2, "levy", 0, 20), 2, 1.0, 4, FIELDS))):
        z, h = truth.start(20), 1.0 / 2**level
        for n in range(2**level):
            z = truth.advance(z, n * h, h, noise.increment(n))
        ends.append(truth.parts(1.0, z)["x"])

    for end in ends[1:]:
        np.testing.assert_allclose(end, ends[0], atol=1e-14)


def test_one_brownian_motion_is_milsteins_scheme():
    """Of one Brownian motion there is no area."""
    problem, x = gbm(), np.array([[1.0, -2.0]])
    noise = Increment(np.array([[0.3, -0.2]]), None)

    one, other = (scheme.step(problem, x, 0.0, H, noise).state for scheme in (MilsteinAreas(), Milstein()))
    np.testing.assert_allclose(one, other, rtol=1e-15)


def test_area_turns_the_point():
    """What the area adds to a step is its bracket times A."""
    problem, x = levy_area(), np.array([[0.3], [-0.7], [0.6], [0.8]])
    noise = Increment(np.array([[0.2], [-0.1]]), None, A=np.zeros((1, 1)))
    turned = replace_area(noise, 0.05)

    with_area, without = (MilsteinAreas().step(problem, x, 0.0, H, n).state for n in (turned, noise))
    np.testing.assert_allclose((with_area - without)[:, 0], 0.05 * 2.0 * np.array([0.0, 0.0, -0.8, 0.6]), atol=1e-15)


def replace_area(noise, area):
    """Return an increment with another area."""
    return noise._replace(A=np.full((1, 1), area))


@dataclass(frozen=True)
class AreaFree(MilsteinAreas):
    """The same with areas that are left out."""

    name: ClassVar[str] = "milstein-area-free"
    noise: ClassVar[frozenset[str]] = frozenset({"dW"})

    def step(self, problem, state, t, h, noise):
        """Make one step without areas."""
        return super().step(problem, state, t, h, noise._replace(A=np.zeros((1, noise.dW.shape[1]))))


@pytest.mark.slow
def test_order_one_needs_areas():
    """Milstein's scheme is verified with areas and refuted without them."""
    family = levy_area
    found = sdaeverify.verify([AreaFree(), MilsteinAreas()], [family], "strong", paths=8192, jobs=1).verdicts

    assert found.groupby("scheme")["verdict"].agg(set).to_dict() == {
        "milstein-area-free": {"refuted"},
        "milstein-areas": {"verified"},
    }
