"""Steps that are truncated are not yet what a scheme tends to, and have no order."""

import numpy as np

from facade import (
    TRUNCATED,
    DriftTruncatedEuler,
    EulerMaruyama,
    consistency,
    local_strong,
    local_weak,
    weak_order,
    why_not_local_order,
    why_not_local_weak,
)
from facade import strong_defects_LEVELS as LEVELS
from probe.weak_cells import constant, equation
from sdaeverify import SDE
from sdaeverify.probe.local.strong_defects import FEW_STATES
from sdaeverify.probe.step.states import SPREAD
from sdaeverify.probing import OneStep, cloud


def with_drift(size: float) -> SDE:
    """Return dx = size dt + dW from 1."""
    return equation(lambda t, x: size + 0.0 * x, constant([1.0]), [1.0])


def test_drift_that_is_truncated_at_every_state_has_no_local_order() -> None:
    """A drift of 1e9 is truncated by the shortest step that is probed, and nothing is held against the scheme."""
    steep = with_drift(1e9)

    assert why_not_local_order(DriftTruncatedEuler(), steep) == TRUNCATED
    assert why_not_local_weak(DriftTruncatedEuler(), steep) == TRUNCATED
    assert not why_not_local_order(EulerMaruyama(), steep)


def test_states_with_a_truncated_step_are_left_out() -> None:
    """Where the drift is steep at some states of the cloud, orders are those at the others."""
    steep = equation(lambda _, x: -1e6 * np.maximum(x - 1.5, 0.0) ** 2, constant([1.0]), [1.0])
    scheme, problem = DriftTruncatedEuler(), steep
    step = OneStep(scheme, problem)
    states, left = cloud(problem, step.equation), step.usable_states(float(LEVELS[-2]) * problem.time_unit)
    record = local_strong(scheme, problem)

    assert 0 < left.shape[1] < states.shape[1]
    assert record.near == left.shape[1]
    assert record.rms.shape[1] < (states.shape[1] + SPREAD + FEW_STATES) * int(record.times)
    assert not consistency(scheme, problem).off.any()
    assert weak_order(local_weak(scheme, problem)).order > 0.5


def test_gentle_drift_keeps_all_states() -> None:
    """No step of a drift of 1 is truncated at a size that orders are taken from."""
    step = OneStep(DriftTruncatedEuler(), with_drift(1.0))

    assert step.usable_states(float(LEVELS[-2])) is cloud(step.view, step.equation)
    assert not step.truncated(cloud(step.view, step.equation), LEVELS[-3:], [0.2] * 3).any()
