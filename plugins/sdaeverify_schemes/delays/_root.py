"""Roots of a step of an index-1 equation, and the treatment of paths without one."""

import numpy as np

from sdaeverify import DelaySDAE, DelayState, Lag, Mask, Step
from sdaeverify.numerics import Root, determinant


def hold_failed(state: DelayState, new: DelayState, root: Root) -> Step:
    """Return a step in which paths without root keep their state and count as failed."""
    kept = (np.where(root.converged, now, before) for now, before in zip(new, state, strict=True))
    return Step(DelayState(*kept), failed=~root.converged, costs={"newton_iterations": root.iterations})


def regular(problem: DelaySDAE, lag: Lag, t: tuple[float, float], before: DelayState, after: DelayState) -> Mask:
    """Return on which paths du/dy keeps its orientation; a change of sign means that the solution has ended.

    Parameters
    ----------
    problem : DelaySDAE
    lag : Lag
    t : float, float
        Times at the beginning and end of the step.
    before, after : DelayState
        States at these times.
    """
    if problem.constraint is None or problem.solved is not None:
        return np.ones(before.x.shape[-1], dtype=bool)
    begin = problem.linearised_constraint(t[0], before.x, lag.now, before.y).y
    end = problem.linearised_constraint(t[1], after.x, lag.ahead(after.x), after.y).y
    return np.asarray(determinant(begin) * determinant(end) > 0.0)
