"""Delay equations as ordinary ones: the solution at the current time and at earlier times, one delay apart."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...arrays import Array
from ..sde.sde import SDE
from .delayed import Delayed

X = "x"


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkedEquation(SDE):
    """The equation of a solution at the current time and at earlier times, one delay apart.

    Attributes
    ----------
    delay : float
        tau: a longer step would need the lagged values of its own end.
    """

    delay: float

    @property
    def time_unit(self) -> float:
        """The unit of time, limited by the delay."""
        return min(super().time_unit, self.delay)

    @property
    def longest_unit(self) -> float:
        """The horizon, limited by the delay."""
        return min(super().longest_unit, self.delay)


@lru_cache(maxsize=8)
def linked_equation(problem: Delayed, links: int, until: float = np.inf) -> SDE:
    """Return the Ito equation of (..., x(s + tau), x(s)), shape (links d, P), with y eliminated and time s.

    Parameters
    ----------
    problem : Delayed
    links : int
        Number of solutions, one delay apart, in one state: 1 or 2.
    until : float
        Latest time of the current solution with two links, in delays; limited by the horizon.
    """
    plain, d, l, tau = problem.without_y(), problem.dimension, problem.noise_dim, problem.delay
    none, first = np.zeros((0, 1)), min(problem.horizon, tau)
    # With two links, s is the time of the older solution; a problem shorter than a delay has no such time.
    span = first if links == 1 else min(problem.horizon, until * tau) - tau

    def arguments(s: float, z: Array) -> list[tuple[float, Array, Array, Array]]:
        rows = [*np.split(z, links), history_at(problem, s, z)]
        return [(s + (links - 1 - i) * tau, rows[i], rows[i + 1], none) for i in range(links)]

    def drift(s: float, z: Array) -> Array:
        return np.concatenate([np.broadcast_to(plain.drift(*at), at[1].shape) for at in arguments(s, z)])

    def diffusion(s: float, z: Array) -> Array:
        columns = [plain.diffusion(*at) for at in arguments(s, z)]
        full = np.zeros((links * d, links * l, z.shape[-1]), dtype=np.result_type(*columns))
        for i, column in enumerate(columns):
            full[i * d : (i + 1) * d, i * l : (i + 1) * l] = column
        return full

    return LinkedEquation(
        drift=drift,
        diffusion=diffusion,
        start=np.tile(problem.past(0.0)[:, 0], links),
        names={X if not i else f"{X}(t - {i} tau)": slice(i * d, (i + 1) * d) for i in range(links)},
        noise_dim=links * l,
        noise=problem.noise,
        horizon=span if span > 0.0 else first,
        delay=tau,
        domain=problem.domain and problem.domain.repeated(links),
        traits=problem.traits - {"scalar-noise", "diagonal-noise", "commutative-noise", "algebraic", "constrained"},
        source=f"as an equation without delay: {problem.source}",
        seen_as="linked equation",
    )


def history_at(problem: Delayed, s: Array | float, z: Array) -> Array:
    """Return phi(s - tau) on every path of z, and phi(0) after tau.

    Parameters
    ----------
    problem : Delayed
    s : float or ndarray, shape (P,)
        Time of the oldest link.
    z : ndarray, shape (links d, P)
        State of the linked equation; only its number of paths is used.
    """
    times, place = np.unique(np.minimum(0.0, s - problem.delay), return_inverse=True)
    past = np.concatenate([problem.past(t) for t in times.tolist()], axis=1)
    return past[:, place.ravel()] + 0.0 * z[: problem.dimension]
