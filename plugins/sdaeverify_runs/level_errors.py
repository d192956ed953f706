"""Errors of the quantities of a cell at each step size, on all paths and on the paths without each group.

The errors are those in the levels of `Measure.judge`. The measure judges again without each group, so that it needs
no support for the jackknife.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from math import isfinite, nan
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Mask
from sdaeverify.measuring import Evidence, Finding, Judgement, LevelFinding, Tally, sound_levels
from sdaeverify.numerics import GROUPS
from sdaeverify.studying import RESOLVED

# Columns of levels: whether the level was fitted, the least significant error, the size of cancelling terms.
FITTED, FLOOR, SCALE = "fitted", "error_floor", "scale"
ROUNDING = 64.0 * np.finfo(float).eps
# Tier of evidence along paths.
SAMPLED = 3

Judge = Callable[[Evidence], Judgement]


class LevelErrors(NamedTuple):
    """Errors of one quantity.

    Attributes
    ----------
    h : ndarray, shape (L,)
        Step sizes, coarsest first.
    log2 : ndarray, shape (1 + G, L) or (1, L)
        Logarithms to base 2 of the errors on all paths and without each group; a single row without sampling.
    told : ndarray of bool, shape (L,)
        Whether the error exceeds rounding and sampling noise.
    counts : ndarray, shape (G,), or None
        Number of paths of each group; None without sampling.
    order : float
        Order that is known without sampling; NaN if unknown.
    """

    h: Array
    log2: Array
    told: Mask
    counts: Array | None = None
    order: float = nan


NO_LEVELS = LevelErrors(np.empty(0), np.empty((1, 0)), np.empty(0, dtype=bool))


def level_errors(judge: Judge, evidence: Evidence) -> Mapping[str, LevelErrors]:
    """Return the errors at the levels of a measure, by quantity.

    Parameters
    ----------
    judge : callable, Evidence -> Judgement
    evidence : Evidence
        Evidence with its parts `sampled` and `probed`.
    """
    judgement = judge(evidence)
    orders = {each.quantity: each.estimate for each in judgement.findings if _is_known_order(each)}
    rows = _by_quantity(judgement.levels)
    known = {name: NO_LEVELS._replace(order=order) for name, order in orders.items()}
    known |= {name: _known_errors(own, orders.get(name, nan)) for name, own in rows.items() if _has_floors(own)}
    sampled = {name: own for name, own in rows.items() if all(row.level is not None for row in own)}
    if not sampled:
        return known
    left_out = [_by_quantity(judge(_without(evidence, group)).levels) for group in range(GROUPS)]
    every = {name: [own, *(each[name] for each in left_out)] for name, own in sampled.items()}
    found = {name: _sampled_errors(evidence, tables) for name, tables in every.items()}
    return known | {name: own._replace(order=orders.get(name, nan)) for name, own in found.items()}


def _is_known_order(found: Finding) -> bool:
    # An order with an interval comes from paths, even if a lower tier decided.
    without_sampling = found.tier < SAMPLED and not found.low < found.high
    return without_sampling and not found.value_of and isfinite(found.estimate)


def _by_quantity(levels: Iterable[LevelFinding]) -> dict[str, list[LevelFinding]]:
    found: dict[str, list[LevelFinding]] = {}
    for row in levels:
        found.setdefault(row.quantity, []).append(row)
    return found


def _has_floors(rows: list[LevelFinding]) -> bool:
    return all(row.level is None and FLOOR in row.details for row in rows)


def _known_errors(rows: list[LevelFinding], order: float) -> LevelErrors:
    sizes, floors = (np.array(column, dtype=float) for column in zip(*map(_size_and_floor, rows), strict=True))
    return LevelErrors(np.array([row.h for row in rows]), np.log2(sizes)[np.newaxis], sizes > floors, None, order)


def _size_and_floor(row: LevelFinding) -> tuple[float, float]:
    return abs(row.estimate), RESOLVED * np.float64(row.details[FLOOR])  # type: ignore[arg-type]


def _sampled_errors(evidence: Evidence, tables: list[list[LevelFinding]]) -> LevelErrors:
    """Return the errors along paths, from the levels on all paths and without each group."""
    rows, sound = tables[0], set(sound_levels(evidence.health.sums)[0].tolist())
    sizes = np.abs([[row.estimate for row in table] for table in tables])
    told = np.array([row.level in sound and _is_told(row, evidence) for row in rows])
    h = np.array([evidence.step_sizes[row.level] for row in rows if row.level is not None])
    return LevelErrors(h, np.log2(sizes), told, evidence.along_paths.sums["paths"])


def _is_told(row: LevelFinding, evidence: Evidence) -> bool:
    assert row.level is not None
    rounding = ROUNDING * np.float64(row.details.get(SCALE, 0.0)) * np.sqrt(evidence.settings.steps[row.level])  # type: ignore[arg-type]
    return bool(row.details.get(FITTED, True)) and abs(row.estimate) > max(RESOLVED * row.std_error, rounding)


def _without(evidence: Evidence, group: int) -> Evidence:
    """Return evidence without a group of paths.

    The sums of the group are replaced by the mean of all other groups, so that every mean becomes one without the
    group.
    """

    def others(sums: Array) -> Array:
        if sums.ndim == 0 or len(sums) != GROUPS:
            return sums
        found = sums.copy()
        found[group] = (sums.sum(axis=0) - sums[group]) / (GROUPS - 1)
        return found

    paths = evidence.along_paths
    sampled = Tally({name: others(sums) for name, sums in paths.sums.items()}, paths.maxima, paths.largest)
    # Claims are dropped, because only the levels are needed.
    return replace(evidence, tally=sampled.merge(evidence.without_paths), sampled=sampled, claims=())
