"""Residuals of constraints after single steps near the start of a problem."""

from typing import Any

import numpy as np

from ..contracts.finding import Opinion, Verdict
from ..contracts.scheme import Scheme
from ..numerics import norm
from ..numerics.statistics import EPS
from ..probe.local.delay_links import keeps_constraint
from ..probe.step.nodes import SEED
from ..probe.step.one_step import OneStep
from ..probe.step.states import states_near_start
from ..verdicts.opinions import local_doubt, local_opinion

# Sizes of steps in units of time, at which solvers that converge linearly come near round-off, and paths from each
# state. The bound of round-off, in units of EPS and of the terms that cancel, is that of the coarsest runs: 8 steps.
STEPS, PATHS, BOUND = 2.0 ** -np.array([10.0, 14.0]), 16, 64.0 * np.sqrt(8.0)


def rounding_ratios(scheme: Scheme, view: Any) -> dict[str, float]:
    """Return the largest residual of each constraint after one step, as a multiple of its bound for round-off.

    It is NaN where each step fails. A constraint that depends on time or on lagged values is solved or not.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        With constraints, in the scheme's form.
    """
    if view.moving_constraints:
        return {"u": 0.0 if keeps_constraint(scheme, view) else np.inf}
    step = OneStep(scheme, view)
    found: dict[str, float] = {}
    if step.why_not_entered(run=False):
        return {}
    x = np.repeat(states_near_start(view, step.equation), PATHS, axis=1)
    for h in STEPS * step.time_unit:
        noise = scheme.law.increment(view.drawn(np.random.Generator(np.random.Philox(key=SEED)), h, x.shape[1]), h)
        made = scheme.prepare(view, h)(step.enter(x, step.time, h), step.time, noise)
        kept = np.ones(x.shape[1], dtype=bool) if made.failed is None else ~made.failed
        for name, residual in view.residuals(scheme.parts(view, made.state)).items():
            ratio = norm(residual.value) / (BOUND * EPS * residual.scale)
            found[name] = np.fmax(found.get(name, np.nan), np.fmax.reduce(ratio[kept], initial=np.nan))
    return found


def judge_ratio(ratio: float) -> Opinion:
    """Return the opinion on a claim that a constraint holds up to round-off, by one ratio."""
    if np.isnan(ratio):
        return local_doubt("each step fails")
    text = f"residual of one step {ratio:.1g} times the bound for round-off"
    return local_opinion(Verdict.VERIFIED if ratio <= 1.0 else Verdict.REFUTED, text)
