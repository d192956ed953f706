"""Selection of the levels to which a slope is fitted, and reasons why levels are left out."""

from collections.abc import Mapping

import numpy as np

from ..arrays import Array, Mask
from ..contracts.finding import Kind, Reason
from ..contracts.measure import Evidence

# Number of finest levels to which a slope is fitted. With fewer than FEWEST levels, no slope is fitted.
# Size: levels of a slope, whose intervals reports/calibration counts.
FITTED = 4
# Theorem: a line through two points has no residual, from which its slope could be judged.
FEWEST = 3
UNSEEN = "this holds at every step size, so that no order can be observed"


def sound_levels(health: Mapping[str, Array]) -> tuple[Array, Reason]:
    """Return the levels finer than every level with failures, and a description of the failures.

    Orders are statements about h tending to 0, so coarse levels may fail. A failure on a level finer than a sound
    level is not due to too coarse a step, and excludes the sound level as well.

    Parameters
    ----------
    health : mapping of str to ndarray, shape (L,)
        Counts ``failed`` of paths and ``truncated`` of steps; ``singular`` and ``singular_time`` if the problem can
        lose its algebraic root.

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
    """Return the number of step sizes with failed paths and with truncated steps, in words.

    Parameters
    ----------
    failed, truncated : ndarray, shape (L,)
        Number of failed paths and of truncated steps at each level. If every level has some, `UNSEEN` is appended.
    """
    wrong = {"failed paths": failed > 0, "truncated steps": truncated > 0}
    unseen = len(failed) > 0 and bool((wrong["failed paths"] | wrong["truncated steps"]).all())
    named = [at_levels(name, levels) for name, levels in wrong.items() if levels.any()]
    return [*named, UNSEEN] if unseen else named


def sound_levels_of(evidence: Evidence) -> tuple[Array, Reason]:
    """Return the sound levels of a cell from its evidence; see `sound_levels`."""
    return sound_levels(evidence.health.sums)


def lost_index(health: Mapping[str, Array]) -> Reason:
    """Return the finest level at which du/dy of the problem becomes singular, as a reason; empty if none."""
    if "singular" not in health or not (count := health["singular"]).any():
        return Reason()
    level = int(np.flatnonzero(count)[-1])
    figures = {"paths": count[level], "time": health["singular_time"][level] / count[level]}
    text = "the solution ends where du/dy becomes singular, on {paths:.0f} paths, on average at t = {time:.3g}"
    return Reason(text, Kind.LOST_INDEX, figures)


def at_levels(what: str, levels: Mask) -> str:
    """Return the phrase "`what` at n step sizes", where n counts the True entries of `levels`."""
    count = int(levels.sum())
    return f"{what} at {count} step size{'' if count == 1 else 's'}"
