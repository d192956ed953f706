"""Execution of an experiment: blocks on an executor, joined in order."""

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial

import numpy as np

from sdaeverify import Array, Problem, ProblemError
from sdaeverify.studying import Advanced, in_turn

from .block import run_block, run_probe
from .experiment import Noted, ProbeFound, RunFound, SchemeMean, SchemeValue
from .experiment_plan import PROBE, ExperimentPlan, Job, named_problem, named_scheme
from .scheme_means import scheme_means

Call = Callable[[], ProbeFound | tuple[RunFound, ...]]
NOT_REACHED = "not reached"


class ExperimentEvidence:
    """The evidence of an experiment, on which its table depends exclusively.

    Parameters
    ----------
    plan : ExperimentPlan
    blocks : mapping of Hashable to sequence of RunFound
        Results of each run, in the order of its blocks.
    probes : mapping of Hashable to ProbeFound

    Attributes
    ----------
    paths : int
        Requested number of paths.
    budget : Budget
        Budget of the run.
    keys : frozenset of Hashable
        Keys of planned runs and probes.
    """

    def __init__(
        self,
        plan: ExperimentPlan,
        blocks: Mapping[Hashable, Sequence[RunFound]],
        probes: Mapping[Hashable, ProbeFound],
    ) -> None:
        self.registry, self.paths, self.budget, self.keys = plan.registry, plan.paths, plan.budget, plan.keys
        self.probes = probes
        self.runs = {key: _join_blocks(found) for key, found in blocks.items()}
        self.problems: dict[str, Problem] = {}

    @property
    def failures(self) -> list[str]:
        """Why runs and probes have no results, one line each."""
        found: dict[Hashable, RunFound | ProbeFound] = {**self.runs, **self.probes}
        words = (f"{key}: {found[key].error if key in found else NOT_REACHED}" for key in self.keys)
        return sorted(word for word in words if not word.endswith(": "))

    def run(self, key: Hashable) -> RunFound:
        """Return the results of a run; empty if it was not reached."""
        return self.runs.get(key, RunFound())

    def probe(self, key: Hashable) -> Mapping[str, Array]:
        """Return the results of a probe.

        Raises
        ------
        ProblemError
            If the probe failed or was not reached.
        """
        found = self.probes.get(key, ProbeFound(error=NOT_REACHED))
        if found.error:
            raise ProblemError(f"{key}: {found.error}")
        return found.values

    def values(self, key: Hashable, note: str) -> Array:
        """Return the values of a note, shape (times, ..., P).

        Raises
        ------
        ProblemError
            If the run failed or was not reached.
        """
        found = self.run(key)
        noted = found.noted.get(note, Noted(error=found.error or NOT_REACHED))
        if noted.error:
            raise ProblemError(f"{key}: {noted.error}")
        return noted.values

    def problem(self, label: str) -> Problem:
        """Return a problem by its label, built once."""
        if label not in self.problems:
            self.problems[label] = named_problem(self.registry, label).build()
        return self.problems[label]

    def scheme_means(self, problem: str, values: Sequence[SchemeValue]) -> Mapping[SchemeValue, SchemeMean]:
        """Return exact means of schemes, known for quadratic observables of linear equations."""
        schemes = {value.scheme: named_scheme(self.registry, value.scheme) for value in values}
        return scheme_means(self.problem(problem), values, schemes)


def _join_blocks(blocks: Sequence[RunFound]) -> RunFound:
    first = blocks[0]
    if error := next((found.error for found in blocks if found.error), ""):
        return RunFound(error=error)
    noted = {name: _join_notes([found.noted[name] for found in blocks]) for name in first.noted}
    costs = {name: np.concatenate([found.costs[name] for found in blocks]) for name in first.costs}
    return RunFound(first.h, noted, costs, sum(found.paths for found in blocks))


def _join_notes(noted: Sequence[Noted]) -> Noted:
    if error := next((each.error for each in noted if each.error), ""):
        return Noted(error=error)
    values, without_root, lost = (
        np.concatenate(parts, axis=-1) for parts in zip(*(each[:3] for each in noted), strict=True)
    )
    return Noted(values, without_root, lost, noted[0].at)


class ExperimentRun:
    """Execution of a plan, complete when `run` is exhausted and usable before.

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
        """Run all blocks and probes.

        Parameters
        ----------
        executor : Executor, optional
            Executor; by default blocks run in this process.
        window : int, optional
            Number of blocks in flight, which bounds the memory of waiting results.
        """
        calls = ((job, self._call(job)) for job in self.plan.jobs())
        for done, (job, found) in enumerate(in_turn(executor, window, calls), start=1):
            yield Advanced(done, self.total, self._keep(job, found))

    @property
    def evidence(self) -> ExperimentEvidence:
        """Present evidence."""
        return ExperimentEvidence(self.plan, self.blocks, self.probes)

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
