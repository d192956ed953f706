"""Runs of a scheme on an equation with delay that are linear: their exact moments and growth rates."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme, flatten
from ...forms import Delayed, Problem
from ..linear.affine import AFFINE
from ..linear.delay_equation import at_rest, is_autonomous, is_scalar, linear_delay
from ..linear.delay_step import LinearDelayStep, RunMoments, probe_step, run_moments, run_start
from ..linear.moments import fit_quadratic
from .delay_radius import radius


class LinearDelayRun(NamedTuple):
    """A scheme with a fixed step size on a linear equation with delay.

    Attributes
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    h : float
    step : LinearDelayStep
    """

    scheme: Scheme
    view: Delayed
    h: float
    step: LinearDelayStep

    @classmethod
    def of(cls, scheme: Scheme, view: Problem, steps: int) -> "LinearDelayRun | None":
        """Return the run of a scheme with ``steps`` steps to the final time; None if it is not linear.

        Parameters
        ----------
        scheme : Scheme
        view : Problem
            Problem in the scheme's form, with or without a delay.
        steps : int
            Number of steps from 0 to the horizon.
        """
        delayed, h = view.capability(Delayed), view.horizon / steps
        if delayed is None or scheme.law.clip:
            return None
        has_memory = len(flatten(scheme.start(delayed, 1, h))) != delayed.dimension + delayed.constraints
        if has_memory or not at_rest(delayed) or not is_autonomous(delayed):
            return None
        found = probe_step(scheme, delayed, h)
        linear = not found.failed and max(found.defect, np.abs(found.offset).max()) <= AFFINE
        return cls(scheme, delayed, h, found.step) if linear else None

    def moments(self, steps: int) -> RunMoments:
        """Return means and second moments of x and y after each of the first ``steps`` steps."""
        start = run_start(self.scheme, self.view, self.h, steps)
        return run_moments(self.step, self.view.mesh(self.h), start, steps)

    def is_quadratic(self, function: Callable[[Array], Array]) -> bool:
        """Return whether a function of points z = (x, y), shape (d + k, P) -> (P,), is quadratic, up to rounding."""
        return fit_quadratic(function, self.step.rows) is not None

    def growth(self) -> tuple[float, float]:
        """Return the growth factor of second moments per step of the scheme, and the growth rate of the equation.

        The rate is NaN unless x and the noise are scalar.
        """
        rate = linear_delay(self.view).growth_rate if is_scalar(self.view) else np.nan
        return radius(self.step, self.view.mesh(self.h)).rho, rate
