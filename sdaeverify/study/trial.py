"""Schemes and problems asked in worker processes what can be run, before this process asks them itself."""

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor

from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings
from ..contracts.specs import ProblemSpec, built
from ..errors import FAULTS, one_line
from ..simulate.ensemble import PROBLEM, Entry, Marker, Task
from ..workers.batches import Batch
from ..workers.calls import Lost
from ..workers.executors import Workers
from ..workers.marks import Mark, StopError
from ..workers.pool import Processes
from .plan import Trial, Tried, own_numbers, scheme_cells

LATE = "no answer within {:g} s (--timeout)"
# Blocks of a look that may be computed side by side, of one scheme on one problem.
BLOCKS = 8
# What has ended the process, or that a step draws random numbers of its own, or an empty string.
Answer = Lost | str


def trial_of(
    executor: Executor | None, schemes: Sequence[Scheme], specs: Sequence[ProblemSpec], measures: Sequence[Measure]
) -> Trial | None:
    """Have all problems tried at once, and return a function of a problem that waits for who cannot be asked.

    Parameters
    ----------
    executor : Executor or None
    schemes, specs, measures : sequence
        As `plan` takes them.

    Returns
    -------
    callable or None
        None where there are no processes for it.
    """
    if not isinstance(executor, Processes):
        return None
    executor.expect(len(schemes) * len(specs) * BLOCKS)
    workers = Workers(executor, 1)
    sent = {spec.label: Batch(workers, _task(spec, schemes, measures), try_asking, LATE) for spec in specs}
    return lambda spec: dict(_tried(sent[spec.label]))


def _task(spec: ProblemSpec, schemes: Sequence[Scheme], measures: Sequence[Measure]) -> Task:
    schemes, measures = spec.select(schemes, measures)
    return Task(spec, tuple(Entry(scheme, tuple(measures)) for scheme in schemes), Settings())


def _tried(sent: Batch[Answer]) -> Iterator[tuple[Scheme | None, Tried]]:
    for entry, answer in sent.answers():
        if isinstance(answer, str):
            yield entry.scheme, Tried(own_numbers=answer)
        else:
            yield None if answer.mark.scheme == PROBLEM else entry.scheme, Tried(fatal=answer.why)


def try_asking(task: Task, marker: Marker) -> list[Answer]:
    """Ask schemes and measures what can be run, and return for each scheme what this process has found out.

    Parameters
    ----------
    task : Task
        Of whose settings nothing is asked.
    marker : Marker
        Is told whose code runs.
    """
    try:
        with marker.of(PROBLEM):
            problem = built(task.spec)
    except StopError as stop:
        return [Lost(Mark(PROBLEM), one_line(stop))] * len(task.entries)
    except FAULTS:
        return [""] * len(task.entries)
    found: list[Answer] = []
    for index, (scheme, measures) in enumerate((entry.scheme, entry.measures) for entry in task.entries):
        try:
            with marker.of(index):
                found.append(own_numbers(scheme_cells(scheme, task.spec, problem, measures)))
        except StopError as stop:
            found.append(Lost(Mark(index), one_line(stop)))
    return found
