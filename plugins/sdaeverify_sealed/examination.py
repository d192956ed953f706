"""Sealed solvers in a gate: their claims about laws beside the claims of schemes, with lock and page."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar

import msgspec

from sdaeverify import Claim, Settings, UsageError, hookimpl
from sdaeverify.measuring import Finding, LevelFinding, Measure, Method, Reason, Verdict
from sdaeverify.studying import Cell as StudyCell
from sdaeverify.studying import CellResult, Examination, Registry, select_problems
from sdaeverify_solvers import Row, SolverWork

from .judging import mean_of
from .run import PROBLEMS, Cell, Measured, SealedRun, cells, select_solvers
from .sample import Budget

CHECKS = Method("checks of a solver", 0)


class SealedTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The table ``[tool.sdaeverify.examinations.sealed]`` of a policy.

    Attributes
    ----------
    solvers : tuple of str
        Labels and globs: a solver that is not named is not gated.
    problems : tuple of str
        Labels and globs.
    paths : int
        Most paths at each step size.
    looks : int
    steps : tuple of int
        Coarsest first; those of each solver if left out.
    """

    solvers: tuple[str, ...]
    problems: tuple[str, ...] = PROBLEMS
    paths: int = Budget().paths
    looks: int = Budget().looks
    steps: tuple[int, ...] = ()


class SealedWeak(Measure):
    """Errors of observables at the horizon, from runs of a sealed solver."""

    name: ClassVar[str] = "weak"


class SealedInvariant(Measure):
    """Errors of stationary means, from runs of a sealed solver."""

    name: ClassVar[str] = "invariant"


# What speaks against a solver as a whole.
AGAINST = frozenset({Verdict.REFUTED, Verdict.ERROR, Verdict.DIVERGED})
SUBJECTS: dict[str, Measure] = {measure.name: measure for measure in (SealedWeak(), SealedInvariant())}


class SealedWork(SolverWork[SealedRun]):
    """Work of an examination of sealed solvers."""

    @property
    def command(self) -> tuple[str, ...]:
        """Words of the command that measures a pair again."""
        budget, steps = self.measuring.budget, ",".join(map(str, self.measuring.budget.steps))
        numbers = ("--paths", str(budget.paths), "--looks", str(budget.looks), "--seed", str(budget.seed))
        words = ("sealed", "{scheme}", "-p", "{problem}", *numbers)
        return (*words, "--steps", steps) if steps else words

    def _results_of(self, cell: Cell, done: Measured, rows: list[Row]) -> Iterator[CellResult]:
        return _results(cell, done, rows)


def _results(cell: Cell, done: Measured, rows: list[Row]) -> Iterator[CellResult]:
    """Yield the results of a pair; what speaks against the solver as a whole does so against each kind of claim."""
    whole = [_of_whole(row) for row in rows if row.finding.claim is None and row.finding.verdict in AGAINST]
    # Of the claims of a kind the first one stands for what is said of the solver as a whole.
    first: dict[str, Claim] = {}
    for claim in cell.solver.promises:
        if claim.measure in SUBJECTS and claim.when <= cell.view.traits:
            first.setdefault(claim.measure, claim)
    for name, claim in first.items():
        own = [row.finding for row in rows if row.measure == name and row.finding.claim is not None]
        findings = (*(replace(found, claim=claim, quantity="") for found in whole), *own)
        levels = tuple(_levels(done, name))
        study_cell = StudyCell(cell.solver, cell.spec, SUBJECTS[name], seen=cell.view)
        if findings:
            paths = max((sample.paths for sample in done.samples), default=0)
            horizon = cell.problem.horizon
            yield CellResult(study_cell, findings, levels, paths=paths, seconds=done.seconds, horizon=horizon)


def _of_whole(row: Row) -> Finding:
    """Return a finding on a solver as a whole, with the name of the check."""
    told = "" if row.measure in SUBJECTS else f"{row.measure}: "
    return replace(row.finding, reason=Reason(f"{told}{row.finding.reason}"), method=CHECKS)


def _levels(done: Measured, measure: str) -> Iterator[LevelFinding]:
    """Yield the error of each observable at each step size."""
    for sample in done.samples:
        if sample.plan.measure == measure:
            for name in sample.plan.names:
                errors = sample.errors(name, len(sample.looks))
                for h, column in zip(sample.plan.h, errors.T, strict=True):
                    yield LevelFinding(name, None, *mean_of(column), h=float(h))


class SealedExamination(Examination):
    """Solvers that draw their own random numbers, by what they claim of their law."""

    name: ClassVar[str] = "sealed"

    def begin(self, registry: Registry, asked: Mapping[str, Any], settings: Settings) -> SealedWork:
        """Return the work on what a table of a policy names.

        Parameters
        ----------
        registry : Registry
        asked : mapping of str to object
            The table of the policy.
        settings : Settings
            Of the gate.

        Raises
        ------
        UsageError
            If the table has an unknown field or a wrong value, or names an unknown solver or problem.
        """
        try:
            table = msgspec.convert(dict(asked), SealedTable)
        except msgspec.ValidationError as error:
            known = ", ".join(SealedTable.__struct_fields__)
            raise UsageError(f"table {self.name}: {error}; known are {known}") from error
        budget = Budget(table.paths, table.looks, table.steps, settings.seed)
        solvers = select_solvers(registry, table.solvers) if table.solvers else []
        pairs, why = cells(solvers, select_problems(registry, table.problems), budget)
        return SealedWork(SealedRun(pairs, budget, settings.confidence), tuple(why))


@hookimpl
def sdaeverify_examinations() -> list[SealedExamination]:
    """Return the examination of sealed solvers."""
    return [SealedExamination()]
