"""Euler steps for the inherent SDE with projections in some steps only."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Mask, Step

from ._position_projection import Projection


class SkippingState(NamedTuple):
    """State of a scheme that projects in some steps only.

    Attributes
    ----------
    r, v : ndarray, shape (n, P)
    mu : ndarray, shape (m, P)
    skipped : ndarray, shape (1, P)
        Number of steps since the last projection.
    """

    r: Array
    v: Array
    mu: Array
    skipped: Array


def inherent_euler(problem: HolonomicSDAE, state: SkippingState, t: float, h: float, dw: Array) -> SkippingState:
    """Return the unprojected state r^, v^ and mu + l^."""
    r, v, mu, skipped = state
    J = problem.linearised(r)
    force = problem.force(t, r, v) + problem.diffused(t, r, v, dw) / h
    rate = problem.inherent_multiplier(J, r, v, force)
    v_free = v + h * problem.inverse_mass(force + J.transposed(rate))
    return SkippingState(r + h * v, v_free, mu + h * rate, skipped + 1.0)


def projections(
    problem: HolonomicSDAE, old: SkippingState, free: SkippingState, due: Mask, projection: Projection
) -> Step:
    """Project the paths that are due; paths without root keep their old state."""
    new = projection(problem, free.r)
    v, impulse = problem.tangent(new.J, free.v)
    projected = SkippingState(new.r, v, free.mu + impulse, np.zeros_like(free.skipped))
    failed = due & ~new.found
    reached = projected if due.all() else _choose(due, projected, free)
    return Step(
        _choose(failed, old, reached) if failed.any() else reached,
        failed,
        outputs={"eta": np.where(due, new.eta, 0.0)},
        costs={projection.counter: np.where(due, new.iterations, np.nan)},
    )


def _choose(mask: Mask, these: SkippingState, others: SkippingState) -> SkippingState:
    return SkippingState(*(np.where(mask, a, b) for a, b in zip(these, others, strict=True)))
