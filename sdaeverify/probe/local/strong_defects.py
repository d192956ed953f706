"""Local strong defects: one step against two half steps, at cubature nodes of the noise.

At a state x, with the noise xi = (xi_1, xi_2) of two half steps at Gauss-Hermite nodes,

    d_self = Phi_h(x; xi) - Phi_{h/2}(Phi_{h/2}(x; xi_1); xi_2).
"""

from collections.abc import Iterator
from functools import lru_cache, partial
from itertools import islice, product
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask, each
from ...contracts.scheme import Scheme, State
from ...forms import Problem
from ...noise.brownian import Increment
from ...numerics.digits import SCALE, keep_defined, significant
from ..step.component_units import component_units
from ..step.nodes import COUNTS, FEWEST, SEED, HalfSteps, Nodes, Rule, fifth_degree_rule, half_steps, resolving_rule
from ..step.one_step import OneStep, why_not_resolved
from ..step.states import SPREAD, in_batches, spread_states, time_unit
from ..step.times import ProbeTime, times
from ..step.together import PathBatch, together
from .orders import ROUNDING, SETTLED, TOLERANCE, last_orders
from .reach import reach

# Step sizes 4^-2, ..., 4^-8 of the horizon, or of the unit of time if that is shorter.
LEVELS = 4.0 ** -np.arange(2.0, 9.0)
# Number of coarsest step sizes that are left out for given states: an order is taken from the finest ones.
# Size: step sizes.
NOT_ASYMPTOTIC = 2
# Finer step sizes, used if a defect of the size of a solver's tolerance decreases more slowly than before.
FINER = 4.0 ** -np.arange(9.0, 12.0)
# Much shorter step sizes, down to rounding, used if no order is seen at the others.
SHORTEST = 4.0 ** -np.arange(12.0, 19.0)
# Largest product of states, nodes and components: steps of many components, implicit ones above all, are expensive.
# The number of states is reduced accordingly, but not below the second number.
# Size: states times nodes times components.
WORK, LEAST_STATES = 80_000, 2
# The same for further states, and the nodes of each of two variables there.
# Size: the same.
FURTHER_WORK, FEW_NODES = 20_000, 4
# States with random nodes, and the least and the largest number of these: 0.99^256 = 0.08 is the probability that all
# miss a share of 1/100 of the noise.
# Size: states and nodes.
FEW_STATES, FEW_RANDOM, MANY_RANDOM = 4, 64, 256
# Numbers of variables for which a rule of degree 5 has fewer nodes than three per variable.
# Theorem: 2^n + 2 n < 3^n from n = 3 on (Stroud 1971).
SMALL = range(3, len(COUNTS) + 1)
# Groups of states with the nodes of steps from these.
Groups = tuple[tuple[Array, HalfSteps], ...]
# Root mean squares and means of the defects of steps, and the other results of `_defects_of`.
Defects = tuple[Array, ...]
# Value of `LocalStrong.means` for a rule of degree 3.
# Size: no number, but a mark of a record.
UP_TO_1 = 0.5


class LocalStrong(NamedTuple):
    """Defects of one step for C components, S states and H step sizes; times count as separate states.

    Attributes
    ----------
    h : ndarray, shape (H,)
        Seven, or ten if a defect of the size of a solver's tolerance decreases more slowly than before.
    rms, mean : ndarray, shape (C, S, H)
        ||d_self||_{L2} and |E d_self| over the rows of each component, in its unit.
    turned : ndarray, shape (C, S, H)
        1 if E d_self points away from its direction at the previous step size, so that it is near 0 between the two.
    scale : ndarray, shape (S, H)
        Largest absolute value of the components before and after the step.
    reached : ndarray, shape (C, C)
        1 in row i and column j if errors of component j affect component i, see `reach`.
    means : ndarray, shape ()
        1 if the nodes are a rule of degree 5, 1/2 for degree 3, which resolves means up to order 1.
    times : ndarray, shape ()
        Number of times; states of the same time are contiguous.
    near : ndarray, shape ()
        Number of states per time that belong to `cloud`; they come first, those of `spread_states` follow.
    """

    h: Array
    rms: Array
    mean: Array
    turned: Array
    scale: Array
    reached: Array
    means: Array
    times: Array
    near: Array

    @property
    def groups(self) -> list[Mask]:
        """Masks, shape (S,) each, of the states of `cloud` and, if there are any, of the further states."""
        times = int(self.times)
        near = np.tile(np.arange(len(self.scale) // times) < self.near, times)
        return [near] if near.all() else [near, ~near]


def why_not_local_order(scheme: Scheme, view: Problem) -> str:
    """Return why a scheme has no local strong order on a problem, or an empty string."""
    if scheme.law.bounded:
        return f"sums of {scheme.law.name} increments do not have the law of the increments of a longer step"
    shortest = float(LEVELS[-1]) * time_unit(view)
    step = OneStep(scheme, view)
    return (
        why_not_resolved(view, shortest)
        or step.why_not_probed(beside=True, levy=True)
        or step.why_not_sound(_last_but_one(view))
    )


def why_not_from(step: OneStep, x: Array) -> str:
    """Return why no step from the states x, shape (d, S), shows an order, or an empty string."""
    return step.why_not_sound(_last_but_one(step.view), x)


@lru_cache(maxsize=4)
def local_strong(scheme: Scheme, view: Problem, *, shortest: bool = False) -> LocalStrong:
    """Compute the defects of one step of each size from each probe state, at each probe time.

    Cached, because several measures need the result.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_local_order` is empty for the pair.
    shortest : bool
        Whether to use the step sizes `SHORTEST` instead of `LEVELS`.

    Returns
    -------
    LocalStrong
    """
    step = OneStep(scheme, view)
    x = step.usable_states(_last_but_one(view))
    nodes = _half_step_nodes(step)
    x = _affordable(x, len(nodes.whole.weights))
    further = _further(step)
    groups, when = ((x, nodes), further, _scattered(step, further[0])), times(step, x)
    with np.errstate(all="ignore"):
        record = _defects_at(step, groups, when, (SHORTEST if shortest else LEVELS) * step.time_unit)
        if shortest or not _slows_down(record):
            return record
        return _join_levels(record, _defects_at(step, groups, when, FINER * step.time_unit))


def local_strong_from(scheme: Scheme, view: Problem, x: Array) -> LocalStrong:
    """Compute the defects of one step of each size from given states, at a fifth of the horizon.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    x : ndarray, shape (d, S)

    Returns
    -------
    LocalStrong
    """
    step = OneStep(scheme, view)
    groups, when = ((x, _half_step_nodes(step)),), (ProbeTime(step.time),)
    with np.errstate(all="ignore"):
        return _defects_at(step, groups, when, LEVELS[NOT_ASYMPTOTIC:] * step.time_unit)


def _half_step_nodes(step: OneStep) -> HalfSteps:
    areas, motions = "H" in step.scheme.noise, step.view.noise_dim
    count = COUNTS.get(motions * (4 if areas else 2), FEWEST)
    return half_steps(motions, count, areas=areas, levy="A" in step.scheme.noise)


def _defects_at(step: OneStep, groups: Groups, when: tuple[ProbeTime, ...], h: Array) -> LocalStrong:
    """Return the defects of steps of all sizes h from groups of states, those of `cloud` first, at some times."""
    x, nodes = groups[0]
    every = np.concatenate([states for states, _ in groups], axis=1)
    degree = 1.0 if nodes.whole.degree >= 5 else UP_TO_1
    counts = np.array(degree), np.array(float(len(when))), np.array(float(x.shape[1]))
    units = component_units(step, x, float(LEVELS[0]) * step.time_unit)[:, None, None]
    levels = _levels(step, groups, h.tolist(), when)
    rms, mean, means, scale = (np.stack(parts, axis=-1) for parts in zip(*levels, strict=True))
    turned = _find_turns(means, list(step.names.values()))
    rms, mean = keep_defined(rms / units, scale), keep_defined(mean / units, scale)
    scale = significant(scale, SCALE)
    begins = [[moment.of_size(step, size) for size in h.tolist()] for moment in when]
    truncated = np.concatenate([step.truncated(every, h, times) for times in begins])
    rms, mean = (np.where(truncated, np.nan, part) for part in (rms, mean))
    return LocalStrong(h, rms, mean, turned, scale, reach(step, x), *counts)


def _further(step: OneStep) -> tuple[Array, HalfSteps]:
    """Return reached states, with few nodes: they only show too low orders, while `cloud` gives the order."""
    areas, levy = "H" in step.scheme.noise, "A" in step.scheme.noise
    nodes = half_steps(step.view.noise_dim, FEW_NODES, areas=areas, levy=levy, rule=_small_rule)
    most = FURTHER_WORK // (step.equation.dimension * len(nodes.whole.weights))
    x = spread_states(step.view, step.equation, int(np.clip(most, LEAST_STATES, SPREAD)))
    return step.usable_states(_last_but_one(step.view), x), nodes


def _scattered(step: OneStep, x: Array) -> tuple[Array, HalfSteps]:
    """Return a few of the states x, with many random nodes: a step that is different in a small region of the noise.

    Root mean squares show it; the means of the defects are not resolved.
    """
    areas, levy = "H" in step.scheme.noise, "A" in step.scheme.noise
    count = int(np.clip(FURTHER_WORK // (step.equation.dimension * FEW_STATES), FEW_RANDOM, MANY_RANDOM))
    nodes = half_steps(step.view.noise_dim, count, areas=areas, levy=levy, rule=_random_rule)
    return x[:, :: max(1, x.shape[1] // FEW_STATES)][:, :FEW_STATES], nodes


def _random_rule(n: int, count: int) -> Rule:
    points = np.random.Generator(np.random.Philox(key=SEED + 22)).standard_normal((n, count))
    return Rule(points, np.full(count, 1.0 / count), exact=False, degree=0)


def _small_rule(n: int, count: int) -> Rule:
    """Return the smallest rule of degree 5 if there is one for n variables, else `resolving_rule`."""
    return fifth_degree_rule(n) if n in SMALL else resolving_rule(n, count)


def _affordable(x: Array, nodes: int) -> Array:
    """Return evenly spaced states, as many as the cost of steps of all components at all nodes allows."""
    count = max(WORK // (len(x) * nodes), LEAST_STATES)
    return x if count >= x.shape[1] else x[:, np.linspace(0, x.shape[1] - 1, count).astype(int)]


def _last_but_one(view: Problem) -> float:
    # An order needs the two finest step sizes.
    return float(LEVELS[-2]) * time_unit(view)


def _join_levels(a: LocalStrong, b: LocalStrong) -> LocalStrong:
    levels = zip(a[:5], b[:5], strict=True)
    h, rms, mean, turned, scale = (np.concatenate(pair, axis=-1) for pair in levels)
    return LocalStrong(h, rms, mean, turned, scale, *a[5:])


def _find_turns(means: Array, rows: list[slice]) -> Array:
    """Return where means (d, S, H) point away from their direction at the previous step size, by component."""
    products = np.concatenate([np.zeros_like(means[..., :1]), means[..., 1:] * means[..., :-1]], axis=-1)
    return np.stack([products[part].sum(axis=0) < 0.0 for part in rows]).astype(float)


def _slows_down(record: LocalStrong) -> bool:
    """Return whether a solver's tolerance shows, or may show at finer steps."""
    for part, group in product((record.rms, record.mean), record.groups):
        size, scale = part[:, group].max(axis=1), record.scale[group].max(axis=0)
        found = last_orders(record.h, size, ROUNDING * scale, scale)
        slower = (found.ahead < found.order - SETTLED) & (size[..., -1] < TOLERANCE * scale[-1])
        if (slower | (found.plateau_h > 0.0)).any():
            return True
    return False


class _Case(NamedTuple):
    # States, shape (d, S), the noise of two half steps from there, the size of the whole step, and its start.
    x: Array
    nodes: HalfSteps
    h: float
    t: float

    def at_distinct(self, nodes: Nodes, h: float) -> tuple[PathBatch, Array]:
        """Return a step of size h from every state at each distinct noise, and its index for each state and node."""
        states, (some, place) = self.x.shape[1], nodes.find_distinct()
        wide = np.repeat(self.x, len(some.weights), axis=1)
        places = (np.arange(states)[:, None] * len(some.weights) + place).ravel()
        return PathBatch(wide, self.t, h, some.increment(self.h, states)), places


def _levels(step: OneStep, groups: Groups, sizes: list[float], when: tuple[ProbeTime, ...]) -> list[Defects]:
    """Return root mean squares and means of the defects for each size, at all times; see `_defects_of`."""
    cases = [
        [_Case(*batch, h, moment.of_size(step, h)) for moment in when for batch in _batches(step, groups, h)]
        for h in sizes
    ]
    found = _defects(step, [case for level in cases for case in level])
    levels = [zip(*islice(found, len(level)), strict=True) for level in cases]
    return [tuple(np.concatenate(parts, axis=-1) for parts in level) for level in levels]


def _batches(step: OneStep, groups: Groups, h: float) -> Iterator[tuple[Array, HalfSteps]]:
    for x, made in groups:
        nodes = made.with_records(step.view.records, h)
        yield from ((states, nodes) for states in in_batches(x, len(nodes.whole.weights)) if states.size)


def _defects(step: OneStep, cases: list[_Case]) -> Iterator[Defects]:
    """Yield the defects of a step for each case, see `_defects_of`; the steps of all cases are made in few calls."""

    def first(x: Array, t: float, h: float, noise: Increment) -> State:
        return step.make(x, t, h, noise).state

    def second(state: State, t: float, h: float, noise: Increment) -> Array:
        return step.read(step.advance(state, t, h, noise))

    def halves() -> Iterator[PathBatch]:
        states = together(first, [batch for batch, _ in begun])
        for case, (_, places), state in zip(cases, begun, states, strict=True):
            half, noise = 0.5 * case.h, case.nodes.second.increment(case.h, case.x.shape[1])
            yield PathBatch(each(partial(np.take, indices=places, axis=-1), state), case.t + half, half, noise)

    whole = [case.at_distinct(case.nodes.whole, case.h) for case in cases]
    begun = [case.at_distinct(case.nodes.first, 0.5 * case.h) for case in cases]
    made = together(step, [batch for batch, _ in whole])
    for case, (_, places), wide, twice in zip(cases, whole, made, together(second, halves()), strict=True):
        yield _defects_of(step, case, np.abs(wide).max(axis=0), np.take(wide, places, axis=-1) - twice)


def _defects_of(step: OneStep, case: _Case, reached: Array, defects: Array) -> Defects:
    """Return the defects of a step.

    Parameters
    ----------
    reached : ndarray, shape (P,)
        Largest absolute value of the components after the step at distinct noise.
    defects : ndarray, shape (d, S K)
        d_self at all nodes.

    Returns
    -------
    ndarray, shape (C, S)
        Root mean squares.
    ndarray, shape (C, S)
        Norms of means.
    ndarray, shape (d, S)
        Means.
    ndarray, shape (S,)
        Scale.
    """
    states, weights = case.x.shape[1], case.nodes.whole.weights
    scale = np.maximum(np.abs(case.x).max(axis=0), reached.reshape(states, -1).max(axis=1))
    defects = defects.reshape(len(case.x), states, -1)
    means = defects @ weights * (case.nodes.whole.degree > 0)
    squares = defects**2 @ weights, means**2
    rms, mean = (np.sqrt(np.stack([part[rows].sum(axis=0) for rows in step.names.values()])) for part in squares)
    return rms, mean, means, scale
