"""An experiment under way: blocks over an executor, evidence joined in block order whatever the workers do."""

from collections.abc import Callable, Hashable, Iterator
from concurrent.futures import Executor
from functools import partial

from ...contracts.experiment import ProbeFound, RunFound
from ...study import Advanced
from ...workers.pool import in_turn
from .block import run_block, run_probe
from .evidence import FoundEvidence
from .plan import PROBE, ExperimentPlan, Job

Call = Callable[[], ProbeFound | tuple[RunFound, ...]]


class ExperimentRun:
    """A plan with what has been found: complete when `run` has come to its end, usable before.

    Parameters
    ----------
    plan : ExperimentPlan
    """

    def __init__(self, plan: ExperimentPlan) -> None:
        self.plan = plan
        self.blocks: dict[Hashable, list[RunFound]] = {}
        self.probes: dict[Hashable, ProbeFound] = {}

    @property
    def total(self) -> int:
        """Number of blocks and probes."""
        return len(self.plan.probes) + len(self.plan.groups) * len(self.plan.sizes)

    def run(self, executor: Executor | None = None, window: int = 1) -> Iterator[Advanced]:
        """SchemeRun everything.

        Parameters
        ----------
        executor : Executor, optional
            Blocks run in this process if left out.
        window : int, optional
            Blocks in flight: bounds the memory of results that wait for their turn.
        """
        calls = ((job, self._call(job)) for job in self.plan.jobs())
        for done, (job, found) in enumerate(in_turn(executor, window, calls), start=1):
            yield Advanced(done, self.total, self._keep(job, found))

    @property
    def evidence(self) -> FoundEvidence:
        """What is known now."""
        return FoundEvidence(self.plan, self.blocks, self.probes)

    def _call(self, job: Job) -> Call:
        index, block = job
        if block == PROBE:
            return partial(run_probe, self.plan.probes[index][0])
        return partial(run_block, self.plan.groups[index][0], block, self.plan.sizes[block])

    def _keep(self, job: Job, found: ProbeFound | tuple[RunFound, ...]) -> str:
        if isinstance(found, ProbeFound):
            task, key = self.plan.probes[job[0]]
            self.probes[key] = found
            return task.label
        noise, keys = self.plan.groups[job[0]]
        for key, each in zip(keys, found, strict=True):
            self.blocks.setdefault(key, []).append(each)
        return noise.label
