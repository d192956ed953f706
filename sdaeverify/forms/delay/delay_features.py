"""Features of delay equations and of index-1 equations that schemes may treat wrongly, see `features`."""

from typing import Any

import numpy as np

from ...arrays import Array
from ..features import PATHS, SEED, Feature, differ, has_several_motions, times_of, vary

# Number of steps of a run whose step size is compared with the delay.
STEPS = 1024


def undelayed_features() -> tuple[Feature, ...]:
    """Return the features that need no delay."""
    return (
        Feature("several components", lambda problem: problem.dimension > 1),
        Feature("several Brownian motions", has_several_motions),
        Feature("multiplicative noise", lambda problem: _noise_varies(problem, 0)),
        Feature("algebraic components", lambda problem: problem.has_constraints),
        Feature("coefficients that depend on time", _depends_on_time),
    )


def delay_features() -> tuple[Feature, ...]:
    """Return the features of index-1 equations, followed by those of the delay."""
    return (
        *undelayed_features(),
        Feature("noise that depends on the past", lambda problem: bool(problem.delay) and _noise_varies(problem, 1)),
        Feature("a delay that is no multiple of the step", _is_off_the_mesh),
    )


def _states(problem: Any) -> tuple[Array, Array, Array]:
    """Return the initial x, lagged x and y, perturbed at random on all paths except the first."""
    rng = np.random.Generator(np.random.Philox(key=SEED))
    x, v, y = problem.past(0.0), problem.past(-problem.delay), problem.initial(1).y
    moved = (z + 0.1 * (1.0 + np.abs(z)) * rng.standard_normal((len(z), PATHS)) for z in (x, v, y))
    x, v, y = (np.concatenate([z, near], axis=1) for z, near in zip((x, v, y), moved, strict=True))
    return x, v, y


def _noise_varies(problem: Any, which: int) -> bool:
    """Return whether the noise depends on x and y or, if `which` is 1, on the lagged x."""
    x, v, y = _states(problem)
    still = [np.repeat(z[:, :1], z.shape[1], axis=1) for z in (x, v, y)]
    given = (still[0], v, still[2]) if which else (x, still[1], y)
    return vary(problem.diffusion(0.0, *given))


def _depends_on_time(problem: Any) -> bool:
    state, times = _states(problem), [*times_of(problem)]
    constraint = (problem.constraint,) if problem.has_constraints else ()
    return any(differ([f(t, *state) for t in times]) for f in (problem.drift, problem.diffusion, *constraint))


def _is_off_the_mesh(problem: Any) -> bool:
    return bool(problem.delay) and bool(problem.mesh(problem.horizon / STEPS).delta)
