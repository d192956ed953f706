"""An experiment under way: blocks over an executor, samples merged in block order whatever the workers do."""

from collections.abc import Iterator
from concurrent.futures import Executor
from functools import partial

from ...contracts.experiment import Row
from ...study import Advanced
from ...workers.pool import in_turn
from .block import run_block
from .plan import ExperimentPlan
from .sample import Sample


class ExperimentRun:
    """A plan with what has been found: complete when `run` has come to its end, usable before.

    Parameters
    ----------
    plan : ExperimentPlan

    Attributes
    ----------
    samples : list of list of Sample
        For each group of the plan and each of its quantities.
    """

    def __init__(self, plan: ExperimentPlan) -> None:
        self.plan = plan
        self.samples = [[Sample() for _ in rows] for _, rows in plan.groups]

    @property
    def total(self) -> int:
        """Number of blocks of all problems."""
        return len(self.plan.groups) * len(self.plan.sizes)

    def run(self, executor: Executor | None = None, window: int = 1) -> Iterator[Advanced]:
        """Run all blocks.

        Parameters
        ----------
        executor : Executor, optional
            Blocks run in this process if left out.
        window : int, optional
            Blocks in flight: bounds the memory of results that wait for their turn.
        """
        calls = ((group, self._call(group, block)) for group, block in self.plan.jobs())
        for done, (group, found) in enumerate(in_turn(executor, window, calls), start=1):
            known = self.samples[group]
            self.samples[group] = [before.merged(more) for before, more in zip(known, found, strict=True)]
            yield Advanced(done, self.total, self.plan.groups[group][0].spec.label)

    def sample_of(self, row: Row) -> Sample:
        """Return what is known of a row that is run."""
        found = zip(self.plan.groups, self.samples, strict=True)
        return next(samples[rows.index(row)] for (_, rows), samples in found if row in rows)

    def _call(self, group: int, block: int) -> "partial[tuple[Sample, ...]]":
        return partial(run_block, self.plan.groups[group][0], block, self.plan.sizes[block])
