"""Trials of schemes and problems in worker processes, before this process calls them."""

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
# Number of blocks of a look, of one scheme on one problem, that may be computed in parallel.
BLOCKS = 8
# Why the process ended; or the reason if a step draws its own random numbers, or an empty string.
Answer = Lost | str


def trial_of(
    executor: Executor | None, schemes: Sequence[Scheme], specs: Sequence[ProblemSpec], measures: Sequence[Measure]
) -> Trial | None:
    """Submit trials of all problems, and return a function that waits for the outcomes of one problem.

    Parameters
    ----------
    executor : Executor or None
    schemes, specs, measures : sequence
        As for `plan`.

    Returns
    -------
    callable or None
        None if the executor has no processes of this machine.
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
    """Build the problem and match each scheme and measure; return the outcome for each scheme.

    Parameters
    ----------
    task : Task
        Its settings are not used.
    marker : Marker
        Records whose code is running.
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
