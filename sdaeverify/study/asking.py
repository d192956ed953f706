"""What plugins answer when they are asked what can be run, in worker processes: asking already runs their code."""

import pickle
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future
from itertools import count
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import FAULTS, UsageError, one_line
from ..guard import PROBLEM, Guard
from ..measure import Measure, Verdict
from ..scheme import Scheme
from ..specs import ProblemSpec
from .blocks import DIED, ELSE, UNSENT
from .isolated import Died, Isolated
from .limits import NOBODY, Mark, Watchdog, read_mark
from .plan import Ask, Cell, Told, scheme_cells


class Answer(NamedTuple):
    """What a cell is told by, beside its names: see `Cell`."""

    view: str
    verdict: Verdict | None
    reason: str


class Question(NamedTuple):
    """Whether schemes can be put to a problem, and measures to that."""

    spec: ProblemSpec
    schemes: tuple[Scheme, ...]
    measures: tuple[Measure, ...]


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
    if not isinstance(executor, Isolated):
        return None
    asker = _Asker(executor)
    questions = {spec.label: Question(spec, tuple(schemes), tuple(measures)) for spec in specs}
    sent = {label: asker.send(question) for label, question in questions.items()}
    return lambda spec: asker.told(questions[spec.label], sent[spec.label])


def answers(question: Question, guard: Guard) -> Answers | None:
    """Return an answer for each measure of each scheme; None if the problem cannot be built."""
    try:
        with guard.of(PROBLEM), np.errstate(all="ignore"):
            problem = question.spec.build()
    except FAULTS:
        return None
    found: Answers = []
    for index, scheme in enumerate(question.schemes):
        with guard.of(index):
            cells = scheme_cells(scheme, question.spec, problem, question.measures)
        found.append(tuple(Answer(cell.view, cell.verdict, cell.reason) for cell in cells))
    return found


def answers_pickled(question: bytes, mark: Path, timeout: float) -> Answers | None:
    """Answer in a worker process.

    Raises
    ------
    UsageError
        If the question cannot be read there.
    """
    try:
        loaded: Question = pickle.loads(question)
    except FAULTS as error:
        raise UsageError(f"{UNSENT} worker process: {one_line(error)}; {ELSE}") from None
    return answers(loaded, Watchdog(mark, timeout))


class _Sent(NamedTuple):
    future: Future[Answers | None]
    mark: Path
    again: bool = False


class _Asker:
    """Asks, and asks again without whoever hangs or dies of being asked."""

    def __init__(self, executor: Isolated) -> None:
        self.executor, self.numbers = executor, count()

    def send(self, question: Question, *, again: bool = False) -> _Sent:
        """Put a question to the next worker that is free, or again to a new one."""
        mark = self.executor.marks / f"asked-{next(self.numbers)}"
        try:
            pickled = pickle.dumps(question)
        except FAULTS as error:
            what = f"a scheme, or problem {question.spec.label}, cannot be sent to worker processes"
            raise UsageError(f"{what}: {one_line(error)}; {ELSE}") from error
        submit = self.executor.submit_afresh if again else self.executor.submit
        return _Sent(submit(answers_pickled, pickled, mark, self.executor.limits.timeout), mark, again)

    def told(self, question: Question, sent: _Sent) -> Told:
        """Return the cells of a problem as far as they were told."""
        try:
            found = sent.future.result()
        except Died as death:
            if not (sent.mark.is_file() or sent.again):
                # It died before it began with this, of something else.
                return self.told(question, self.send(question, again=True))
            mark = read_mark(sent.mark) if sent.mark.is_file() else Mark()
            return self._without(question, mark, self._why(late=mark.timed_out(death.when)))
        finally:
            sent.mark.unlink(missing_ok=True)
        return Told(()) if found is None else Told(tuple(_cells(question, found)))

    def _without(self, question: Question, mark: Mark, why: str) -> Told:
        schemes = question.schemes
        if mark.lane in {PROBLEM, NOBODY}:
            reason = f"problem {question.spec.label} cannot be built: {why}"
            return Told(tuple(_failed(question, schemes, reason)), builds=False)
        failed = tuple(_failed(question, [schemes[mark.lane]], why))
        rest = question._replace(schemes=(*schemes[: mark.lane], *schemes[mark.lane + 1 :]))
        told = self.told(rest, self.send(rest))
        return told._replace(cells=(*told.cells, *failed))

    def _why(self, *, late: bool) -> str:
        return f"no answer within {self.executor.limits.timeout:g} s (--timeout)" if late else DIED


def _cells(question: Question, found: Answers) -> Iterator[Cell]:
    for scheme, told in zip(question.schemes, found, strict=True):
        for measure, answer in zip(question.measures, told, strict=True):
            yield Cell(scheme, question.spec, measure, *answer)


def _failed(question: Question, schemes: Sequence[Scheme], reason: str) -> Iterator[Cell]:
    for scheme in schemes:
        for measure in question.measures:
            yield Cell(scheme, question.spec, measure, "", Verdict.ERROR, reason)
