"""Steps for the least and the largest stiffness parameters that there are."""

import numpy as np
import pytest

from facade import PenalisedEuler, load_registry
from sdaeverify import ConstrainedLangevin, Increment

STEPS, PATHS, PARTS = 3, 4, 512
REGISTRY = load_registry(environ={})
STIFF = [name for name, entry in REGISTRY.problems.items() if isinstance(entry.make().build(), ConstrainedLangevin)]


def ends(scheme, problem):
    """Return where a few steps lead, and whether each of them had a root."""
    rng, h = np.random.default_rng(5), problem.horizon / PARTS
    state, step, found = scheme.start(problem, PATHS, h), scheme.prepare(problem, h), True
    for _ in range(STEPS):
        dW = np.sqrt(h) * rng.standard_normal((problem.noise_dim, PATHS))
        result = step(state, 0.0, scheme.law.increment(Increment(dW, None), h))
        state, found = result.state, found and (result.failed is None or not result.failed.any())
    return state, found


def schemes(problem):
    """Return the registered schemes of the problem's own form that do not refuse it."""
    variants = [scheme for entry in REGISTRY.schemes.values() for scheme in entry.variants]
    return [each for each in variants if each.form is ConstrainedLangevin and not each.refuses(problem)]


@pytest.mark.sweep
@pytest.mark.parametrize("eps", [1e-300, 1e300])
@pytest.mark.parametrize("name", STIFF)
def test_steps_are_finite(name, eps):
    """Every scheme makes finite steps with roots; the explicit one needs h < eps, and is not asked at 1e-300."""
    problem = REGISTRY.problems[name].make({"eps": str(eps)}).build()
    asked = [each for each in schemes(problem) if eps > 1.0 or not isinstance(each, PenalisedEuler)]

    assert len(asked) >= 5
    for scheme in asked:
        state, found = ends(scheme, problem)
        assert np.isfinite(state).all(), scheme.label
        assert found, scheme.label
