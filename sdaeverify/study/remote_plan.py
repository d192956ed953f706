"""What plugins answer when they are asked what can be run, in worker processes: asking already runs their code."""

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..contracts.finding import Verdict
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..errors import FAULTS, one_line
from ..simulate.guard import PROBLEM, Guard
from ..store.keys import Sources, read_again, read_sources
from ..workers.calls import Call, Lost, packed, unpacked
from ..workers.isolated import Isolated
from ..workers.limits import NOBODY, Mark, StopError, Watchdog
from .plan import Ask, Cell, Told, scheme_cells

LATE = "no answer within {:g} s (--timeout)"


class Answer(NamedTuple):
    """What a cell is told by, beside its names: see `Cell`."""

    view: str
    verdict: Verdict | None
    reason: str


class PlanQuestion(NamedTuple):
    """Whether schemes can be put to a problem, and measures to that; with the files that they are made of."""

    spec: ProblemSpec
    schemes: tuple[Scheme, ...]
    measures: tuple[Measure, ...]
    sources: Sources = ()


Answers = list[tuple[Answer, ...]]


def asking(
    executor: Executor | None, schemes: Sequence[Scheme], specs: Sequence[ProblemSpec], measures: Sequence[Measure]
) -> Ask | None:
    """Send out all questions and return a function that tells what was answered of a problem.

    Parameters
    ----------
    executor : Executor or None
    schemes, specs, measures : sequence
        As `plan` takes them.

    Returns
    -------
    callable or None
        None where there are no isolated workers that could be asked.
    """
    sources = read_sources(schemes, specs, measures)
    if not isinstance(executor, Isolated):
        return None
    asked = {
        spec.label: _asked(executor, PlanQuestion(spec, tuple(schemes), tuple(measures), sources)) for spec in specs
    }
    return lambda spec: asked[spec.label].told()


def answers(question: PlanQuestion, guard: Guard) -> Answers | None:
    """Return an answer for each measure of each scheme; None if the problem cannot be built.

    Raises
    ------
    StopError
        If one of them raises what ends a program: built once more, elsewhere, it would end that.
    """
    # They are what this process has imported: what it runs later is held against them.
    read_again(question.sources)
    try:
        with guard.of(PROBLEM), np.errstate(all="ignore"):
            problem = question.spec.build()
    except StopError:
        raise
    except FAULTS:
        return None
    found: Answers = []
    for index, scheme in enumerate(question.schemes):
        with guard.of(index):
            cells = scheme_cells(scheme, question.spec, problem, question.measures)
        found.append(tuple(Answer(cell.view, cell.verdict, cell.reason) for cell in cells))
    return found


def answers_pickled(question: bytes, mark: Path, timeout: float) -> Answers | None:
    """Answer in a worker process."""
    return answers(unpacked(question), Watchdog(mark, timeout))


class _Asked(NamedTuple):
    """A question on its way, perhaps once more since a process died of it."""

    executor: Isolated
    question: PlanQuestion
    call: Call[Answers | None]
    again: bool = False

    def told(self) -> Told:
        """Return the cells of the problem; who hangs or dies of being asked costs the others nothing."""
        try:
            found = self.call.outcome()
        except StopError as stop:
            return self._without(Mark(stop.lane), one_line(stop))
        if isinstance(found, Lost) and not (found.late or self.again):
            return _asked(self.executor, self.question, again=True).told()
        if isinstance(found, Lost):
            return self._without(found.mark, found.why(LATE))
        return Told(()) if found is None else Told(tuple(_cells(self.question, found)))

    def _without(self, mark: Mark, why: str) -> Told:
        schemes = self.question.schemes
        if mark.lane in {PROBLEM, NOBODY}:
            reason = f"problem {self.question.spec.label} cannot be built: {why}"
            return Told(tuple(_failed(self.question, schemes, reason)), builds=False)
        failed = tuple(_failed(self.question, [schemes[mark.lane]], why))
        rest = self.question._replace(schemes=(*schemes[: mark.lane], *schemes[mark.lane + 1 :]))
        told = _asked(self.executor, rest, again=self.again).told()
        return told._replace(cells=(*told.cells, *failed))


def _asked(executor: Isolated, question: PlanQuestion, *, again: bool = False) -> _Asked:
    argument = packed(question, f"a scheme, or problem {question.spec.label},")
    return _Asked(executor, question, Call(executor, answers_pickled, argument), again)


def _cells(question: PlanQuestion, found: Answers) -> Iterator[Cell]:
    for scheme, told in zip(question.schemes, found, strict=True):
        for measure, answer in zip(question.measures, told, strict=True):
            yield Cell(scheme, question.spec, measure, *answer)


def _failed(question: PlanQuestion, schemes: Sequence[Scheme], reason: str) -> Iterator[Cell]:
    for scheme in schemes:
        for measure in question.measures:
            yield Cell(scheme, question.spec, measure, "", Verdict.ERROR, reason)
