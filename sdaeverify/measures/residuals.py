"""Residuals of constraints after single steps near the start of a problem."""

from typing import Any, NamedTuple

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

# Sizes of steps in units of time, and paths from each state. At the finer sizes, solvers that converge linearly reach
# nearly round-off; so does a single update of Newton's method, which the coarse size detects. The bound for
# round-off, in units of EPS and of the terms that cancel, is that of the coarsest runs: 8 steps.
# Size: step sizes and paths. Rounding: 64 eps sqrt(8), as random errors of 8 steps add up.
COARSE, FINE, PATHS, BOUND = 2.0**-6, (2.0**-10, 2.0**-14), 16, 64.0 * np.sqrt(8.0)


class Ratios(NamedTuple):
    """Largest residuals of a constraint after one step, as multiples of the bound for round-off.

    Attributes
    ----------
    coarse, fine : float
        After steps of the coarse size and of the finer sizes; NaN if all of them fail.
    """

    coarse: float
    fine: float


def rounding_ratios(scheme: Scheme, view: Any) -> dict[str, Ratios]:
    """Return the largest residual of each constraint after one step, as a multiple of its bound for round-off.

    For a constraint that depends on time or on lagged values, it is 0 if the scheme solves the constraint, else
    infinite.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        With constraints, in the scheme's form.
    """
    if view.moving_constraints:
        return {"u": Ratios(*2 * (0.0 if keeps_constraint(scheme, view) else np.inf,))}
    step = OneStep(scheme, view)
    if step.why_not_entered(run=False):
        return {}
    coarse, *fine = (_ratios_after(step, h * step.time_unit) for h in (COARSE, *FINE))
    return {name: Ratios(coarse[name], np.fmax.reduce([each[name] for each in fine])) for name in coarse}


def _ratios_after(step: OneStep, h: float) -> dict[str, float]:
    scheme, view = step.scheme, step.view
    x = np.repeat(states_near_start(view, step.equation), PATHS, axis=1)
    noise = scheme.law.increment(view.drawn(np.random.Generator(np.random.Philox(key=SEED)), h, x.shape[1]), h)
    made = step.make(x, step.time, h, noise)
    kept = np.ones(x.shape[1], dtype=bool) if made.failed is None else ~made.failed
    found = view.residuals(scheme.parts(view, made.state))
    sizes = {name: norm(each.value) / (BOUND * EPS * each.scale) for name, each in found.items()}
    return {name: float(np.fmax.reduce(each[kept], initial=np.nan)) for name, each in sizes.items()}


def judge_ratios(ratios: Ratios) -> Opinion:
    """Return the opinion on a claim that a constraint holds up to round-off, by its residuals after one step."""
    coarse, fine = ratios
    if np.isnan(fine):
        return local_doubt("each step fails")
    text = "residual of one step {:.1g} times the bound for round-off"
    if fine > 1.0:
        return local_opinion(Verdict.REFUTED, text.format(fine))
    if coarse > 1.0:
        return local_doubt(f"{text.format(coarse)} if it is long: too few iterations")
    return local_opinion(Verdict.VERIFIED, text.format(fine))
