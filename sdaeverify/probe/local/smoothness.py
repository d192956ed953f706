"""Smoothness of observables and coefficients where solutions are, which single-step results require.

Local weak orders are about expectations of smooth functions. For a function with a jump or a kink, the error of a
discrete law is that of a lattice: of order 1/2, or 1, for any order on smooth functions. Local orders of all
kinds hold for smooth coefficients: for dx = (1 + |x|/2) dW Milstein's scheme has order 3/4, but one step from any x
except 0 shows order 1.

The observable, or the coefficient, q is evaluated along lines: between two states, or through one state over the
distance that solutions move in a step. On intervals [a, b] that are halved towards the largest change of q,

    |q(b) - q(a)|                       decreases with the length l of the interval, but not across a jump;
    |q(a) - 2 q((a + b)/2) + q(b)|/l    decreases like l, but not across a kink.

Only differences above rounding count. A coefficient that is computed by differences, such as the curvature of a
constraint without `jacobian`, has a thousand times the rounding error of a formula, which tiny differences on the
line measure. The rounding of the points is added: on a line that is short relative to its states they lie on a grid.

Coefficients are also evaluated along time, at some of the states: if one jumps between two mesh points, the
step across the jump has an error of h in the mean, or of h^(1/2) for a jump of the diffusion.
"""

from collections.abc import Callable
from enum import StrEnum
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...forms import Equation, Problem
from ...numerics.statistics import EPS
from ..step.nodes import SEED
from ..step.states import WHEN, reached_states, time_unit

# Number of lines between states, and of initial intervals of each line.
# Size: lines and intervals.
LINES, CUTS = 64, 32
# Number of lines through states at each time, and of initial intervals. To both sides they extend as far as a
# solution moves in a step of this size, in units of time, so that they stay near a manifold of the states.
# Size: lines and intervals.
AT_A_TIME, SHORT_CUTS, SHORT = 4, 8, 2.0**-6
# Parts of the horizon on which a coefficient is followed in time, initial intervals of each, and number of states.
# Size: lines and intervals.
TIME_LINES, TIME_CUTS, AT_STATES = 8, 16, 4
# Halvings towards a jump, and towards a kink; the last ones show whether differences decrease. After more halvings a
# difference of order l^2 would be rounding.
HALVINGS, LAST = {1: 36, 2: 14}, 6
# Differences that decrease like l^r with r < 1/2 count as constant, those that increase like l^-r with r > 1/4 as
# growing.
# Theorem: elementary, r is 0 at a jump and 1 on a slope, and per length 0 at a kink and -1/2 at a root: halfway.
FALLS, GROWS = 2.0 ** (-0.5 * LAST), 2.0 ** (0.25 * LAST)
# A jump, or a change of slope, is detected from this part of the observable's change on the line on, above rounding.
# Size: of the jumps that are looked for.
# Rounding: 64 operations err by at most 64 eps of their sizes (Higham 2002, Lemma 3.1).
SMALL, ROUNDINGS = 1e-6, 64.0
# Second differences with this step, in units of the line, are rounding only; at other points they may be a few times
# larger by chance. They are evaluated at this part of an interval, because simple formulas have kinks at its ends.
# Rounding: second differences of a function with curvature 1 are 2^-60, which is below eps.
# Size: of the sample; any part without a simple ratio to 1.
TINY, TIMES, BESIDE = 2.0**-30, 8.0, 0.37
# Number of random roundings of the points of a line.
# Size: roundings that are tried.
TRIALS = 4
# Order for which no coefficient needs derivatives in the state.
# Theorem: Milstein 1988, Theorem 1.
LIPSCHITZ_ORDER = 0.5


class Smoothness(StrEnum):
    """Smoothness of an observable on the states that runs reach."""

    SMOOTH = "smooth"
    KINK = "a kink"
    JUMP = "a jump"


@lru_cache(maxsize=256)
def smoothness(view: Problem, observable: str) -> Smoothness:
    """Return whether an observable has jumps or kinks at the final time between states that solutions reach.

    An observable that needs an unknown component is taken as smooth.

    Parameters
    ----------
    view : Problem
    observable : str
    """
    value, states = _in_states(view, observable)
    rng = np.random.Generator(np.random.Philox(key=SEED + 12))
    ends = states[:, rng.integers(states.shape[1], size=(2, LINES))]
    with np.errstate(all="ignore"):
        if follow(ends, CUTS, value, 1)[0]:
            return Smoothness.JUMP
        return Smoothness.KINK if follow(ends, CUTS, value, 2)[0] else Smoothness.SMOOTH


class Roughness(NamedTuple):
    """A coefficient that is not smooth where solutions are.

    Attributes
    ----------
    coefficient : str
        ``drift`` or ``diffusion``.
    lipschitz : bool
        Whether it is Lipschitz continuous in the state, so that convergence still follows from single steps.
    in_time : bool
        Whether it jumps in time; otherwise it has a kink in the state, or a worse singularity if it is not Lipschitz.
    """

    coefficient: str
    lipschitz: bool
    in_time: bool = False

    @property
    def highest(self) -> float:
        """Highest order on paths that single steps can still establish."""
        # A step across the jump has an error of h, which is a global error of order 1.
        if self.in_time and self.coefficient == "drift":
            return 1.0
        return LIPSCHITZ_ORDER if self.lipschitz else 0.0

    def __str__(self) -> str:
        """Return the coefficient and its singularity in words."""
        found = "a kink" if self.lipschitz and not self.in_time else "an infinite slope or a jump"
        return f"the {self.coefficient} has {found}{' in time' if self.in_time else ''}"


@lru_cache(maxsize=32)
def rough_coefficient(view: Problem) -> Roughness | None:
    """Return the least smooth coefficient of an equation near states that solutions reach; None if all are smooth.

    Solutions come near a kink before they cross it, and sqrt(max(x, 0)) has a kink for solutions near 0. So each line
    goes through a state, in the direction in which a solution moves from it, as far as it moves in a step.

    Parameters
    ----------
    view : Problem
        Problem without delay, see `remove_delay`.
    """
    equation = view.equation()
    if equation is None:
        return None
    rng = np.random.Generator(np.random.Philox(key=SEED + 14))
    with np.errstate(all="ignore"):
        ends = _around(view, equation, rng)
        # Random weights, so that the kink of one entry does not cancel that of another.
        f, *B = rng.standard_normal((1 + equation.noise_dim, equation.dimension, 1))
        time, b = WHEN * equation.horizon, np.stack(B, axis=1) if B else np.zeros((equation.dimension, 0, 1))
        sums: dict[str, Callable[[Array], Array]] = {
            "drift": lambda x: np.asarray((f * equation.drift(time, x)).sum(axis=0)),
            "diffusion": lambda x: np.asarray((b * equation.diffusion(time, x)).sum(axis=(0, 1))),
        }
        found = {name: follow(ends, SHORT_CUTS, q, 2) for name, q in sums.items()}
        rough = [Roughness(name, not grows) for name, (persists, grows) in found.items() if persists]
        rough += _rough_in_time(equation, reached_states(view, equation).points, f, b)
    return min(rough, key=lambda each: (each.highest, not each.in_time), default=None)


def _rough_in_time(equation: Equation, points: Array, f: Array, b: Array) -> list[Roughness]:
    """Return the coefficients with a jump or an infinite slope in time; a kink in time limits no order up to 3/2.

    Parameters
    ----------
    equation : Equation
    points : ndarray, shape (d, N)
        States that solutions reach.
    f, b : ndarray, shapes (d, 1) and (d, l, 1)
        Weights of the entries of drift and diffusion.
    """
    x = points[:, :: max(1, points.shape[1] // AT_STATES)]
    weights = np.cos(1.0 + np.arange(x.shape[1]))
    sums: dict[str, Callable[[float], float]] = {
        "drift": lambda t: float((weights * f * equation.drift(t, x)).sum()),
        "diffusion": lambda t: float((weights * (b * equation.diffusion(t, x)).sum(axis=(0, 1))).sum()),
    }
    # Not at simple fractions of the horizon, where jumps tend to be: at an end they could not be distinguished from
    # rounding of the time.
    edges = equation.horizon * np.append((np.arange(TIME_LINES) + BESIDE) / TIME_LINES, 1.0)
    edges[0] = 0.0
    ends = np.stack([edges[:-1], edges[1:]])[None]

    def rough(at: Callable[[float], float]) -> bool:
        def values(t: Array) -> Array:
            return np.array([at(s) for s in t.ravel().tolist()])

        # Most equations do not depend on time, which this test detects quickly.
        changes = np.ptp(values(np.linspace(0.0, equation.horizon, TIME_LINES * TIME_CUTS + 1))) != 0.0
        return bool(changes) and follow(ends, TIME_CUTS, values, 2)[1]

    return [Roughness(name, lipschitz=True, in_time=True) for name, at in sums.items() if rough(at)]


def _around(view: Problem, equation: Equation, rng: np.random.Generator) -> Array:
    """Return both ends of lines through states that solutions reach, shape (d, 2, L)."""
    t, x = reached_states(view, equation)
    h, ends = SHORT * time_unit(view), []
    for time, states in zip(t.tolist(), x[..., -AT_A_TIME:], strict=True):
        noise = np.sqrt(h) * rng.standard_normal((equation.noise_dim, states.shape[1]))
        move = h * equation.drift(time, states) + equation.diffused(time, states, noise)
        both = [states - move, states + move]
        if view.domain is not None:
            both = [view.domain.farthest(states, end) for end in both]
        ends.append(np.stack(both, axis=1))
    found = np.concatenate(ends, axis=2)
    return np.asarray(found[..., np.isfinite(found).all(axis=(0, 1))])


def _in_states(view: Any, observable: str) -> tuple[Callable[[Array], Array], Array]:
    """Return the observable as a function of states (d, P), and states that solutions reach."""
    ito, start = view.ito(), view.parts(view.initial(1))
    sizes = {name: len(part) for name, part in start.items()}
    ends = np.cumsum(list(sizes.values()))

    def parts(x: Array) -> dict[str, Array]:
        if ito is not None:
            return dict(ito.parts(x))
        return {name: x[end - sizes[name] : end] for name, end in zip(sizes, ends, strict=True)}

    def value(x: Array) -> Array:
        found = view.observe(observable, view.horizon, parts(x))
        return np.asarray(np.broadcast_to(np.asarray(0.0 if found is None else found, dtype=float), x.shape[1:]))

    if ito is not None:
        return value, reached_states(view, ito).points
    x = np.concatenate(list(start.values()))
    rng = np.random.Generator(np.random.Philox(key=SEED + 13))
    return value, x + (1.0 + np.abs(x)) * rng.standard_normal((len(x), LINES))


def follow(ends: Array, cuts: int, q: Callable[[Array], Array], order: int) -> tuple[bool, bool]:
    """Return whether the largest differences of q on lines, per interval length, persist, and whether they grow.

    Parameters
    ----------
    ends : ndarray, shape (d, 2, L)
        Ends of the lines.
    cuts : int
        Number of initial intervals of each line.
    q : callable
    order : int
        Order of the differences, 1 or 2.
    """
    count = ends.shape[2]
    if not count:
        return False, False
    length, left = 1.0 / cuts, np.repeat(np.arange(cuts)[:, None] / cuts, count, axis=1)
    values = _values(ends, q, left)
    span, size = np.ptp(values, axis=0), np.abs(values).max(axis=0)
    followed = list[Array]()
    for _ in range(HALVINGS[order] + 1):
        at = left + length * np.linspace(0.0, 1.0, order + 1)[:, None, None]
        found = np.abs(np.diff(_values(ends, q, at), order, axis=0)[0]) / length ** (order - 1)
        found = np.nan_to_num(found, nan=0.0, posinf=0.0)
        steepest = found.argmax(axis=0)
        followed.append(found.max(axis=0))
        if len(followed) > LAST and not (followed[-1] > SMALL * span).any():
            break
        left = left[steepest, np.arange(count)] + 0.5 * length * np.array([0.0, 0.5, 1.0])[:, None]
        length *= 0.5
    before, last = followed[-1 - LAST], followed[-1]
    rounding = TIMES * (_rounding(ends, cuts, q) + _rounding_of_points(ends, q))
    rounding = np.maximum(ROUNDINGS * EPS * size, rounding)
    seen = last > np.maximum(SMALL * span, rounding / (2.0 * length) ** (order - 1))
    persists, grows = (bool((seen & (last > part * before)).any()) for part in (FALLS, GROWS))
    return persists, grows


def _rounding(ends: Array, cuts: int, q: Callable[[Array], Array]) -> Array:
    """Return the largest second differences of q that are due to rounding, shape (L,), from one in each interval."""
    at = (np.arange(cuts) + BESIDE)[:, None] / cuts + TINY * np.arange(3.0)[:, None, None]
    found = np.diff(_values(ends, q, np.repeat(at, ends.shape[2], axis=2)), 2, axis=0)[0]
    return np.asarray(np.nan_to_num(np.abs(found), nan=0.0, posinf=0.0).max(axis=0))


def _rounding_of_points(ends: Array, q: Callable[[Array], Array]) -> Array:
    """Return the largest change of q at the ends if each component is rounded up or down, shape (L,)."""
    rng = np.random.Generator(np.random.Philox(key=SEED + 15))
    x = ends.reshape(len(ends), -1)
    moved, here = x * (1.0 + EPS * rng.choice([-1.0, 1.0], size=(TRIALS, *x.shape))), q(x)
    change = np.nan_to_num(np.abs([q(each) - here for each in moved]), posinf=0.0).max(axis=0)
    return np.asarray(np.broadcast_to(change, x.shape[1]).reshape(2, -1).max(axis=0))


def _values(ends: Array, q: Callable[[Array], Array], s: Array) -> Array:
    """Return q at the points with line parameters s, shape (..., L)."""
    first, second = ends[:, 0], ends[:, 1]
    wide = s.reshape(-1, s.shape[-1])
    points = first[:, None] + wide * (second - first)[:, None]
    values = np.broadcast_to(q(points.reshape(len(first), -1)), wide.size)
    return np.asarray(values.reshape(s.shape))
