"""States along a scheme's own run."""

import numpy as np
import pytest

from facade import EulerMaruyama, StochasticTheta, delay_ou, ou
from sdaeverify.conformance.own_run import STEPS, level_noise, stopped_states


def test_paths_stop_one_after_the_other():
    """Path p is where p steps of its own noise have led it."""
    problem, paths = ou(), 5
    h, x = problem.horizon / paths, problem.initial(paths)
    expected = [x[:, 0]]
    for n in range(paths - 1):
        x = x - h * x + 0.7 * level_noise(problem, paths, h, n).dW
        expected.append(x[:, n + 1])

    states = stopped_states(EulerMaruyama(), problem, paths)

    np.testing.assert_allclose(states, np.stack(expected, axis=1), rtol=1e-15)


@pytest.mark.parametrize("paths", [1, 3 * STEPS])
def test_any_number_of_paths_stops(paths):
    """One path stays at the start; of many, some stop together, each where its own noise has led it."""
    states = stopped_states(EulerMaruyama(), ou(), paths)

    assert states.shape == (1, paths)
    assert len(np.unique(states)) == max(1, paths - 2)


def test_states_with_a_delay_cannot_be_written_into():
    """Lagged values belong to the run, and what it leaves is read-only."""
    states = stopped_states(StochasticTheta(0.5), delay_ou(), 4)

    assert np.isfinite(states.x).all()
    assert not states.x.flags.writeable
