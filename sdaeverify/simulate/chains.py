"""Replicated chains: time averages of observables at several step sizes on the same noise.

A chain is a path that runs long enough to forget its start. Chains are independent, so that means over groups of
chains have a known error without a model of correlations in time. Step sizes h, h/2, ... share their noise, so that
differences between them are known much better than the means themselves. The mean at the coarsest step size has the
largest error and costs least: it is taken from many more chains at that step size only.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..contracts.scheme import Scheme, State
from ..contracts.stages import LARGEST_BLOCK
from ..noise.brownian import USUAL, Brownian, Source
from ..numerics.statistics import EPS
from .tracks import Track

# Numbers of chains and lengths of runs.


LEVELS = 4
# Steps of all levels in one coarsest step.
STEPS_INSIDE = (1 << LEVELS) - 1
# Number of finest levels that an order estimate needs at least.
NEEDED_LEVELS = 3
# Groups of chains: Student's law with 31 degrees of freedom has light tails.
GROUPS = 32
# Relaxation times of the shortest burn-in; the record of the first look has the same length.
BURN_IN = 10.0
SEGMENTS = 10
# Most steps, all levels together, of a plan and of its first look. Beyond the latter, a cell would cost far more than
# all others, and no chain is run.
MOST_STEPS, MOST_FIRST = 20_000, 40_000


# Fewest and most chains at the coarsest step size only, and their ratio to the chains at all step sizes.
FEWEST_WIDE, MOST_WIDE, WIDE_OF_PAIRED = 256 * GROUPS, LARGEST_BLOCK, 8


def chains_of(paths: int) -> tuple[int, int]:
    """Return the numbers of chains at all step sizes and at the coarsest step size only.

    Parameters
    ----------
    paths : int
        Number of paths of a run. Up to 8192 paths give 1024 and 8192 chains; more give 1/8 of the paths and as many
        as the paths, in multiples of `GROUPS`, up to 131072 and 2^20 chains, which are in memory together.
    """
    groups = -(-min(max(paths, FEWEST_WIDE), MOST_WIDE) // (WIDE_OF_PAIRED * GROUPS))
    return groups * GROUPS, groups * GROUPS * WIDE_OF_PAIRED


class ChainPlan(NamedTuple):
    """Numbers of chains and lengths of runs.

    Attributes
    ----------
    h : float
        Coarsest step size; halved until no chain of a pilot run blows up.
    relaxation_time : float
        Time in which the influence of the start on the solution decreases by a factor e.
    seed : int
    looks : int
        Largest number of looks at the records; each one doubles the recorded time.
    paired, wide : int
        Number of chains at all step sizes on the same noise, and at the coarsest only; multiples of `GROUPS`.
    """

    h: float
    relaxation_time: float
    seed: int
    looks: int = 6
    paired: int = FEWEST_WIDE // WIDE_OF_PAIRED
    wide: int = FEWEST_WIDE

    def steps(self, times: float) -> int:
        """Return the number of coarsest steps in some relaxation times, rounded up to a multiple of `SEGMENTS`."""
        return SEGMENTS * int(np.ceil(times * self.relaxation_time / (SEGMENTS * self.h)))

    def source(self, view: Any, purpose: str, chains: int) -> Source:
        """Return the address of the noise of some chains.

        Parameters
        ----------
        view : Problem
            The problem in the scheme's form; its name is part of the address.
        purpose : str
            Part of the address: chains for different purposes have independent noise.
        chains : int
            Number of chains.
        """
        return Source(self.seed, f"{view.source}|chains|{purpose}", 0, chains)

    def affords(self, steps: int) -> bool:
        """Return whether `steps` coarsest steps, with the finer steps inside them, are within `MOST_STEPS`."""
        return steps * STEPS_INSIDE <= MOST_STEPS

    @property
    def first_look(self) -> int:
        """Number of steps of all levels in the burn-in and in a first record of the same length."""
        return 2 * self.steps(BURN_IN) * STEPS_INSIDE

    @property
    def affordable(self) -> "ChainPlan":
        """The plan with the largest number of looks within `MOST_STEPS`, at least one."""
        burnt = self.steps(BURN_IN)
        looks = [look for look in range(2, self.looks + 1) if self.affords(burnt + burnt * 2 ** (look - 1))]
        return self._replace(looks=max(looks, default=1))


# Chains at one or several step sizes on the same noise, and time averages of observables along them.


STATIONARY_Z = 2.5


class Chains:
    """Chains at one or several step sizes on the same noise.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; its observables are averaged.
    source : Source
        Address of the noise; its paths are the chains.
    h : float
        Coarsest step size.
    levels : int
        Number of step sizes h, h/2, h/4, ...
    """

    def __init__(self, scheme: Scheme, view: Any, source: Source, h: float, levels: int = 1) -> None:
        self.view, self.h, self.steps, self.paths = view, h, 0, source.paths
        self.tracks = [Track(scheme, view, level, h / 2**level, source.paths) for level in range(levels)]
        # Areas are drawn conditionally on H.
        fields = scheme.noise | (USUAL if "A" in scheme.noise else {"dW"})
        self.pieces = Brownian(source, view.noise_dim, h, levels - 1, fields, view.records).pieces()

    def advance(self, steps: int) -> None:
        """Advance all chains by a number of coarsest steps, and mark those that blow up."""
        for _ in range(steps):
            self._step()
        self._find_lost()

    def average(self, steps: int) -> Array:
        """Return the time averages of the O observables over the next coarsest steps, shape (L, O, P)."""
        total = self._zeros()
        for _ in range(steps):
            self._step()
            self._add_values(total)
        self._find_lost()
        return total / steps

    def values(self) -> Array:
        """Return the current values of the observables, shape (L, O, P)."""
        total = self._zeros()
        self._add_values(total)
        return total

    def record(self, steps: int) -> tuple[Array, bool]:
        """Return the time averages over a record, shape (L, O, P), and whether it looks stationary.

        It looks stationary if |z| < 2.5 over all chains for the mean of its first tenth minus the mean of its second
        half.
        """
        parts = np.stack([self.average(steps // SEGMENTS) for _ in range(SEGMENTS)])
        return parts.mean(axis=0), not _moves(parts[0] - parts[SEGMENTS // 2 :].mean(axis=0), parts)

    def _step(self) -> None:
        for level, noise in next(self.pieces):
            self.tracks[level].advance(noise, ())
        self.steps += 1

    def _zeros(self) -> Array:
        return np.zeros((len(self.tracks), len(self.view.observables), self.paths))

    def _add_values(self, total: Array) -> None:
        t = self.steps * self.h
        for level, track in enumerate(self.tracks):
            parts = track.parts()
            for index, observable in enumerate(self.view.observables.values()):
                total[level, index] += observable(t, parts)

    def _find_lost(self) -> None:
        for track in self.tracks:
            track.find_lost(0.0)


def _moves(difference: Array, parts: Array) -> bool:
    # A difference of the size of rounding errors has no known law, so it is not tested.
    mean, rounding = difference.mean(axis=-1), 1e3 * EPS * np.abs(parts).max(axis=(0, -1))
    z = mean / (difference.std(axis=-1, ddof=1) / np.sqrt(difference.shape[-1]))
    return bool(np.any((np.abs(z) >= STATIONARY_Z) & (np.abs(mean) > rounding)))


# Pilot before the record: which step sizes are stable, and whether chains with the same noise approach each other.


# Number of pairs of chains in the contraction test.
PILOTS = 128
HALVINGS = 6
# Relaxation times of the contraction test, and the ratio to which the distance of two chains has to fall in them.
CONTRACTION, CONTRACTING = 20.0, 0.05


class Pilot(NamedTuple):
    """Result of the pilot run before the record.

    Attributes
    ----------
    wide : Chains
        Chains burnt in at the largest step size at which none blew up, or at the smallest that was tried.
    stable : bool
        Whether a step size without blow-up was found; step sizes are halved while the first look is affordable.
    diverged : float
        Smallest step size that blew up; NaN if none did.
    contraction : float
        Median ratio of the distances of two chains with the same noise, after `CONTRACTION` relaxation times to
        before; NaN if no step size is stable.
    """

    wide: Chains
    stable: bool
    diverged: float
    contraction: float


def run_pilot(scheme: Scheme, view: Any, plan: ChainPlan) -> Pilot:
    """Halve the step size until no chain blows up during burn-in, then measure the contraction of pairs of chains.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        The problem in the scheme's form.
    plan : ChainPlan
        Its step size is the first one tried.
    """
    diverged = np.nan
    for halving in range(HALVINGS + 1):
        tried = plan._replace(h=plan.h / 2**halving)
        wide = Chains(scheme, view, plan.source(view, "wide", plan.wide), tried.h)
        wide.advance(tried.steps(BURN_IN))
        if not wide.tracks[0].lost.any():
            return Pilot(wide, True, diverged, _contraction(scheme, wide, tried))
        diverged = tried.h
        if tried._replace(h=0.5 * tried.h).first_look > MOST_FIRST:
            break
    return Pilot(wide, False, diverged, np.nan)


def _contraction(scheme: Scheme, wide: Chains, plan: ChainPlan) -> float:
    """Return the median ratio of the distances between neighbouring chains, after to before.

    Distances are taken between observables, in units of their standard deviations. They, and not the states, are to
    be paired: angles that differ by full turns, for example, have distance 0.
    """
    source, state = plan.source(wide.view, "contraction", PILOTS), wide.tracks[0].state
    pair = [_start_at(Chains(scheme, wide.view, source, plan.h), _select_pilots(state, shift)) for shift in (0, 1)]
    spread = pair[0].values()[0].std(axis=-1, keepdims=True)
    unit = np.where(spread > 0.0, spread, 1.0)
    before = _distance(pair, unit)
    for chains in pair:
        chains.advance(plan.steps(CONTRACTION))
    after = _distance(pair, unit)
    apart = before > 0.0
    return float(np.median(after[apart] / before[apart])) if apart.any() else 0.0


def _start_at(chains: Chains, state: State) -> Chains:
    chains.tracks[0].state = state
    return chains


def _select_pilots(state: State, shift: int) -> State:
    def choose(part: Array) -> Array:
        return np.asarray(part[..., (np.arange(PILOTS) + shift) % part.shape[-1]])

    return type(state)(*map(choose, state)) if isinstance(state, tuple) else choose(state)


def _distance(pair: list[Chains], unit: Array) -> Array:
    a, b = (chains.values()[0] for chains in pair)
    return np.asarray(np.sqrt((((a - b) / unit) ** 2).sum(axis=0)))


# Time averages over groups of chains, look by look.


class ChainRecord(NamedTuple):
    """Time averages of O observables at the L step sizes, at each look.

    Attributes
    ----------
    h : ndarray, shape (L,)
        Step sizes, coarsest first.
    levels : ndarray, shape (looks, K, L, O)
        Means over each group of the paired chains; no looks if too many levels failed before the record.
    wide : ndarray, shape (looks, K, O)
        Means over each group of the chains at the coarsest step size only.
    time : ndarray, shape (looks,)
        Recorded time of each chain at each look.
    planned : float
        Number of planned looks, over which the tests share their level.
    paired, chains : float
        Number of paired chains, and of chains at the coarsest step size only.
    lost, failed, truncated : ndarray, shape (L,)
        Per level: chains that blew up, chains with a step that found no root, and truncated steps.
    burn_in : float
        Time of the burn-in.
    stationary : float
        1 if the first tenth and the second half of the first record agree, 0 if not.
    contraction, diverged : float
        As in `Pilot`.
    """

    h: Array
    levels: Array
    wide: Array
    time: Array
    planned: float
    paired: float
    chains: float
    lost: Array
    failed: Array
    truncated: Array
    burn_in: float = np.nan
    stationary: float = 0.0
    contraction: float = np.nan
    diverged: float = np.nan


def run_chains(scheme: Scheme, view: Any, plan: ChainPlan, enough: Callable[[ChainRecord], bool]) -> ChainRecord:
    """Run chains until `enough` holds or all looks are taken.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    plan : ChainPlan
    enough : callable, ChainRecord -> bool
        Called at each look but the last. It must not depend on whether an effect is resolved by now, because that
        selects samples in which it is large, but on whether a test at its share of the level has decided.

    Returns
    -------
    ChainRecord
        Without looks if the first one would take more than `MOST_FIRST` steps.
    """
    # Non-finite numbers are evidence here: they are counted, and warnings are suppressed.
    if plan.first_look > MOST_FIRST:
        return _blank(plan, len(view.observables))
    with np.errstate(all="ignore"):
        pilot = run_pilot(scheme, view, plan)
        plan = plan._replace(h=pilot.wide.h).affordable
        record = _blank(plan, len(view.observables))._replace(
            contraction=pilot.contraction,
            diverged=pilot.diverged,
            lost=np.full(LEVELS, float(pilot.wide.tracks[0].lost.sum())),
        )
        if pilot.stable:
            for record in _looks(scheme, pilot.wide, plan, record):  # noqa: B020 - each look goes on from the last
                if len(record.time) < plan.looks and enough(record):
                    break
    return record


def average_groups(means: Array) -> Array:
    """Return time averages of shape (L, O, P) averaged over each group of chains, shape (K, L, O)."""
    groups = means.reshape(*means.shape[:-1], GROUPS, -1).mean(axis=-1)
    return np.moveaxis(groups, -1, 0)


def _looks(scheme: Scheme, wide: Chains, plan: ChainPlan, record: ChainRecord) -> Iterator[ChainRecord]:
    """Burn in, then yield the record at each look."""
    paired = Chains(scheme, wide.view, plan.source(wide.view, "paired", plan.paired), plan.h, LEVELS)
    paired.advance(plan.steps(BURN_IN))
    if _is_disturbed(paired):
        yield _with_health(record, paired, wide)
        return
    both = (paired, wide)
    burnt, means, stationary = _burn_in(both, plan)
    record, steps = record._replace(burn_in=burnt * plan.h, stationary=float(stationary)), burnt
    for look in range(plan.looks):
        if look:
            means = [0.5 * (mean + chains.average(steps)) for mean, chains in zip(means, both, strict=True)]
            steps *= 2
        record = record._replace(
            levels=np.concatenate([record.levels, [average_groups(means[0])]]),
            wide=np.concatenate([record.wide, [average_groups(means[1])[:, 0]]]),
            time=np.append(record.time, steps * plan.h),
        )
        record = _with_health(record, paired, wide)
        yield record
        if not plan.affords(burnt + 2 * steps):
            return


def _burn_in(both: tuple[Chains, ...], plan: ChainPlan) -> tuple[int, list[Array], bool]:
    """Double the burn-in until the record after it, of the same length, looks stationary.

    Returns
    -------
    int
        Number of coarsest steps of the burn-in, and of the record.
    list of ndarray, shape (L, O, P)
        Time averages over the record.
    bool
        Whether the record looks stationary; if not, a longer one is not affordable.
    """
    burnt = plan.steps(BURN_IN)
    while True:
        for chains in both:
            chains.advance(burnt - chains.steps)
        records = [chains.record(burnt) for chains in both]
        stationary = all(looks_so for _, looks_so in records)
        if stationary or not plan.affords(4 * burnt):
            return burnt, [means for means, _ in records], stationary
        burnt *= 2


def _is_disturbed(chains: Chains) -> bool:
    """Return whether one of the finest `NEEDED_LEVELS` levels has failures, so that no order can be estimated."""
    needed = chains.tracks[-NEEDED_LEVELS:]
    return any(bool(x.lost.any() or x.failed.any() or x.truncated_steps) for x in needed)


def _with_health(record: ChainRecord, paired: Chains, wide: Chains) -> ChainRecord:
    tracks = [[track] for track in paired.tracks]
    tracks[0].append(wide.tracks[0])

    def count(counted: Callable[[Track], Any]) -> Array:
        return np.array([sum(float(np.sum(counted(track))) for track in level) for level in tracks])

    return record._replace(
        lost=count(lambda track: track.lost),
        failed=count(lambda track: track.failed),
        truncated=count(lambda track: track.truncated_steps),
    )


def _blank(plan: ChainPlan, observables: int) -> ChainRecord:
    none = np.zeros(LEVELS)
    return ChainRecord(
        h=plan.h / 2.0 ** np.arange(LEVELS),
        levels=np.empty((0, GROUPS, LEVELS, observables)),
        wide=np.empty((0, GROUPS, observables)),
        time=np.empty(0),
        planned=plan.looks,
        paired=plan.paired,
        chains=plan.wide,
        lost=none,
        failed=none,
        truncated=none,
    )
