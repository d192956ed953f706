"""Plans: the product schemes x problems x measures, split into cells that can be run and cells that cannot."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ..conformance.own_numbers import draws_own_numbers
from ..contracts.finding import Verdict
from ..contracts.matching import match
from ..contracts.measure import Measure, followed_by
from ..contracts.scheme import Claim, Scheme
from ..contracts.specs import ProblemSpec, built
from ..errors import FAULTS, SdaeverifyError, UsageError, one_line
from ..forms import Problem
from ..forms.controls import Control
from ..simulate.ensemble import Entry
from .every_equation import every_equation

Resolve = Callable[[str], Scheme]
Pair = tuple[Scheme, str]


class Tried(NamedTuple):
    """Outcome of the trial of a scheme on a problem, or of the problem itself, in a worker process.

    Attributes
    ----------
    fatal : str
        Why the process ended or was stopped; empty if it was not.
    own_numbers : str
        Reason if a step draws its own random numbers; empty if it does not.
    """

    fatal: str = ""
    own_numbers: str = ""


# Outcomes of the trials of the schemes on a problem; the key None denotes the problem itself.
Trial = Callable[[ProblemSpec], Mapping[Scheme | None, Tried]]


@dataclass(frozen=True)
class Cell:
    """One scheme, one problem, one measure.

    Attributes
    ----------
    scheme : Scheme
    spec : ProblemSpec
    measure : Measure
    view : str
        Name of the view the scheme gets, empty for the problem itself.
    verdict : Verdict or None
        Verdict if the cell cannot be run; None if it can.
    reason : str
        Reason of `verdict`; empty if it is None.
    seen : Problem or None
        The problem in the form that the scheme solves; None if the cell cannot be run.
    """

    scheme: Scheme
    spec: ProblemSpec
    measure: Measure
    view: str = ""
    verdict: Verdict | None = None
    reason: str = ""
    seen: Problem | None = field(default=None, compare=False, repr=False)

    def __getstate__(self) -> dict[str, object]:
        # A problem need not be picklable; the process that reads the cell builds it from its specification.
        return {**vars(self), "seen": None}

    @property
    def pair(self) -> Pair:
        """Scheme and name of the measure, which identify a cell among those of its problem."""
        return self.scheme, self.measure.name

    @property
    def class_name(self) -> str | None:
        """Name of the class of equations that the cell is about; None if it is about a problem."""
        return str(dict(self.spec.parameters)["of"]) if self.spec.function is every_equation else None


@dataclass(frozen=True)
class ControlPlan:
    """A control with its cells.

    Attributes
    ----------
    control : Control
    positive, negative : Cell or None
    missing : str
        Why the control cannot be run; empty if it can.
    failed : bool
        Whether the control is missing because of an error.
    """

    control: Control
    positive: Cell | None = None
    negative: Cell | None = None
    missing: str = ""
    failed: bool = False


@dataclass(frozen=True)
class ProblemPlan:
    """All cells of one problem; those that can be run share one task.

    Attributes
    ----------
    spec : ProblemSpec
    problem : Problem or None
        None if it could not be built.
    cells : tuple of Cell
    controls : tuple of ControlPlan
        For the measures of the cells.
    followed : mapping of str to str
        `Measure.follows` by name of the measure.
    """

    spec: ProblemSpec
    problem: Problem | None
    cells: tuple[Cell, ...]
    controls: tuple[ControlPlan, ...] = ()
    followed: Mapping[str, str] = field(default_factory=dict)

    def __getstate__(self) -> dict[str, object]:
        return {**vars(self), "problem": None}

    @property
    def control_cells(self) -> tuple[Cell, ...]:
        """Distinct cells of all controls that can be run."""
        pairs = ((control.positive, control.negative) for control in self.controls if not control.missing)
        return tuple(dict.fromkeys(cell for pair in pairs for cell in pair if cell is not None))

    @property
    def runnable(self) -> tuple[Cell, ...]:
        """Cells that can be run."""
        return tuple(cell for cell in self.cells if cell.verdict is None)


@dataclass(frozen=True)
class Plan:
    """The cells of a study, grouped by problem.

    Attributes
    ----------
    problems : tuple of ProblemPlan
    """

    problems: tuple[ProblemPlan, ...]

    @property
    def cells(self) -> tuple[Cell, ...]:
        """Cells of all problems, runnable or not."""
        return tuple(cell for problem in self.problems for cell in problem.cells)


def plan(
    schemes: Sequence[Scheme],
    specs: Sequence[ProblemSpec],
    measures: Sequence[Measure],
    resolve: Resolve | None = None,
    trial: Trial | None = None,
    followed: Mapping[str, str] | None = None,
) -> Plan:
    """Cross schemes, problems and measures.

    Parameters
    ----------
    schemes : sequence of Scheme
    specs : sequence of ProblemSpec
    measures : sequence of Measure
    resolve : callable, str -> Scheme, optional
        Returns the scheme of a label, for the controls that problems name; if omitted, no control can be run.
    trial : callable, ProblemSpec -> mapping of (Scheme or None) to Tried, optional
        Returns the outcomes of trials in worker processes: schemes that end or hang the process, and schemes whose
        steps draw their own random numbers. If omitted, this process makes the trial steps.
    followed : mapping of str to str, optional
        `Measure.follows` of all measures by name; of those among `measures` if omitted.

    Returns
    -------
    Plan

    Raises
    ------
    UsageError
        If a problem does not accept the requested parameters.
    """
    # Files that problem functions read may have changed since the previous plan.
    built.cache_clear()
    plans = [_problem_plan(spec, schemes, measures, trial(spec) if trial else None) for spec in specs]
    known = followed_by(measures) if followed is None else followed
    controls = (tuple(_controls(made, measures, resolve)) for made in plans)
    together = zip(plans, controls, strict=True)
    return Plan(tuple(replace(made, controls=found, followed=known) for made, found in together))


def _problem_plan(
    spec: ProblemSpec,
    schemes: Sequence[Scheme],
    measures: Sequence[Measure],
    tried: Mapping[Scheme | None, Tried] | None,
) -> ProblemPlan:
    schemes, measures = spec.select(schemes, measures)
    if tried is not None and None in tried:
        return _unbuilt_plan(spec, schemes, measures, tried[None].fatal)
    try:
        problem = built(spec)
    except FAULTS as error:
        if spec.parameters and isinstance(error, UsageError):
            raise
        return _unbuilt_plan(spec, schemes, measures, one_line(error))
    cells: list[Cell] = []
    for scheme in schemes:
        if tried is not None and (why := tried[scheme].fatal):
            cells += _failed_cells(scheme, spec, measures, why)
            continue
        asked = scheme_cells(scheme, spec, problem, measures)
        own = own_numbers(asked) if tried is None else tried[scheme].own_numbers
        cells += [_not_applicable(cell, own) if own and cell.verdict is None else cell for cell in asked]
    return ProblemPlan(spec, problem, tuple(cells))


def own_numbers(cells: Sequence[Cell]) -> str:
    """Return the reason if the steps of a scheme draw their own random numbers, or an empty string.

    Parameters
    ----------
    cells : sequence of Cell
        Of one scheme on one problem. If none of them can be run, no step is made.
    """
    for cell in cells:
        if cell.seen is not None:
            return draws_own_numbers(cell.scheme, cell.seen)
    return ""


def _not_applicable(cell: Cell, reason: str) -> Cell:
    return replace(cell, verdict=Verdict.NOT_APPLICABLE, reason=reason, seen=None)


def _unbuilt_plan(spec: ProblemSpec, schemes: Sequence[Scheme], measures: Sequence[Measure], why: str) -> ProblemPlan:
    reason = f"problem {spec.label} cannot be built: {why}"
    cells = (cell for scheme in schemes for cell in _failed_cells(scheme, spec, measures, reason))
    return ProblemPlan(spec, None, tuple(cells))


def _failed_cells(scheme: Scheme, spec: ProblemSpec, measures: Sequence[Measure], reason: str) -> list[Cell]:
    return [Cell(scheme, spec, measure, "", Verdict.ERROR, reason) for measure in measures]


def scheme_cells(scheme: Scheme, spec: ProblemSpec, problem: Problem, measures: Sequence[Measure]) -> list[Cell]:
    """Return the cells of a scheme on a problem, one for each measure. No step is made.

    The methods of scheme, problem and measures that decide whether a cell can be run are called here.

    Parameters
    ----------
    scheme : Scheme
    spec : ProblemSpec
        The problem by name and parameters.
    problem : Problem
        The problem built from `spec`.
    measures : sequence of Measure
    """
    try:
        with np.errstate(all="ignore"):
            matched = match(scheme, problem)
    except FAULTS as error:
        return _failed_cells(scheme, spec, measures, one_line(error))
    if matched.failed:
        return _failed_cells(scheme, spec, measures, matched.reason)
    cells = (Cell(scheme, spec, measure, matched.view, seen=matched.problem) for measure in measures)
    return [_refused(cell, problem, matched.reason) for cell in cells]


def _refused(cell: Cell, problem: Problem, reason: str) -> Cell:
    """Return a cell with the reason why it cannot be run, if there is one: that of the match, or of its measure."""
    try:
        with np.errstate(all="ignore"):
            reason = reason or cell.measure.refuses(cell.scheme, problem)
    except FAULTS as error:
        failure = f"measure {cell.measure.name}: {one_line(error)}"
        return replace(cell, verdict=Verdict.ERROR, reason=failure, seen=None)
    return _not_applicable(cell, reason) if reason else cell


def _controls(made: ProblemPlan, measures: Sequence[Measure], resolve: Resolve | None) -> Iterator[ControlPlan]:
    named = {measure.name: measure for measure in measures}
    if made.problem is None or not made.runnable:
        return
    for control in made.problem.controls:
        if control.measure in named:
            yield _control(made, control, named[control.measure], resolve)


def _control(made: ProblemPlan, control: Control, measure: Measure, resolve: Resolve | None) -> ControlPlan:
    if resolve is None:
        return ControlPlan(control, missing="the controls of the problem are not registered")
    cells: list[Cell] = []
    for label in (control.positive, control.negative):
        try:
            cell = _control_cell(made, resolve(label), measure)
        except SdaeverifyError as error:
            return ControlPlan(control, missing=f"the control {label} is missing: {error}")
        if cell.verdict is not None:
            failed = cell.verdict is Verdict.ERROR
            return ControlPlan(control, missing=f"the control {label} cannot be run: {cell.reason}", failed=failed)
        cells.append(cell)
    positive, negative = cells
    return ControlPlan(control, positive, negative)


def _control_cell(made: ProblemPlan, scheme: Scheme, measure: Measure) -> Cell:
    """Return the cell of a control; the one already in the plan if there is one."""
    known = (cell for cell in made.cells if cell.scheme == scheme and cell.measure is measure)
    if (cell := next(known, None)) is not None:
        return cell
    assert made.problem is not None
    return scheme_cells(scheme, made.spec, made.problem, [measure])[0]


def entries_of(cells: Iterable[Cell]) -> tuple[Entry, ...]:
    """Return the schemes of the cells of a problem, each with its measures."""
    by_scheme: dict[Scheme, list[Measure]] = {}
    for cell in cells:
        by_scheme.setdefault(cell.scheme, []).append(cell.measure)
    return tuple(Entry(scheme, tuple(measures)) for scheme, measures in by_scheme.items())


# Cells that test a claim.


def promises_of(cell: Cell) -> tuple[Claim, ...]:
    """Return the claims of a cell's scheme about its measure, in scope or not."""
    return tuple(claim for claim in cell.scheme.promises if claim.measure == cell.measure.name)


def claims_of(cell: Cell) -> tuple[Claim, ...]:
    """Return the claims that a cell tests; all claims about its measure if an error hides the scope."""
    promised = promises_of(cell)
    if cell.verdict is Verdict.NOT_APPLICABLE or not promised:
        return ()
    if cell.seen is None:
        return promised
    return tuple(claim for claim in promised if claim.when <= cell.seen.traits)


def cells_of_claims(made: Plan) -> dict[tuple[Scheme, Claim], list[Cell]]:
    """Return the cells that test each claim of a scheme; a claim without cells is absent."""
    tested: dict[tuple[Scheme, Claim], list[Cell]] = {}
    for cell in made.cells:
        for claim in claims_of(cell):
            tested.setdefault((cell.scheme, claim), []).append(cell)
    return tested


# Parts of a plan that can be run on different machines and merged.


def shard(plan: Plan, index: int, count: int) -> Plan:
    """Return one of several parts of a plan, which together contain each of its cells once.

    All measures of a scheme on a problem stay together, because they share its paths. The controls of a problem are
    part of each part that needs them.

    Parameters
    ----------
    plan : Plan
    index, count : int
        Number of the part, from 1, and number of parts.
    """
    pairs = dict.fromkeys((c.spec.label, c.scheme.label) for c in plan.cells)
    chosen = {pair for number, pair in enumerate(pairs) if number % count == index - 1}
    parts = []
    for made in plan.problems:
        cells = tuple(cell for cell in made.cells if (cell.spec.label, cell.scheme.label) in chosen)
        asked = {cell.measure.name for cell in cells if cell.verdict is None}
        controls = tuple(control for control in made.controls if control.control.measure in asked)
        if cells:
            parts.append(replace(made, cells=cells, controls=controls))
    return Plan(tuple(parts))


# Union of the plans of several runs.


def union(plans: Iterable[Plan], schemes: Sequence[str] = (), problems: Sequence[str] = ()) -> Plan:
    """Return the union of plans: each cell once, the cells of one problem together.

    Parameters
    ----------
    plans : iterable of Plan
    schemes, problems : sequence of str
        Labels in the order of a single run; other labels follow in alphabetical order.

    Returns
    -------
    Plan
    """
    found: dict[str, ProblemPlan] = {}
    for made in (problem for plan in plans for problem in plan.problems):
        before = found.get(made.spec.label)
        found[made.spec.label] = made if before is None else _both(before, made)
    of_problem, of_scheme = _places(problems), _places(schemes)
    whole = (found[label] for label in sorted(found, key=of_problem))
    return Plan(tuple(replace(made, cells=_in_order(made.cells, of_scheme)) for made in whole))


def _both(one: ProblemPlan, other: ProblemPlan) -> ProblemPlan:
    cells = {(cell.scheme.label, cell.measure.name): cell for cell in (*one.cells, *other.cells)}
    controls = {control.control: control for control in (*one.controls, *other.controls)}
    return replace(one, cells=tuple(cells.values()), controls=tuple(controls.values()))


def _places(labels: Sequence[str]) -> Callable[[str], tuple[int, str]]:
    known = {label: place for place, label in enumerate(labels)}
    return lambda label: (known.get(label, len(known)), label)


def _in_order(cells: Iterable[Cell], place: Callable[[str], tuple[int, str]]) -> tuple[Cell, ...]:
    return tuple(sorted(cells, key=lambda cell: (place(cell.scheme.label), cell.measure.name)))
