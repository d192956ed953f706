"""Members of a family: one problem with several stiffness parameters eps, its truths included."""

from functools import lru_cache
from typing import Any

import numpy as np

from sdaeverify import Array, Increment, Problem, Scheme
from sdaeverify.probing import StiffnessFamily

# Decades of eps, in the problem's unit of time: from far below to far above all step sizes.
LOWEST, HIGHEST = -8, 1
TYPICAL = 1.0
# Number of steps per horizon, small enough for steps to have a root; numbers of steps and paths that are examined.
PARTS, FEW_STEPS, FEW_PATHS = 512, 8, 256


def why_not_family(scheme: Scheme, problem: Problem) -> str:
    """Return why a pair has no family of problems with all eps, or an empty string; no coefficient is evaluated."""
    view = scheme.view_of(problem)
    if view is None:
        return "neither the scheme nor the problem has a stiffness parameter"
    return view.why_not(StiffnessFamily)


def stiffnesses(per_decade: int) -> Array:
    """Return eps from 1e-8 to 10, ascending, shape (9 per_decade + 1,)."""
    return np.asarray(10.0 ** np.linspace(LOWEST, HIGHEST, (HIGHEST - LOWEST) * per_decade + 1))


@lru_cache(maxsize=128)
def member(view: Any, eps: float = TYPICAL) -> StiffnessFamily:
    """Return the problem with another eps; requires that `why_not_family` returns an empty string.

    Cached, because all schemes and measures use the same members.
    """
    family: StiffnessFamily = view.capability(StiffnessFamily)
    return family.member(float(eps))


def short_step(view: Problem) -> float:
    """Return the step size of `few_steps`, in the problem's unit of time."""
    return view.horizon / PARTS


def few_steps(scheme: Scheme, view: Problem, h: float, seed: int) -> list[Increment]:
    """Return the increments of a few steps on a few paths, in the scheme's law; determined by the seed.

    Parameters
    ----------
    scheme : Scheme
        Its law converts Gaussian increments.
    view : Problem
    h : float
        Step size.
    seed : int
        The same seed gives the same paths for every member of the family.
    """
    rng = np.random.Generator(np.random.Philox(key=seed))
    xi = rng.standard_normal((FEW_STEPS, 2, view.noise_dim, FEW_PATHS))
    drawn = (Increment(np.sqrt(h) * each[0], np.sqrt(h / 12.0) * each[1]) for each in xi)
    return [scheme.law.increment(each, h) for each in drawn]
