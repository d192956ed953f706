"""Which levels of a cell a slope is fitted to, and what went wrong on the others."""

from collections.abc import Mapping

import numpy as np

from ..arrays import Array, Mask
from ..contracts.finding import Kind, Reason
from ..contracts.measure import Evidence

# A slope is fitted on so many of the finest levels; fewer than FEWEST tell none.
# Size: levels of a slope, whose intervals reports/calibration counts.
FITTED = 4
# Chosen: slope and intercept leave one degree of freedom.
FEWEST = 3
UNSEEN = "no step size is without them: the order is never seen"


def sound_levels(health: Mapping[str, Array]) -> tuple[Array, Reason]:
    """Return the levels finer than every one that went wrong, and what went wrong.

    An order is about h tending to 0: coarse levels may fail, but what fails on a finer level than another that
    does not is no matter of too coarse a step.

    Parameters
    ----------
    health : mapping of str to ndarray, shape (L,)
        Counts ``failed`` of paths and ``truncated`` of steps; ``singular`` with ``singular_time``, if the problem may
        lose its root.

    Returns
    -------
    ndarray of int
    Reason
    """
    if not (health["failed"].any() or health["truncated"].any()):
        return np.arange(len(health["failed"])), lost_index(health)
    bad = np.flatnonzero((health["failed"] > 0) | (health["truncated"] > 0))
    remarks = name_wrong(health["failed"], health["truncated"])
    return np.arange(int(bad[-1]) + 1, len(health["failed"])), Reason.of(*remarks, lost_index(health))


def name_wrong(failed: Array, truncated: Array) -> list[str]:
    """Return at how many step sizes paths failed and steps were truncated, and whether no step size is without.

    Parameters
    ----------
    failed, truncated : ndarray, shape (L,)
        Number of failed paths and of truncated steps at each level.
    """
    wrong = {"failed paths": failed > 0, "truncated steps": truncated > 0}
    unseen = len(failed) > 0 and bool((wrong["failed paths"] | wrong["truncated steps"]).all())
    named = [at_levels(name, levels) for name, levels in wrong.items() if levels.any()]
    return [*named, UNSEEN] if unseen else named


def sound_levels_of(evidence: Evidence) -> tuple[Array, Reason]:
    """Return the sound levels of a cell; see `sound_levels`."""
    return sound_levels(evidence.health.sums)


def lost_index(health: Mapping[str, Array]) -> Reason:
    """Return where the problem itself loses its root, at the finest level where it does, or an empty reason."""
    if "singular" not in health or not (count := health["singular"]).any():
        return Reason()
    level = int(np.flatnonzero(count)[-1])
    figures = {"paths": count[level], "time": health["singular_time"][level] / count[level]}
    text = "the solution ends where du/dy is singular, on {paths:.0f} paths at t = {time:.3g} in the mean"
    return Reason(text, Kind.LOST_INDEX, figures)


def at_levels(what: str, levels: Mask) -> str:
    """Return at how many step sizes something happened."""
    count = int(levels.sum())
    return f"{what} at {count} step size{'' if count == 1 else 's'}"
