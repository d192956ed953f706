"""Time averages over groups of chains, look by look."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from .chains import Chains
from .pilot import Pilot, run_pilot
from .plan import BURN_IN, GROUPS, LEVELS, NEEDED_LEVELS, Plan


class ChainRecord(NamedTuple):
    """Time averages of O observables at the L step sizes, as they were at each look.

    Attributes
    ----------
    h : ndarray, shape (L,)
        Step sizes, coarsest first.
    levels : ndarray, shape (looks, K, L, O)
        Means over each group of the paired chains; no looks where too many levels went wrong before.
    wide : ndarray, shape (looks, K, O)
        Means over each group of the chains at the coarsest step size alone.
    time : ndarray, shape (looks,)
        Recorded time of each chain.
    planned : float
        Number of looks that were planned, over which the tests share their level.
    paired, chains : float
        Number of paired chains, and of those at the coarsest step size alone.
    burn_in : float
        Time before the record.
    stationary : float
        1 if the first tenth of the first record and its second half agree, 0 if not.
    contraction, diverged : float
        As the `Pilot` found.
    lost, failed, truncated : ndarray, shape (L,)
        Chains that blew up, chains that had a step without root, truncated steps.
    """

    h: Array
    levels: Array
    wide: Array
    time: Array
    planned: float
    paired: float
    chains: float
    burn_in: float
    stationary: float
    contraction: float
    diverged: float
    lost: Array
    failed: Array
    truncated: Array


def run_chains(scheme: Scheme, view: Any, plan: Plan, enough: Callable[[ChainRecord], bool]) -> ChainRecord:
    """Run chains until the record is enough, or all looks are taken.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    plan : Plan
    enough : callable, ChainRecord -> bool
        Asked at each look but the last. It must not ask whether an effect is resolved by now, which would select
        the samples that make it large, but whether a test at its share of the level has decided.

    Returns
    -------
    ChainRecord
    """
    # Non-finite numbers are evidence here: they are counted, not warned about.
    with np.errstate(all="ignore"):
        pilot = run_pilot(scheme, view, plan)
        plan = plan._replace(h=pilot.wide.h).affordable
        record = _blank(plan, pilot, len(view.observables))
        if pilot.stable:
            for record in _looks(scheme, pilot.wide, plan, record):  # noqa: B020 - each look goes on from the last
                if len(record.time) < plan.looks and enough(record):
                    break
    return record


def grouped(means: Array) -> Array:
    """Return the means over groups of chains of time averages of shape (L, O, P), shape (K, L, O)."""
    groups = means.reshape(*means.shape[:-1], GROUPS, -1).mean(axis=-1)
    return np.moveaxis(groups, -1, 0)


def _looks(scheme: Scheme, wide: Chains, plan: Plan, record: ChainRecord) -> Iterator[ChainRecord]:
    """Burn in, then yield the record as it is at each look."""
    paired = Chains(scheme, wide.view, plan.source(wide.view, "paired", plan.paired), plan.h, LEVELS)
    paired.advance(plan.steps(BURN_IN))
    if _disturbed(paired):
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
            levels=np.concatenate([record.levels, [grouped(means[0])]]),
            wide=np.concatenate([record.wide, [grouped(means[1])[:, 0]]]),
            time=np.append(record.time, steps * plan.h),
        )
        record = _with_health(record, paired, wide)
        yield record
        if not plan.affords(burnt + 2 * steps):
            return


def _burn_in(both: tuple[Chains, ...], plan: Plan) -> tuple[int, list[Array], bool]:
    """Double the burn-in until the record that follows, as long as the burn-in, looks stationary.

    Returns
    -------
    int
        Coarsest steps of the burn-in, and of the record.
    list of ndarray, shape (L, O, P)
        Means over the record.
    bool
        Whether it looks stationary; if not, a longer one cannot be afforded.
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


def _disturbed(chains: Chains) -> bool:
    """Tell whether so many levels went wrong that nothing can be seen of an order."""
    needed = chains.tracks[-NEEDED_LEVELS:]
    return any(bool(x.lost.any() or x.failed.any() or x.truncated_steps) for x in needed)


def _with_health(record: ChainRecord, paired: Chains, wide: Chains) -> ChainRecord:
    tracks = [[track] for track in paired.tracks]
    tracks[0].append(wide.tracks[0])
    return record._replace(
        lost=np.array([sum(float(track.lost.sum()) for track in level) for level in tracks]),
        failed=np.array([sum(float(track.failed.sum()) for track in level) for level in tracks]),
        truncated=np.array([sum(float(track.truncated_steps) for track in level) for level in tracks]),
    )


def _blank(plan: Plan, pilot: Pilot, observables: int) -> ChainRecord:
    return ChainRecord(
        h=plan.h / 2.0 ** np.arange(LEVELS),
        levels=np.empty((0, GROUPS, LEVELS, observables)),
        wide=np.empty((0, GROUPS, observables)),
        time=np.empty(0),
        planned=plan.looks,
        paired=plan.paired,
        chains=plan.wide,
        burn_in=np.nan,
        stationary=0.0,
        contraction=pilot.contraction,
        diverged=pilot.diverged,
        lost=np.full(LEVELS, float(pilot.wide.tracks[0].lost.sum())),
        failed=np.zeros(LEVELS),
        truncated=np.zeros(LEVELS),
    )
