"""The bound that tells rounding of affine and quadratic functions from further terms, from either side."""

import numpy as np
import pytest

from facade import AFFINE, fit_quadratic, load_registry, match, select_problems, select_schemes
from sdaeverify.forms import Delayed
from sdaeverify.numerics.statistics import EPS
from sdaeverify.probe.linear import affine
from sdaeverify.probe.linear.linear_map import MemoryStep, linear_map
from sdaeverify.probe.linear.step_moments import why_not_linear_step
from sdaeverify.probe.step.step_noise import StepNoise
from sdaeverify.probing import OneStep
from sdaeverify.study.plan import built

# Shares of the horizon's unit: a long step, and a short one.
SIZES = 2.0**-2, 2.0**-6


def found_defect(f, k, reached):
    """Return the defect of a function of states, shape (k, P) -> (k, P), with states that a solution reaches."""
    x = affine.with_trials(reached)
    values = f(x)[..., None]
    return affine.defect(x, values, affine.at_corners(values[:, : k + 1]))


@pytest.mark.parametrize("k", [1, 4, 16])
@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8])
def test_rounding_of_64_operations_is_below_the_bound(k, scale):
    """At large states too: the derivation bounds the defect, and the bound of affine functions is above it."""
    rng = np.random.default_rng(k)
    parts, offsets = rng.standard_normal((32, k, k)), rng.standard_normal((32, k, 1))

    def f(x):
        total = np.zeros_like(x)
        for R, r in zip(parts, offsets, strict=True):
            total = total + (R @ x + r)
        return total

    found = found_defect(f, k, scale * rng.standard_normal((k, 8)))

    assert 0.0 < found <= 128.0 * EPS * (1.0 + 100.0 * np.sqrt(k)) < AFFINE


def test_coefficients_of_which_a_large_offset_leaves_few_digits_are_not_used():
    """Of a slope beside an offset that is 1e8 times larger, eight digits are left, and states as large show it."""
    assert found_defect(lambda x: 1.1e8 - x / 3.0, 1, np.array([[3.3e8]])) > AFFINE
    assert found_defect(lambda x: 1.1 - x / 3.0, 1, np.array([[3.3e8]])) <= AFFINE


@pytest.mark.parametrize(("part", "is_affine"), [(0.99, True), (1.01, False)])
def test_a_quadratic_term_just_above_the_bound_is_seen(part, is_affine):
    """In x + q x^2 it is q (x - 1) of the step, at the largest of the trial states."""
    largest = np.abs(affine.trial_states(1) - 1.0).max()
    q = part * AFFINE / largest

    found = found_defect(lambda x: x + q * x**2, 1, np.zeros((1, 0)))

    assert found == pytest.approx(part * AFFINE, rel=1e-3)
    assert (found <= AFFINE) is is_affine


@pytest.mark.parametrize("offset", [0.0, 1.3, 100.0])
def test_a_square_is_quadratic_whatever_its_offset(offset):
    """Its coefficients cancel in (x - c)^2, up to rounding."""
    found = fit_quadratic(lambda x: (x[0] - offset) ** 2 / 3.0 + x[1], 2)

    assert found.square[0, 0] == pytest.approx(1.0 / 3.0)
    assert found.linear == pytest.approx([-2.0 * offset / 3.0, 1.0])


@pytest.mark.parametrize(("part", "is_quadratic"), [(0.9, True), (1.1, False)])
def test_a_cubic_term_just_above_the_bound_is_seen(part, is_quadratic):
    """In x^2 + q x^3 it is q (x - 1/x) of x^2 + 2 |x|, at the largest of the trial states."""
    x = np.abs(8.0 * affine.trial_states(1)).max()
    q = part * AFFINE * (x**2 + x) / (x**3 - x)

    assert (fit_quadratic(lambda x: x[0] ** 2 + q * x[0] ** 3, 1) is not None) is is_quadratic


@pytest.mark.slow
@pytest.mark.long
def test_no_shipped_step_is_near_the_bound():
    """Steps are affine up to rounding, or their defect is a part of the step; equations and observables likewise."""
    defects = list(shipped_defects())

    assert len(defects) > 500
    assert not [each for each in defects if 1e-12 < each < 1e-4]
    assert min(defects) < 1e-14
    assert max(defects) > 0.1


def shipped_defects():
    """Yield the defects of all shipped schemes on all shipped problems without delay, where they have one."""
    registry = load_registry(environ={})
    schemes = select_schemes(registry)
    for problem in map(built, select_problems(registry)):
        for scheme in schemes:
            view = match(scheme, problem).problem
            if view is None or view.capability(Delayed) or not can_be_probed(scheme, view):
                continue
            noise = StepNoise.of(OneStep(scheme, view))
            nodes = noise.rule(0) if noise.law.bounded else noise.nodes(noise.trials())
            with np.errstate(all="ignore"):
                for size in SIZES:
                    found = linear_map(MemoryStep(OneStep(scheme, view), size * view.time_unit), nodes).defect
                    if np.isfinite(found):
                        yield found


def can_be_probed(scheme, view):
    """Return whether a step can be probed for a linear map: by nodes for its noise, on an equation."""
    known = scheme.noise <= {"dW", "H"} and not view.records and view.equation() is not None
    return known and not why_not_linear_step(scheme, view)
