"""States and times at which a one-step map is probed: near the start, reached by solutions, and far out."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, Mask
from ...forms import Domain, Equation, Problem, outside
from ...numerics.linalg import all_finite, norm, solve
from .nodes import BATCH, SEED

# Number of points near the start of a random problem, whose coefficients have size 1, and their largest distance.
# Size: states.
POINTS_NEAR_START, NEAR_START = 2, 0.25
# Number of points of the cloud other than the initial state, in each of its two parts.
# Size: states.
PILOT, SCATTERED = 6, 6
# Size: of a step of the pilot.
PILOT_H = 2.0**-6
# Paths of the pilot that covers the reachable states, parts of the horizon with one recorded time each, steps in each
# part, and states probed at each time.
# Size: paths, times and states.
MANY, STRATA, A_STRATUM, PROBED = 64, 32, 4, 16
# Number of reached states at which orders are probed in addition to the cloud: for one component, one state in each
# interval of mass 1/47.
# Size: states.
SPREAD = 48
# Largest distance of points of the cloud from the start in each component, in multiples of its size or of the second
# smallest distance. If a law extends over powers of ten, steps at its outer states are too coarse, at any size
# probed, for schemes that tame a drift by its size.
# Size: of the set of states.
FARTHEST = 100.0
# Relative size of differences for the derivative of a stiff drift.
# Rounding: a forward difference errs by eps/1e-7 = 2e-9 and by 1e-7 of the second derivative.
DIFFERENCE = 1e-7
# Size: steps of the pilot.
FEWEST_STEPS, MOST_STEPS = 64, 256
# A point counts as on the manifold if its residual is below this part of the terms that cancel.
# Rounding: a converged projection leaves 64 eps = 1.4e-14 of them (Higham 2002, Lemma 3.1), one that did not converge
# more than a tenth of the last update that Newton's method accepts, `newton.SOLVED`.
CLOSE = 1e-10
# Size: states.
SIZE = 1 + PILOT + SCATTERED
# Time of the step as a part of the horizon: at 0, derivatives of the coefficients in time may vanish.
# Size: time of a step.
WHEN = 0.2
# A slow equation has a rate below the first per unit of time, and a horizon of at least the second in units of time.
# Size: of the unit of step sizes.
SLOW, LONG = 2.0**-6, 64.0
# A step does not resolve a coefficient if the mean second difference within the step exceeds the first part of its
# total variation in time, or of the second part of its size if that is larger.
# Theorem: elementary, for sin(w t) the mean is (8/pi) sin^2(w h/4) of a variation of 2: above 0.1 from w h = 1.14 on.
BENT, SMALL_PART = 0.1, 0.1
# Relative distance of states for difference quotients; a coefficient whose values at two times differ by less than
# the second, relative, does not depend on time.
# Rounding: a quotient errs by eps/1e-4 = 2e-12 and by 1e-4 of a second derivative; values of 64 operations err by
# 64 eps = 1.4e-14 (Higham 2002, Lemma 3.1).
NEARBY, SAME = 1e-4, 1e-12


def time_unit(view: Problem) -> float:
    """Return the unit of the step sizes of probes: the problem's unit of time, or the horizon if that is shorter.

    If an equation hardly changes in the unit of time and its horizon is long, defects of steps in this unit would be
    rounding. The result is then the largest power of two below the equation's own time scale.

    Parameters
    ----------
    view : Problem
        Problem in any form.
    """
    unit, equation = view.time_unit, view.equation()
    if equation is None or view.longest_unit < LONG * unit:
        return unit
    x = reached_states(view, equation).points
    if x.shape[1] < 2:
        return unit
    with np.errstate(all="ignore"):
        rate = max(_rate_in_state(equation, x), _rate_in_time(equation, x[:, ::A_STRATUM], unit))
    if not rate * unit < SLOW:
        return unit
    return float(np.exp2(np.floor(np.log2(min(view.longest_unit, 1.0 / rate if rate else np.inf)))))


def _rate_in_state(equation: Equation, x: Array) -> float:
    """Return a Lipschitz constant of f plus the square of that of B, from differences between and near states (d, S).

    Components are in units of their range: a position may be 1e8 while a velocity is 10.
    """
    spread = np.abs(x - x[:, :1]).max(axis=1, keepdims=True)
    unit = np.where(spread > 0.0, spread, 1.0)
    rng = np.random.Generator(np.random.Philox(key=SEED + 11))
    near = x + NEARBY * unit * rng.uniform(-1.0, 1.0, x.shape)
    others = np.concatenate([near, np.roll(x, 1, axis=1)], axis=1)
    here, there = (_coefficients(equation, 0.0, points) for points in (x, others))
    size, l = norm((others - np.tile(x, 2)) / unit), len(here[1]) // len(x)
    units = unit, np.repeat(unit, l, axis=0)
    of_f, of_B = (norm((b - np.tile(a, 2)) / u) / size for a, b, u in zip(here, there, units, strict=True))
    rates = (of_f + of_B**2)[size > 0.0]
    return float(rates.max(initial=0.0)) if np.isfinite(rates).all() else np.inf


def _rate_in_time(equation: Equation, x: Array, unit: float) -> float:
    """Return the largest relative change of f and B per unit of time, relative to their total variation."""
    times = _spread_times(equation.horizon - unit, SEED + 12)
    now, later = (_coefficients_at(equation, times + part, x) for part in (0.0, unit))
    change, span = np.abs(later - now).max(axis=0), np.ptp(now, axis=0)
    moves = change > SAME * np.abs(now).max(axis=0)
    rates = change[moves] / (span[moves] * unit)
    return float(rates.max(initial=0.0)) if np.isfinite(rates).all() else np.inf


@lru_cache(maxsize=64)
def follows_coefficients(view: Problem, h: float) -> bool:
    """Return whether steps of size h resolve the time dependence of the coefficients, at states that solutions reach.

    If a coefficient oscillates within a step, its value in the middle is, at most times, far from the mean of the
    values at the ends. The same holds at a jump, which affects few steps only.

    Parameters
    ----------
    view : Problem
    h : float
        Below the horizon; for longer steps the result is True.
    """
    equation = view.equation()
    if equation is None or not h < equation.horizon:
        return True
    x = reached_states(view, equation).points[:, :: STRATA * A_STRATUM]
    if not x.shape[1]:
        return True
    times = _spread_times(equation.horizon - h, SEED + 16)
    with np.errstate(all="ignore"):
        middle = _coefficients_at(equation, times + 0.5 * h, x)
        span = np.ptp(middle, axis=0)
        if not span.any():
            return True
        begin, end = (_coefficients_at(equation, times + part * h, x) for part in (0.0, 1.0))
        bend = np.abs(begin - 2.0 * middle + end).mean(axis=0)
    return not bool((bend > BENT * np.maximum(span, SMALL_PART * np.abs(middle).mean(axis=0))).any())


def _spread_times(last: float, seed: int) -> Array:
    """Return a random time in each of `STRATA` equal parts of [0, last]."""
    rng = np.random.Generator(np.random.Philox(key=seed))
    return np.asarray(last * (np.arange(STRATA) + rng.uniform(size=STRATA)) / STRATA)


def _coefficients_at(equation: Equation, times: Array, x: Array) -> Array:
    """Return f and all entries of B at each time, stacked, shape (times, d + d l, S)."""
    return np.stack([np.concatenate(_coefficients(equation, t, x)) for t in times.tolist()])


def _coefficients(equation: Equation, t: float, x: Array) -> tuple[Array, Array]:
    """Return f, shape (d, S), and all entries of B, stacked, shape (d l, S)."""
    f, B = np.broadcast_to(equation.drift(t, x), x.shape), equation.diffusion(t, x)
    wide = np.broadcast_to(B, (*B.shape[:2], x.shape[1]))
    return f, wide.reshape(-1, x.shape[1])


@lru_cache(maxsize=8)
def cloud(view: Problem, ito: Equation) -> Array:
    """Return the probe states: the initial state, points of pilot paths, and points scattered around them.

    The pilot is Euler-Maruyama with h = 2^-6 of the unit of time or, on a shorter horizon, 64 steps; it ends after
    256 steps. Six paths are recorded at one of six times each. The scattered points are these, displaced at random by
    as much as the pilot has moved. On a constrained problem all points are projected onto the manifold, and
    velocities onto the tangent space. The initial state replaces a point where the projection fails, or where drift
    or diffusion are not finite.

    If the drift of a step is larger than the state, the equation is stiff, and explicit steps would reach states that
    no solution has: the pilot is then linearly implicit, x+ = x + (1 - h Df)^{-1} (h f + B dW).

    Parameters
    ----------
    view : Problem
        Problem with its constraints, if any.
    ito : Equation
        Ito equation of its comparable components.

    Returns
    -------
    ndarray, shape (d, 13)
    """
    rng = np.random.Generator(np.random.Philox(key=SEED + 1))
    start = ito.initial(1)
    with np.errstate(all="ignore"):
        # Each path is taken at another time.
        pilot = _not_too_far(start, np.einsum("kdk->dk", _pilot(ito, time_unit(view), rng, view.domain)))
        spread = np.abs(pilot - start).max(axis=1, keepdims=True)
        scattered = pilot + np.where(spread > 0.0, spread, 1.0) * rng.uniform(-1.0, 1.0, (len(start), SCATTERED))
        points = np.concatenate([pilot, _brought_back(view, scattered)], axis=1)
        if view.has_constraints:
            points = view.admissible(points)
        found = np.concatenate([start, np.where(is_allowed(view, ito, points), points, start)], axis=1)
    # All schemes on a problem share the array, so it is read-only.
    found.flags.writeable = False
    return found


def _brought_back(view: Problem, points: Array) -> Array:
    """Return points (d, S) with random states of the domain in place of those outside."""
    if view.domain is None:
        return points
    return view.domain.keep(points, view.domain.draw(*points.shape))


def _not_too_far(start: Array, points: Array) -> Array:
    """Return points (d, S) moved towards the start if they are farther from it than `FARTHEST` allows."""
    moved = points - start
    # The second smallest distance, because a single point may be near the start by chance.
    most = FARTHEST * np.maximum(np.abs(start), np.sort(np.abs(moved), axis=1)[:, 1:2])
    share = np.where(np.abs(moved) > most, most / np.abs(moved), 1.0).min(axis=0)
    return np.asarray(np.where(share < 1.0, start + share * moved, points))


def is_allowed(view: Any, ito: Equation, points: Array) -> Mask:
    """Return which points (d, S) are on the manifold and in the domain, with finite drift and diffusion.

    Parameters
    ----------
    view : Problem
        Problem in the scheme's form; its constraints define the manifold, its domain the allowed states.
    ito : Equation
        Equation whose coefficients have to be finite.
    points : ndarray, shape (d, S)
    """
    f, B = ito.drift(0.0, points), ito.diffusion(0.0, points)
    good = all_finite(points) & all_finite(f) & all_finite(B.reshape(-1, B.shape[-1])) & ~outside(view, points)
    if view.has_constraints:
        for value, scale in view.residuals(view.parts(view.state(points))).values():
            good &= (np.abs(value) <= CLOSE * scale).all(axis=0)
    return good


class ReachedStates(NamedTuple):
    """States that solutions reach, at one time in each of several equal parts of the run.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times, ascending; neither 0 nor the end.
    x : ndarray, shape (n, d, S)
        States at each time; NaN where the equation is not finite or the projection onto the manifold fails.
    """

    t: Array
    x: Array

    @property
    def points(self) -> Array:
        """All finite states of all times, shape (d, N)."""
        wide = np.moveaxis(self.x, 0, 1).reshape(self.x.shape[1], -1)
        return np.asarray(wide[:, all_finite(wide)])


@lru_cache(maxsize=8)
def reached_states(view: Problem, ito: Equation) -> ReachedStates:
    """Return states of pilot paths at a random time in each of 32 parts of the horizon, projected onto the manifold.

    Of 64 paths, those with the largest and the smallest value of a component, in turn for all components, and further
    random ones are selected: a region that one path in 64 visits is found, and each path is selected at some times.

    Parameters
    ----------
    view : Problem
        Problem with its constraints, if any.
    ito : Equation
        Ito equation of its comparable components.

    Returns
    -------
    ReachedStates
    """
    rng = np.random.Generator(np.random.Philox(key=SEED + 10))
    normals = rng.standard_normal((STRATA * A_STRATUM, ito.noise_dim, MANY))
    h = ito.horizon / len(normals)
    kept = A_STRATUM * np.arange(STRATA) + rng.integers(1, A_STRATUM + 1, STRATA)
    with np.errstate(all="ignore"):
        points = _follow_pilot(ito, h, normals, kept, view.domain)
        found = np.stack([x[:, _extremes(x, k, rng)] for k, x in enumerate(points)])
        wide = np.moveaxis(found, 0, 1).reshape(found.shape[1], -1)
        if view.has_constraints:
            wide = view.admissible(wide)
        wide = np.where(is_allowed(view, ito, wide), wide, np.nan)
    t = h * (kept - rng.uniform(0.0, 1.0, STRATA))
    return ReachedStates(t, np.moveaxis(wide.reshape(-1, STRATA, PROBED), 1, 0))


def _extremes(x: Array, place: int, rng: np.random.Generator) -> Array:
    """Return the indices of random paths, and of those with the largest and smallest value of one component."""
    row = np.nan_to_num(x[place % len(x)])
    return np.append(rng.choice(x.shape[1], PROBED - 2, replace=False), [row.argmax(), row.argmin()])


# Cached, because it is the same for all schemes of a form.
@lru_cache(maxsize=16)
def spread_states(view: Problem, ito: Equation, most: int = SPREAD) -> Array:
    """Return reached states at equidistant ranks of each component, from its smallest to its largest value.

    The reached states are sorted by a component and every k-th one is selected, so that each interval of that
    component with at least k of them contains a selected state. A region of another shape is missed with about the
    probability with which random states miss it.

    Parameters
    ----------
    view : Problem
        Problem with its constraints, if any.
    ito : Equation
        Ito equation of its comparable components.
    most : int
        Number of states, divided among the components; of more than most/2 components, a random subset is used.

    Returns
    -------
    ndarray, shape (d, S)
        S is at most `most`; states selected for several components appear once.
    """
    x = reached_states(view, ito).points
    d, count = x.shape
    rng = np.random.Generator(np.random.Philox(key=SEED + 17))
    rows = np.arange(d) if 2 * d <= most else rng.choice(d, most // 2, replace=False)
    ranks = np.linspace(0, count - 1, min(most // max(len(rows), 1), count)).astype(int)
    found = x[:, np.unique(np.argsort(x[rows], axis=1, kind="stable")[:, ranks])]
    found.flags.writeable = False
    return found


def states_near_start(view: Problem, equation: Equation) -> Array:
    """Return the initial state and points near it, projected onto the manifold of a problem with constraints.

    Parameters
    ----------
    view : Problem
    equation : Equation
        Ito equation of its comparable components.

    Returns
    -------
    ndarray, shape (d, 3)
        A point at which the projection fails is replaced by the initial state.
    """
    start = equation.initial(1)
    rng = np.random.Generator(np.random.Philox(key=SEED + 18))
    points = start + NEAR_START * rng.uniform(-1.0, 1.0, (len(start), POINTS_NEAR_START))
    with np.errstate(all="ignore"):
        if view.has_constraints:
            points = view.admissible(points)
        return np.concatenate([start, np.where(is_allowed(view, equation, points), points, start)], axis=1)


def in_batches(x: Array, nodes: int) -> list[Array]:
    """Split states, shape (d, S), so that a call with `nodes` nodes at each has at most `BATCH` paths."""
    return np.array_split(x, max(min(-(-x.shape[1] * nodes // BATCH), x.shape[1]), 1), axis=1)


def _pilot(ito: Equation, unit: float, rng: np.random.Generator, domain: Domain | None) -> Array:
    """Return the states of the pilot's paths at six times, shape (6, d, P)."""
    longest = PILOT_H * max(unit, 1.0)
    steps = int(np.clip(np.ceil(ito.horizon / longest), FEWEST_STEPS, MOST_STEPS))
    h, normals = min(ito.horizon / steps, longest), rng.standard_normal((steps, ito.noise_dim, PILOT))
    return _follow_pilot(ito, h, normals, np.linspace(steps / PILOT, steps, PILOT).astype(int), domain)


def _follow_pilot(ito: Equation, h: float, normals: Array, kept: Array, domain: Domain | None) -> Array:
    """Return pilot states after some numbers of steps, shape (K, d, P); the start for paths that are not finite.

    A step that leaves the domain is not made.
    """

    def simulate(*, implicit: bool) -> tuple[Array, bool]:
        """Return the states, and whether the drift of a step exceeded the state."""
        x, stiff = ito.initial(normals.shape[-1]), False
        points = np.empty((len(kept), *x.shape))
        for step, xi in enumerate(normals):
            t = step * h
            drift, kick = np.broadcast_to(h * ito.drift(t, x), x.shape), ito.diffused(t, x, np.sqrt(h) * xi)
            if not (implicit or stiff):
                size = norm(x)
                stiff = bool(((size > 0.0) & (norm(drift) > size)).any())
            new = x + (solve(_implicit_matrix(ito, t, x, h), drift + kick) if implicit else drift + kick)
            x = new if domain is None else domain.keep(new, x)
            points[kept == step + 1] = x
        return points, stiff

    points, stiff = simulate(implicit=False)
    if stiff:
        points, _ = simulate(implicit=True)
    return np.where(np.isfinite(points).all(axis=1, keepdims=True), points, ito.initial(normals.shape[-1]))


def _implicit_matrix(ito: Equation, t: float, x: Array, h: float) -> Array:
    """Return 1 - h Df, shape (d, d, P), by differences: states of the cloud need not be accurate."""
    d, size = len(x), DIFFERENCE * (1.0 + norm(x))
    moved = x[:, None] + size * np.eye(d)[..., None]
    there = np.broadcast_to(ito.drift(t, moved.reshape(d, -1)), (d, d * x.shape[1])).reshape(moved.shape)
    return np.eye(d)[..., None] - h * (there - ito.drift(t, x)[:, None]) / size


SIZES = 10.0 ** np.arange(0.0, 8.5, 0.5)


def extreme_states(view: Problem, ito: Equation) -> Array:
    """Return the cloud of states, and its scattered points scaled to the sizes 1, 10^(1/2), ..., 10^8.

    In constrained mechanics only velocities are scaled, which remain tangent; in an equation without constraints, the
    whole state. For other constraints only the cloud is returned. States at which drift or diffusion are not
    finite are omitted.

    Parameters
    ----------
    view : Problem
        Problem with its constraints, if any.
    ito : Equation
        Ito equation of its comparable components.

    Returns
    -------
    ndarray, shape (d, S)
    """
    x = cloud(view, ito)
    rows = view.free_rows
    base = x[:, -SCATTERED:]
    with np.errstate(all="ignore"):
        length = norm(base[rows])
        far = np.repeat(base, len(SIZES), axis=1)
        far[rows] *= (SIZES / np.where(length > 0.0, length, 1.0)[:, None]).ravel()
        states = np.concatenate([x, far], axis=1) if len(base[rows]) else x
        return np.asarray(states[:, is_allowed(view, ito, states)])
