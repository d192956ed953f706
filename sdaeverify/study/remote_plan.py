"""Which cells of a problem can be run, found out in worker processes: that already runs the code of plugins."""

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import NamedTuple

from ..contracts.finding import Verdict
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..errors import FAULTS, one_line
from ..simulate.marker import PROBLEM, Marker
from ..workers.calls import Call, Lost, pickle_argument, unpickle_argument
from ..workers.isolated import Isolated
from ..workers.limits import NOBODY, Mark, StopError, Watchdog
from .plan import Cell, Planner, RemoteCells, scheme_cells

LATE = "no answer within {:g} s (--timeout)"


class CellPlan(NamedTuple):
    """What another process finds out about a cell: see `Cell`."""

    view: str
    verdict: Verdict | None
    reason: str


class CellsRequest(NamedTuple):
    """Schemes and measures whose cells on a problem are to be planned.

    If `claimed`, of each scheme only the cells of measures that its claims name.
    """

    spec: ProblemSpec
    schemes: tuple[Scheme, ...]
    measures: tuple[Measure, ...]
    claimed: bool = False

    def measures_for(self, scheme: Scheme) -> tuple[Measure, ...]:
        """Return the measures of the cells of a scheme."""
        named = {claim.measure for claim in scheme.promises} if self.claimed else set()
        return tuple(measure for measure in self.measures if not self.claimed or measure.name in named)


CellPlans = list[tuple[CellPlan, ...]]


def remote_plan(
    executor: Executor | None,
    schemes: Sequence[Scheme],
    specs: Sequence[ProblemSpec],
    measures: Sequence[Measure],
    *,
    claimed: bool = False,
) -> Planner | None:
    """Have all problems planned at once, and return a function of a problem that waits for its cells.

    Parameters
    ----------
    executor : Executor or None
    schemes, specs, measures : sequence
        As `plan` takes them.
    claimed : bool
        Whether of each scheme only the cells of measures that its claims name are wanted.

    Returns
    -------
    callable or None
        None where there are no isolated workers.
    """
    if not isinstance(executor, Isolated):
        return None
    executor.start(len(specs))
    requests = (CellsRequest(spec, *spec.select(schemes, measures), claimed) for spec in specs)
    pending = {request.spec.label: _submit(executor, request) for request in requests}
    return lambda spec: pending[spec.label].outcome()


def plan_cells(request: CellsRequest, marker: Marker) -> CellPlans | None:
    """Return what is found out for each measure of each scheme; None if the problem cannot be built.

    Raises
    ------
    StopError
        If one of them raises what ends a program: built once more, elsewhere, it would end that.
    """
    try:
        with marker.of(PROBLEM):
            problem = request.spec.build()
    except StopError:
        raise
    except FAULTS:
        return None
    found: CellPlans = []
    for index, scheme in enumerate(request.schemes):
        with marker.of(index):
            cells = scheme_cells(scheme, request.spec, problem, request.measures_for(scheme))
        found.append(tuple(CellPlan(cell.view, cell.verdict, cell.reason) for cell in cells))
    return found


def plan_pickled(request: bytes, mark: Path, timeout: float) -> CellPlans | None:
    """Plan the cells of a problem in a worker process.

    Parameters
    ----------
    request : bytes
        A pickled `CellsRequest`.
    mark : Path
        File that tells the parent what is being done, in case it takes too long.
    timeout : float
        Seconds for each scheme.
    """
    return plan_cells(unpickle_argument(request), Watchdog(mark, timeout))


class _PendingCells(NamedTuple):
    """A request on its way, perhaps once more since a process died of it."""

    executor: Isolated
    request: CellsRequest
    call: Call[CellPlans | None]
    again: bool = False

    def outcome(self) -> RemoteCells:
        """Return the cells of the problem; who hangs or dies of being asked costs the others nothing."""
        try:
            found = self.call.outcome()
        except StopError as stop:
            return self._without(Mark(stop.lane), one_line(stop))
        if isinstance(found, Lost) and not (found.late or self.again):
            return _submit(self.executor, self.request, again=True).outcome()
        if isinstance(found, Lost):
            return self._without(found.mark, found.why(LATE))
        return RemoteCells(()) if found is None else RemoteCells(tuple(_cells(self.request, found)), complete=True)

    def _without(self, mark: Mark, why: str) -> RemoteCells:
        schemes = self.request.schemes
        if mark.lane in {PROBLEM, NOBODY}:
            reason = f"problem {self.request.spec.label} cannot be built: {why}"
            return RemoteCells(tuple(_failed_cells(self.request, schemes, reason)), builds=False)
        failed = tuple(_failed_cells(self.request, [schemes[mark.lane]], why))
        rest = self.request._replace(schemes=(*schemes[: mark.lane], *schemes[mark.lane + 1 :]))
        others = _submit(self.executor, rest, again=self.again).outcome()
        return others._replace(cells=(*others.cells, *failed))


def _submit(executor: Isolated, request: CellsRequest, *, again: bool = False) -> _PendingCells:
    argument = pickle_argument(request, f"a scheme, or problem {request.spec.label},")
    return _PendingCells(executor, request, Call(executor, plan_pickled, argument), again)


def _cells(request: CellsRequest, found: CellPlans) -> Iterator[Cell]:
    for scheme, plans in zip(request.schemes, found, strict=True):
        for measure, found_out in zip(request.measures_for(scheme), plans, strict=True):
            yield Cell(scheme, request.spec, measure, *found_out)


def _failed_cells(request: CellsRequest, schemes: Sequence[Scheme], reason: str) -> Iterator[Cell]:
    for scheme in schemes:
        for measure in request.measures_for(scheme):
            yield Cell(scheme, request.spec, measure, "", Verdict.ERROR, reason)
