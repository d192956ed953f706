"""Work of a command on processes of its own."""

from concurrent.futures import BrokenExecutor
from typing import Any

from ..registry.load import Registry
from ..report.progress import progress
from ..workers.limits import available_cores
from ..workers.pool import BLOCKS_A_WORKER, executor_for
from .console import complain
from .exit_codes import ExitCode


def run_on_workers(work: Any, jobs: int | None, registry: Registry, kind: str) -> ExitCode:
    """Do some work on processes of its own, and show how far it is.

    Parameters
    ----------
    work : Study, Calibration or ExperimentRun
        With its number of jobs, and the events of doing them on workers, so many sent ahead.
    jobs : int or None
        Number of processes at most; all cores by default.
    registry : Registry
        With the plugins that they load.
    kind : str
        Of progress.
    """
    processes = max(1, min(jobs or available_cores(), work.total))
    workers = executor_for(processes, registry.files, modules=registry.modules)
    try:
        with workers as executor, progress(kind) as show:
            for event in work.run(executor, BLOCKS_A_WORKER * processes):
                show(event)
    except BrokenExecutor:
        complain("error", "a worker process died, perhaps for want of memory; try fewer --jobs")
        return ExitCode.NOT_MEASURED
    return ExitCode.OK
