"""Rates of mean and covariance of an equation's solution, at states that solutions reach."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask
from ...forms import Equation, Problem
from ..step.states import cloud, reached_states, time_unit
from .reach import core

# Step sizes of `step_law` in units of the horizon, or of time if that is shorter. If the error of a rate is small at
# the first size, so is its limit. If not, the finer sizes give the limit, unless the error is smaller at the first
# one, as that of a solver is, which increases as steps get shorter.
FIRST, FINER = 4.0**-9.0, 4.0 ** -np.array([11.0, 13.0, 15.0])
# Sizes that give the limit where a solver's errors, which increase as steps get shorter, hide it at the finer ones.
LONGER = 4.0 ** -np.array([5.0, 6.0, 7.0])
# A drift that moves a state by more than this in the shortest step may be tamed or truncated in all of them.
# Theorem: elementary, a drift f/(1 + h |f|) with h |f| = m is off by m/(1 + m) of it. Up to m = 3 that is no limit of
# three sizes of ratio 16, and up to m = 1 it is less than half of the error of long steps.
MOVED = 0.25
# Part of the typical size of drift and noise that is added to their size, so that errors can be relative where these
# vanish.
# Size: of a unit; where nothing moves, an error counts from a fifth of `step_law.SMALL` of the typical motion on.
TYPICAL = 0.2
# Largest product of components, nodes, states and times for one step size: for large systems fewer times are used,
# but at least this number.
# Size: memory, and parts of the run.
MOST, FEWEST = 2**17, 4
# States times nodes of a step: with more nodes there are fewer states.
# Size: states times nodes.
WORK = 256


class EquationRates(NamedTuple):
    """Rates of mean and covariance of an equation's solution at S states for each of n times.

    Attributes
    ----------
    t : ndarray, shape (n,)
    x, f : ndarray, shape (n, d, S)
    B : ndarray, shape (n, S, d, l)
    rows : dict of str to slice
        Rows of the components.
    core : ndarray of bool, shape (C,)
        Whether drift or diffusion depend on a component.
    size : ndarray, shape (2, C, n, S)
        Divisors of the errors of both rates; infinite where they are not to be compared.
    """

    t: Array
    x: Array
    f: Array
    B: Array
    rows: dict[str, slice]
    core: Mask
    size: Array

    @property
    def core_rows(self) -> dict[str, slice]:
        """Rows of the components on which drift or diffusion depend."""
        return {name: rows for (name, rows), counts in zip(self.rows.items(), self.core, strict=True) if counts}

    def moments(self, places: Array) -> tuple[Array, Array, Array]:
        """Return f, B B^T and B at some of the times."""
        B = self.B[places]
        return self.f[places], B @ B.swapaxes(2, 3), B

    def for_nodes(self, count: int) -> "EquationRates":
        """Return a selection of states and times small enough for `count` nodes, including the extreme states."""
        some = slice(-max(WORK // count, 2), None)
        columns = len(self.x[0]) * count * len(self.x[0, 0, some])
        when = slice(None, None, -(-len(self.t) // max(MOST // columns, FEWEST)))
        x, f = self.x[when, :, some], self.f[when, :, some]
        B, size = self.B[when, some], self.size[:, :, when, some]
        return EquationRates(self.t[when], x, f, B, self.rows, self.core, size)


# Cached, as it is the same for all schemes of a form.
@lru_cache(maxsize=8)
def equation_rates(view: Problem, equation: Equation) -> EquationRates:
    """Return the rates at the states that solutions reach.

    Parameters
    ----------
    view : Problem
    equation : Equation
        Ito equation of the comparable components.
    """
    t, x = reached_states(view, equation)
    h = LONGER[0] * time_unit(view)
    # Steps of all sizes begin at multiples of the coarse size, after the first step and before the last one.
    t = h * np.clip(np.floor(t / h), 1.0, np.floor(view.horizon / h) - 2.0)
    return rates_at(view, equation, t, x)


def rates_at(view: Problem, equation: Equation, t: Array, x: Array) -> EquationRates:
    """Return the rates at given states.

    Parameters
    ----------
    view : Problem
    equation : Equation
        Ito equation of the comparable components.
    t : ndarray, shape (n,)
    x : ndarray, shape (n, d, S)
    """
    d, S = x.shape[1:]
    with np.errstate(all="ignore"):
        f = np.stack([np.broadcast_to(equation.drift(s, y), y.shape) for s, y in zip(t.tolist(), x, strict=True)])
        shape = d, equation.noise_dim, S
        columns = [np.broadcast_to(equation.diffusion(s, y), shape) for s, y in zip(t.tolist(), x, strict=True)]
        B = np.moveaxis(np.stack(columns), -1, 1)
        names = dict(equation.names or {"x": slice(None)})
        found = EquationRates(t, x, f, B, names, core(equation, names, cloud(view, equation)), np.empty(0))
        # Pure outputs may be large, and no scheme bounds a step by their drift.
        shortest = FINER[-1] * time_unit(view)
        moved = shortest * np.sqrt(sum((f[:, rows] ** 2).sum(axis=1) for rows in found.core_rows.values()))
        sizes = _sizes(time_unit(view), f, B @ B.swapaxes(2, 3), list(names.values()))
        return found._replace(size=np.where((sizes > 0.0) & (moved < MOVED), sizes, np.inf))


def _sizes(unit: float, f: Array, C: Array, rows: list[slice]) -> Array:
    """Return |f| + |B|/sqrt(unit) and |B|^2 of each component, or unit |f|^2 for components without noise."""
    drift = np.stack([np.linalg.norm(f[:, part], axis=1) for part in rows])
    noise = np.stack([np.linalg.norm(C[..., part, part], axis=(2, 3)) for part in rows])
    speed = drift + np.sqrt(noise / unit)
    typical = np.nanmedian(np.stack([speed, noise]), axis=(2, 3), keepdims=True)
    motion = np.stack([speed, np.where(typical[1] > 0.0, noise, unit * speed**2)])
    return np.asarray(motion + TYPICAL * np.nanmedian(motion, axis=(2, 3), keepdims=True))
