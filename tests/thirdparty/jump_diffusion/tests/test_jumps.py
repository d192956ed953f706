"""The record of jumps, its refinement, and truths of the two problems."""

import numpy as np
import pytest
from sdaeverify_jumps._compound_poisson import CompoundPoisson
from sdaeverify_jumps.geometric_jumps import geometric_jumps
from sdaeverify_jumps.jump_euler import JumpEuler
from sdaeverify_jumps.shot_noise import shot_noise

from sdaeverify.testing import parametrize_with_checks

J = CompoundPoisson(4.0, (-0.3, 0.4), (0.25, 0.75))


def test_halves_make_up_the_step():
    """Each jump is in one half, at its time; joined again, the halves have the same jumps at the same times."""
    rng = np.random.default_rng(1)
    step = J.begin(rng, 1.0, 50)

    halves = J.refined(step, 1.0, rng)
    first, second = (type(step)(*(part[k] for part in halves)) for k in range(2))
    again = J.joined(first, second)

    assert np.allclose(again.total, step.total[0], rtol=0.0, atol=1e-15)
    for path in range(50):
        pairs = sorted(zip(step.time[0, :, path], step.mark[0, :, path], strict=True))
        others = sorted(zip(again.time[:, path], again.mark[:, path], strict=True))
        pairs, others = (np.array([p for p in each if p[1]]) for each in (pairs, others))
        np.testing.assert_allclose(others, pairs, rtol=0.0, atol=1e-15)


def test_step_of_no_length_has_no_jump():
    """A step of no length has no jump."""
    assert not J.begin(np.random.default_rng(1), 0.0, 5).total.any()


def test_rule_has_the_first_moments():
    """Up to what three jumps in a step add, weights sum to 1 and J has the mean and the variance of its law."""
    h = 1e-3
    jumps, weights = J.rule(h)

    assert weights.sum() == pytest.approx(1.0, rel=1e-15)
    assert weights @ jumps.total == pytest.approx(J.rate * h * J.mean, abs=(J.rate * h) ** 3)
    square = J.rate * h * np.dot(np.square(J.values), J.weights) + (J.rate * h * J.mean) ** 2
    assert weights @ jumps.total**2 == pytest.approx(square, abs=(J.rate * h) ** 3)


@pytest.mark.parametrize("problem", [geometric_jumps(), shot_noise()])
def test_moments_begin_with_the_rate_of_the_generator(problem):
    """D E q/dt = q' f + q'' g^2/2 + rate E[q(x + c y) - q(x)] at the start, for q = x and q = x^2."""
    x, e, jumps = problem.initial(1), 1e-6, problem.jumps
    f, g, c = (np.ravel(each)[0] for each in problem.coefficients(0.0, x))
    x0, powers = float(x[0, 0]), {"x": (1, 0.0), "x^2": (2, 1.0)}

    for truth in (each for each in problem.truths if hasattr(each, "observable")):
        k, bend = powers[truth.observable]
        kicked = np.dot(jumps.weights, (x0 + c * np.array(jumps.values)) ** k - x0**k)
        rate = k * x0 ** (k - 1) * f + bend * g**2 + jumps.rate * kicked
        assert (truth.value(e) - truth.value(0.0)) / e == pytest.approx(rate, rel=1e-4)


@parametrize_with_checks([JumpEuler(), geometric_jumps, shot_noise], problems=[geometric_jumps, shot_noise])
def test_contract(subject, check):
    """Scheme and problems pass the conformance kit."""
    check(subject)
