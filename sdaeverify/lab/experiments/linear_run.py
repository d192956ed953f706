"""A run that is linear with a delay, so that its first two moments need no sampling."""

from typing import NamedTuple

import numpy as np

from ...contracts.matching import match
from ...contracts.scheme import Scheme, flatten
from ...forms import Delayed, Problem
from ...probe.linear.affine import AFFINE
from ...probe.linear.delay_map import at_rest, is_autonomous, is_scalar, linear_delay, probed_step, run_start
from ...probe.linear.delay_moments import RunMoments, run_moments
from ...probe.linear.delay_step import LinearDelayStep
from ...probe.stability.delay_radius import radius


class LongRunGrowth(NamedTuple):
    """How second moments grow in the long run.

    Attributes
    ----------
    factor : float
        Of a step of the scheme: its spectral radius.
    rate : float
        Of the equation, as e^(rate t); NaN if it is not known.
    """

    factor: float
    rate: float


class LinearRun(NamedTuple):
    """A scheme with one step size on a linear equation with a delay.

    Attributes
    ----------
    scheme : Scheme
    view : Delayed
        As the scheme sees the equation.
    h : float
    step : LinearDelayStep
    """

    scheme: Scheme
    view: Delayed
    h: float
    step: LinearDelayStep

    def moments(self, steps: int) -> RunMoments:
        """Return means and second moments of x and y up to so many steps."""
        start = run_start(self.scheme, self.view, self.h, steps)
        return run_moments(self.step, self.view.mesh(self.h), start, steps)

    def growth(self) -> LongRunGrowth:
        """Return how second moments grow; the equation's rate is known of one x and one noise."""
        rate = linear_delay(self.view).growth_rate if is_scalar(self.view) else np.nan
        return LongRunGrowth(radius(self.step, self.view.mesh(self.h)).rho, rate)


def linear_run(scheme: Scheme, steps: int, problem: Problem) -> LinearRun | None:
    """Return the run of a scheme with so many steps to the final time; None where it is not linear."""
    matched, h = match(scheme, problem).problem, problem.horizon / steps
    view = None if matched is None else matched.capability(Delayed)
    if view is None or scheme.law.clip:
        return None
    memory = flatten(scheme.start(view, 1, h))
    if len(memory) != view.dimension + view.constraints or not at_rest(view) or not is_autonomous(view):
        return None
    found = probed_step(scheme, view, h)
    linear = not found.failed and max(found.defect, np.abs(found.offset).max()) <= AFFINE
    return LinearRun(scheme, view, h, found.step) if linear else None
