"""Features of constrained mechanics that schemes may treat wrongly, see `features`."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ...arrays import Array
from ..features import (
    Feature,
    differ,
    has_several_constraints,
    has_several_motions,
    pilot_states,
    times_of,
    vary,
)


def motion_features() -> tuple[Feature, ...]:
    """Return the features of masses, constraints, force and noise."""
    return (
        Feature("a mass matrix", _has_mass),
        Feature("several constraints", has_several_constraints),
        Feature("a curved constraint", _is_curved),
        Feature("several Brownian motions", has_several_motions),
        Feature("multiplicative noise", _is_multiplicative),
        Feature("a force or noise that depends on time", _depends_on_time),
    )


def _positions_and_velocities(problem: Any) -> tuple[Array, Array]:
    n, x = problem.dimension, pilot_states(problem)
    return x[:n], x[n : 2 * n]


def _has_mass(problem: Any) -> bool:
    n = problem.dimension
    return differ([problem.inverse_mass(np.eye(n)), np.eye(n)])


def _is_curved(problem: Any) -> bool:
    r, _ = _positions_and_velocities(problem)
    y = np.sin(1.0 + np.arange(len(r)))[:, None] + 0.0 * r
    return bool(np.any(problem.d2g(r, y, y)))


def _is_multiplicative(problem: Any) -> bool:
    return vary(problem.diffusion(0.0, *_positions_and_velocities(problem)))


def _depends_on_time(problem: Any) -> bool:
    return any(differ([*values]) for values in _coefficients_in_time(problem))


def _coefficients_in_time(problem: Any) -> Iterator[Iterator[Array]]:
    state, times = _positions_and_velocities(problem), [*times_of(problem)]
    coefficients: tuple[Callable[..., Array], ...] = (problem.force, problem.diffusion)
    for f in coefficients:
        yield (f(t, *state) for t in times)
