"""Adaptive solvers in a gate: claims about tolerances next to those of schemes, in lock file and page."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar

import msgspec
import numpy as np

from sdaeverify import Claim, Settings, UsageError, hookimpl
from sdaeverify.measuring import Finding, LevelFinding, Measure, Method, Reason, Verdict, group_sums, jackknife
from sdaeverify.studying import Cell as StudyCell
from sdaeverify.studying import CellResult, Examination, Registry, select_problems
from sdaeverify_solvers import Row, SolverWork, select_solvers

from .judging import STEPS, parts
from .run import HOOK, KIND, PROBLEMS, AdaptiveRun, Cell, Measured, cells, claims_of
from .sample import Budget

CHECKS = Method("checks of a solver", 0)


class AdaptiveTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The table ``[tool.sdaeverify.examinations.adaptive]`` of a policy.

    Attributes
    ----------
    solvers : tuple of str
        Labels and globs of the gated solvers.
    problems : tuple of str
        Labels and globs of problems.
    paths : int
    tolerances : tuple of float
        Tolerances, largest first; by default those of each solver.
    """

    solvers: tuple[str, ...]
    problems: tuple[str, ...] = PROBLEMS
    paths: int = Budget().paths
    tolerances: tuple[float, ...] = ()


class ToleranceRate(Measure):
    """Rate of the error in the tolerance."""

    name: ClassVar[str] = "tolerance"
    value_of: ClassVar[str] = "rate in the tolerance"


class ToleranceSteps(Measure):
    """Order of the error in the mean number of steps."""

    name: ClassVar[str] = "tolerance-steps"


class ToleranceLaw(Measure):
    """Bias of an observable at the smallest tolerance."""

    name: ClassVar[str] = "tolerance-law"
    value_of: ClassVar[str] = "bias at the smallest tolerance"


# Verdicts against a solver as a whole.
AGAINST = frozenset({Verdict.REFUTED, Verdict.ERROR, Verdict.DIVERGED})
SUBJECTS = {measure.name: measure for measure in (ToleranceRate(), ToleranceSteps(), ToleranceLaw())}


class AdaptiveWork(SolverWork[AdaptiveRun]):
    """Work of an examination of adaptive solvers."""

    @property
    def command(self) -> tuple[str, ...]:
        """Words of the command that measures a pair again."""
        budget, fine = self.measuring.budget, ",".join(map(repr, self.measuring.budget.tolerances))
        words = ("adaptive", "{scheme}", "-p", "{problem}", "--paths", str(budget.paths), "--seed", str(budget.seed))
        return (*words, "--tolerances", fine) if fine else words

    def _results_of(self, cell: Cell, done: Measured, rows: list[Row]) -> Iterator[CellResult]:
        return _results(cell, done, rows)


def _results(cell: Cell, done: Measured, rows: list[Row]) -> Iterator[CellResult]:
    """Yield the results of a pair; a verdict against the solver as a whole counts for each kind of claim."""
    view = cell.solver.view_of(cell.problem)
    whole = [_of_whole(row) for row in rows if not row.finding.quantity and row.finding.verdict in AGAINST]
    # The first claim of each kind represents findings on the solver as a whole.
    first: dict[str, Claim] = {}
    for claim in claims_of(cell.solver, cell.problem):
        first.setdefault(claim.measure, claim)
    for name, claim in first.items():
        own = [row.finding for row in rows if row.measure == name and row.finding.quantity]
        findings = (*(replace(found, claim=claim) for found in whole), *own)
        levels = tuple(_levels(cell, done)) if name == STEPS else ()
        study_cell = StudyCell(cell.solver, cell.spec, SUBJECTS[name], seen=view)
        if findings:
            horizon, paths = cell.problem.horizon, _paths(done)
            yield CellResult(study_cell, findings, levels, paths=paths, seconds=done.seconds, horizon=horizon)


def _of_whole(row: Row) -> Finding:
    """Return a finding on a solver as a whole, with the name of the check."""
    told = "" if row.measure in SUBJECTS else f"{row.measure}: "
    return replace(row.finding, reason=Reason(f"{told}{row.finding.reason}"), method=CHECKS)


def _paths(done: Measured) -> int:
    return 0 if done.sampled is None else done.sampled[0].paths


def _levels(cell: Cell, done: Measured) -> Iterator[LevelFinding]:
    """Yield the error at each usable tolerance, at the mean step size including rejected steps."""
    sample = done.sample(cell)
    if sample is None:
        return
    use = sample.usable
    means = sample.tries[use].mean(axis=-1)
    for name, rows in parts(sample).items():
        for h, errors in zip(cell.problem.horizon / means, sample.errors[use, rows], strict=True):
            squares, ones = group_sums((errors**2).sum(axis=0)), group_sums(np.ones(errors.shape[-1]))
            rms = jackknife(squares[None], ones, lambda means: float(np.sqrt(means[0])))
            yield LevelFinding(name, None, rms.value, rms.se, h=float(h))


class AdaptiveExamination(Examination):
    """Examination of adaptive solvers by their claims about tolerances."""

    name: ClassVar[str] = "adaptive"

    def begin(self, registry: Registry, asked: Mapping[str, Any], settings: Settings) -> AdaptiveWork:
        """Return the work for a table of a policy.

        Parameters
        ----------
        registry : Registry
        asked : mapping of str to object
        settings : Settings
            Settings of the gate.

        Raises
        ------
        UsageError
            If the table is malformed, or names an unknown solver or problem.
        """
        try:
            table = msgspec.convert(dict(asked), AdaptiveTable)
        except msgspec.ValidationError as error:
            known = ", ".join(AdaptiveTable.__struct_fields__)
            raise UsageError(f"table {self.name}: {error}; known are {known}") from error
        budget = Budget(table.paths, table.tolerances, settings.seed)
        solvers = select_solvers(registry, HOOK, KIND, table.solvers) if table.solvers else []
        pairs, why = cells(solvers, select_problems(registry, table.problems))
        return AdaptiveWork(AdaptiveRun(pairs, budget, settings.confidence), tuple(why))


@hookimpl
def sdaeverify_examinations() -> list[AdaptiveExamination]:
    """Return the examination of adaptive solvers."""
    return [AdaptiveExamination()]
