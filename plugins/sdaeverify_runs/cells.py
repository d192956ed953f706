"""Cell-wise comparison of two runs: factors of common quantities, and reasons for missing ones."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Problem, Scheme, SdaeverifyError
from sdaeverify.errors import FAULTS, one_line
from sdaeverify.measuring import Evidence, Measure, Tally
from sdaeverify.studying import Registry, StoredRun, match, select_problems, select_schemes

from .factors import Factor, factor, no_factor
from .level_errors import LevelErrors, level_errors
from .tables import Key, why_not_on_common_noise

# Stored blocks of a cell, by number.
Lanes = Mapping[int, Any]

DRAWN = "paths of the block"


class Comparison(NamedTuple):
    """Factor of a quantity in two runs, or the reason why a quantity, measure or cell has none.

    Attributes
    ----------
    key : Key
        Names of a whole cell or measure are empty from the omitted level on.
    found : Factor
        NaN with a reason if the runs cannot be compared.
    paths : int
        Number of common paths; 0 without sampling.
    """

    key: Key
    found: Factor
    paths: int = 0

    @classmethod
    def without(cls, reason: str, *names: str) -> "Comparison":
        """Return the comparison of names that cannot be compared, with the reason."""
        return cls(Key(*(*names, "", "", "", "")[:4]), no_factor(reason))


@dataclass(frozen=True)
class _Cell:
    """A cell of two runs, with the scheme and problem that are registered here."""

    scheme: Scheme
    problem: Problem
    view: Any
    old: StoredRun
    new: StoredRun
    key: tuple[str, str]

    def errors(self, measure: Measure, run: StoredRun, blocks: list[int]) -> Mapping[str, LevelErrors]:
        """Return the errors of a run on given blocks, by quantity."""
        lanes = [run.lanes[self.key][block] for block in blocks]
        records = [lane.measures[measure.name] for lane in lanes]
        sampled = reduce(Tally.merge, [record.sampled for record in records])
        probed = reduce(Tally.merge, [record.probed for record in records])
        health, tally = reduce(Tally.merge, [lane.health for lane in lanes]), sampled.merge(probed)
        evidence = Evidence(self.scheme, self.problem, self.view, run.settings, tally, health, run.settings.level)
        with np.errstate(all="ignore"):
            return level_errors(measure.judge, replace(evidence, sampled=sampled, probed=probed))


def compare(old: StoredRun, new: StoredRun, registry: Registry) -> list[Comparison]:
    """Compare two runs on common noise.

    Parameters
    ----------
    old, new : StoredRun
    registry : Registry
        Interprets the evidence: names of components, views and measures are those of the schemes registered here.

    Returns
    -------
    list of Comparison
        A single comparison without names if the runs do not share noise and step sizes.
    """
    if different := why_not_on_common_noise(old, new):
        return [Comparison.without(different)]
    return [row for key in sorted({*old.lanes, *new.lanes}) for row in _compare_cell(old, new, registry, key)]


def _compare_cell(old: StoredRun, new: StoredRun, registry: Registry, key: tuple[str, str]) -> Iterator[Comparison]:
    if key not in old.lanes or key not in new.lanes:
        one, other = (old, new) if key in old.lanes else (new, old)
        absent = f"{other.folder} has none, for example because the scheme was refuted before sampling"
        yield Comparison.without(f"only {one.folder} has paths of this cell; {absent}", *key)
    elif _sources(old.lanes[key]) != _sources(new.lanes[key]):
        yield Comparison.without("the problem has changed its behaviour", *key)
    else:
        try:
            cell = _cell(old, new, registry, key)
        except FAULTS as error:
            yield Comparison.without(f"it cannot be built here: {one_line(error)}", *key)
            return
        for name in sorted({*_measures(old.lanes[key]), *_measures(new.lanes[key])}):
            yield from _of_measure(cell, registry, name)


def _cell(old: StoredRun, new: StoredRun, registry: Registry, key: tuple[str, str]) -> _Cell:
    scheme, problem = key
    for label, known in ((scheme, registry.schemes), (problem, registry.problems)):
        if label.partition("[")[0] not in known:
            raise SdaeverifyError(f"{label} is not registered here; load its file with --plugin")
    (made,), (spec,) = select_schemes(registry, scheme), select_problems(registry, problem)
    with np.errstate(all="ignore"):
        built = spec.build()
        matched = match(made, built)
    if matched.problem is None:
        raise SdaeverifyError(matched.reason)
    return _Cell(made, built, matched.problem, old, new, key)


def _of_measure(cell: _Cell, registry: Registry, name: str) -> Iterator[Comparison]:
    a, b = cell.old.lanes[cell.key], cell.new.lanes[cell.key]
    runs, blocks = _common(cell, name)
    if name not in registry.measures:
        yield Comparison.without(f"measure {name} is not registered here", *cell.key, name)
    elif not (name in _measures(a) and name in _measures(b)):
        yield Comparison.without(
            f"only in {(cell.old if name in _measures(a) else cell.new).folder}", *cell.key, name
        )
    elif 0 not in blocks:
        yield Comparison.without("the first block of paths is not in both runs on as many levels", *cell.key, name)
    elif what := registry.measures[name].thing.value_of:
        yield Comparison.without(f"measure {name} estimates a {what}, not an error or an order", *cell.key, name)
    else:
        measure = registry.measures[name].thing
        try:
            errors = [cell.errors(measure, run, blocks) for run in runs]
        except FAULTS as error:
            yield Comparison.without(f"its evidence cannot be read: {one_line(error)}", *cell.key, name)
            return
        yield from _of_quantities(cell, name, *errors)


def _of_quantities(
    cell: _Cell, measure: str, old: Mapping[str, LevelErrors], new: Mapping[str, LevelErrors]
) -> Iterator[Comparison]:
    if not (old or new):
        yield Comparison.without(f"measure {measure} has no errors per level here", *cell.key, measure)
    for quantity in dict.fromkeys((*old, *new)):
        where = Key(*cell.key, measure, quantity)
        if quantity not in old or quantity not in new:
            yield Comparison.without(f"only in {(cell.old if quantity in old else cell.new).folder}", *where)
            continue
        counts = old[quantity].counts
        yield Comparison(where, factor(old[quantity], new[quantity]), 0 if counts is None else int(counts.sum()))


def _common(cell: _Cell, measure: str) -> tuple[tuple[StoredRun, StoredRun], list[int]]:
    """Return the runs and the blocks that both have on all levels or, if those suffice, on guard levels."""
    whole, guards = (cell.old, cell.new), (cell.old.guarding, cell.new.guarding)
    for runs in (whole, guards) if guards[0].settings.levels == guards[1].settings.levels else (whole,):
        a, b = (run.lanes.get(cell.key, {}) for run in runs)
        blocks = [block for block in sorted(a.keys() & b.keys()) if _is_in_both(a[block], b[block], measure)]
        if 0 in blocks:
            return runs, blocks
    return whole, []


def _is_in_both(a: Any, b: Any, measure: str) -> bool:
    drawn = a.ingredients.get(DRAWN) == b.ingredients.get(DRAWN)
    return drawn and measure in a.measures and measure in b.measures


def _measures(lanes: Lanes) -> set[str]:
    return {name for lane in lanes.values() for name in lane.measures}


def _sources(lanes: Lanes) -> set[str]:
    return {lane.behaviour.problem for lane in lanes.values()}
