"""Features of a problem that schemes may treat wrongly, measured from its coefficients instead of its traits.

A claim is tested only on the problems of a run. A scheme that omits the mass matrix is correct on all problems with
M = 1, so a run without a mass matrix does not test it. Each form lists its features, and each feature is
detected by evaluating coefficients, their differences in state and time, or their dimensions.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..numerics.linalg import all_finite

# Steps, paths and relative step size of the pilot run that provides states, and times as fractions of the horizon.
STEPS, PATHS, SHORT = 16, 4, 1.0 / 64.0
TIMES = (0.0, 0.13, 0.37, 0.71)
SEED = 0x5DAE
# Relative tolerance for equal values, above the rounding of coefficients.
EQUAL = 1e-9
# Step of central differences, whose error is its square, and tolerance for their commutators.
DIFFERENCE, COMMUTING = 1e-4, 1e-6


class Feature(NamedTuple):
    """A property that some problems of a form have.

    Attributes
    ----------
    name : str
        Completes "no problem has", such as "a mass matrix".
    found : callable, problem -> bool
        Whether a problem has it.
    """

    name: str
    found: Callable[[Any], bool]


def differ(values: Sequence[Array]) -> bool:
    """Return whether any array differs from the first one by more than rounding; the arrays are broadcast."""
    size = max(float(np.abs(value).max(initial=0.0)) for value in values)
    return any(bool((np.abs(value - values[0]) > EQUAL * size).any()) for value in values[1:])


def vary(values: Array) -> bool:
    """Return whether values differ along the last axis, that of paths, by more than rounding."""
    return values.shape[-1] > 1 and differ([values, values[..., :1]])


def times_of(problem: Any) -> Iterator[float]:
    """Yield times at which coefficients are compared."""
    return (part * problem.horizon for part in TIMES)


def pilot_states(problem: Any) -> Array:
    """Return the initial state and the final states of a short Euler-Maruyama run of the equation, shape (d, S).

    States that are not finite are omitted.
    """
    equation = problem.equation()
    x = equation.initial(PATHS)
    h = SHORT * min(problem.time_unit, problem.fastest_time)
    normals = np.random.Generator(np.random.Philox(key=SEED)).standard_normal((STEPS, problem.noise_dim, PATHS))
    found = [x[:, :1]]
    with np.errstate(all="ignore"):
        for step, xi in enumerate(np.sqrt(h) * normals):
            x = x + h * equation.drift(step * h, x) + equation.diffused(step * h, x, xi)
        found.append(x[:, all_finite(x)])
    return np.concatenate(found, axis=1)


def has_several_motions(problem: Any) -> bool:
    """Return whether there are several Brownian motions."""
    return bool(problem.noise_dim > 1)


def has_several_constraints(problem: Any) -> bool:
    """Return whether there are several constraints."""
    return bool(problem.constraints > 1)


def noises_do_not_commute(diffusion: Callable[[Array], Array], x: Array) -> bool:
    """Return whether DB_j B_k and DB_k B_j differ for two columns of a diffusion, at states of shape (d, S)."""
    B = np.broadcast_to(diffusion(x), (*diffusion(x).shape[:2], x.shape[1]))
    derivatives = [
        (diffusion(x + DIFFERENCE * column) - diffusion(x - DIFFERENCE * column)) / (2.0 * DIFFERENCE)
        for column in np.moveaxis(B, 1, 0)
    ]
    size = max(float(np.abs(D).max(initial=0.0)) for D in derivatives)
    return any(
        bool((np.abs(derivatives[j][:, k] - derivatives[k][:, j]) > COMMUTING * size).any())
        for j, k in combinations(range(len(derivatives)), 2)
    )
