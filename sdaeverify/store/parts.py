"""Evidence on some measures of a scheme put together with that on its others."""

from collections.abc import Sequence
from functools import reduce

from ..contracts.tally import Tally
from ..simulate.behaviour import differing
from ..simulate.ensemble import Entry, LaneEvidence


def joined(entry: Entry, parts: Sequence[tuple[Entry, LaneEvidence]]) -> LaneEvidence:
    """Return the evidence on an entry from parts of its measures.

    Parameters
    ----------
    entry : Entry
    parts : sequence of (Entry, LaneEvidence)
        Of the same scheme; together they have all its measures.
    """
    where = {m.name: (lane, index) for part, lane in parts for index, m in enumerate(part.measures)}
    found = [where[measure.name] for measure in entry.measures]
    lanes = [lane for _, lane in parts]
    did = list(dict.fromkeys(lane.behaviour for lane in lanes if lane.behaviour))
    return LaneEvidence(
        tuple(lane.tallies[index] for lane, index in found),
        tuple(lane.probes[index] for lane, index in found),
        reduce(fuller, (lane.health for lane in lanes)),
        sum(lane.seconds for lane in lanes),
        tuple(lane.errors[index] or differing(*did) for lane, index in found),
        max(lane.paths for lane in lanes),
        next((lane.breach for lane in lanes if lane.breach), ""),
        did[0] if did else None,
    )


def fuller(a: Tally, b: Tally) -> Tally:
    """Return the health that counts more steps: a lane that only evaluates the one-step map makes none."""
    return b if _steps(b) > _steps(a) else a


def _steps(health: Tally) -> float:
    return float(health.sums["steps"].sum()) if "steps" in health.sums else -1.0
