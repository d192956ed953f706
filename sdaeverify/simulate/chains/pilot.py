"""Before anything is recorded: which step sizes are stable, and whether the same noise brings chains together."""

from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme, State
from .chains import Chains
from .plan import BURN_IN, Plan

# Pairs of chains.
PILOTS = 128
HALVINGS = 6
# Relaxation times in which the distance of two chains is to fall to this part of what it was.
CONTRACTION, CONTRACTING = 20.0, 0.05


class Pilot(NamedTuple):
    """What was found before anything is recorded.

    Attributes
    ----------
    wide : Chains
        Burnt in at the largest step size at which none of them blew up, or at the smallest that was tried.
    stable : bool
        Whether there is one.
    diverged : float
        Smallest step size that blew up; NaN if none did.
    contraction : float
        Median ratio of the distances of two chains with the same noise after `CONTRACTION` relaxation times and
        before; NaN where no step size is stable.
    """

    wide: Chains
    stable: bool
    diverged: float
    contraction: float


def run_pilot(scheme: Scheme, view: Any, plan: Plan) -> Pilot:
    """Halve the step size until no chain blows up while it burns in, then look at pairs of chains."""
    diverged = np.nan
    for halving in range(HALVINGS + 1):
        tried = plan._replace(h=plan.h / 2**halving)
        wide = Chains(scheme, view, plan.source(view, "wide", plan.wide), tried.h)
        wide.advance(tried.steps(BURN_IN))
        if not wide.tracks[0].lost.any():
            return Pilot(wide, True, diverged, _contraction(scheme, wide, tried))
        diverged = tried.h
    return Pilot(wide, False, diverged, np.nan)


def _contraction(scheme: Scheme, wide: Chains, plan: Plan) -> float:
    """Return the median ratio of the distances of some chains to their neighbours after and before.

    Distances are taken between the observables, each in units of its standard deviation: an angle that differs by
    full turns is no distance, and pairing is for the observables.
    """
    source, state = plan.source(wide.view, "contraction", PILOTS), wide.tracks[0].state
    pair = [_started(Chains(scheme, wide.view, source, plan.h), _some(state, shift)) for shift in (0, 1)]
    spread = pair[0].values()[0].std(axis=-1, keepdims=True)
    unit = np.where(spread > 0.0, spread, 1.0)
    before = _distance(pair, unit)
    for chains in pair:
        chains.advance(plan.steps(CONTRACTION))
    after = _distance(pair, unit)
    apart = before > 0.0
    return float(np.median(after[apart] / before[apart])) if apart.any() else 0.0


def _started(chains: Chains, state: State) -> Chains:
    chains.tracks[0].state = state
    return chains


def _some(state: State, shift: int) -> State:
    def chosen(part: Array) -> Array:
        return np.asarray(part[..., (np.arange(PILOTS) + shift) % part.shape[-1]])

    return type(state)(*map(chosen, state)) if isinstance(state, tuple) else chosen(state)


def _distance(pair: list[Chains], unit: Array) -> Array:
    a, b = (chains.values()[0] for chains in pair)
    return np.asarray(np.sqrt((((a - b) / unit) ** 2).sum(axis=0)))
