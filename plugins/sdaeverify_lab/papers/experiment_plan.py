"""The plan of an experiment: labels resolved, and runs grouped by noise."""

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

from sdaeverify import Scheme, Settings, UsageError
from sdaeverify.studying import ProblemSpec, Registry, select_problems, select_schemes, unknown

from .block import NoiseTask, PlannedRun, ProbeTask
from .experiment import Budget, Experiment, Probe, SchemeRun, Work

Thing = TypeVar("Thing")
Job = tuple[int, int]
EXPERIMENTS = "sdaeverify_experiments"
# Replaces the index of a block for a probe.
PROBE = -1


@dataclass(frozen=True)
class ExperimentPlan:
    """An experiment that can be run.

    Attributes
    ----------
    experiment : Experiment
    registry : Registry
        Registry that resolves its labels.
    budget : Budget
    groups : tuple of (NoiseTask, tuple of Hashable)
        For each noise, the task to simulate and the keys of its runs.
    probes : tuple of (ProbeTask, Hashable)
    paths, seed : int
    """

    experiment: Experiment
    registry: Registry
    budget: Budget
    groups: tuple[tuple[NoiseTask, tuple[Hashable, ...]], ...]
    probes: tuple[tuple[ProbeTask, Hashable], ...]
    paths: int
    seed: int

    @property
    def keys(self) -> frozenset[Hashable]:
        """Keys of all runs and probes."""
        return frozenset(key for _, keys in self.groups for key in keys) | {key for _, key in self.probes}

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of paths of each block."""
        block = self.experiment.block
        whole, rest = divmod(self.paths, block)
        return (block,) * whole + ((rest,) if rest else ())

    def jobs(self) -> Iterator[Job]:
        """Yield (probe, PROBE), then (group, block).

        All groups of a block come before the next block, so that all are equally complete after an interrupt.
        """
        yield from ((probe, PROBE) for probe in range(len(self.probes)))
        for block in range(len(self.sizes)):
            yield from ((group, block) for group in range(len(self.groups)))


def experiment_plan(
    registry: Registry,
    name: str,
    *,
    budget: Budget = Budget.SMOKE,
    paths: int | None = None,
    seed: int | None = None,
) -> ExperimentPlan:
    """Resolve the labels of an experiment.

    Parameters
    ----------
    registry : Registry
    name : str
    budget : Budget
    paths, seed : int, optional
        Number of paths and seed; by default that of the experiment at this budget, and that of `Settings`.

    Raises
    ------
    UsageError
        If the experiment, or a scheme or problem of it, is not registered, or there are too few paths.
    """
    if name not in (known := registry.things(EXPERIMENTS)):
        raise unknown("experiment", name, known)
    experiment = known[name]
    paths = experiment.paths_of(budget) if paths is None else paths
    if experiment.block < 1:
        raise UsageError(f"experiment {name!r}: a block needs at least 1 path, got {experiment.block}")
    if paths < 2:
        raise UsageError(f"paths must be at least 2, or there is no standard error, got {paths}")
    seed = Settings(seed=Settings().seed if seed is None else seed).seed
    work = experiment.work(budget)
    groups = tuple(_groups(registry, work, seed, experiment.block))
    probes = tuple((_probe(registry, each, key), key) for key, each in work.items() if isinstance(each, Probe))
    return ExperimentPlan(experiment, registry, budget, groups, probes, paths, seed)


def _groups(
    registry: Registry, work: Work, seed: int, block: int
) -> Iterator[tuple[NoiseTask, tuple[Hashable, ...]]]:
    together: dict[object, dict[Hashable, SchemeRun]] = {}
    for key, run in work.items():
        if isinstance(run, SchemeRun):
            together.setdefault(run.noise or run.problem, {})[key] = run
    for noise, runs in together.items():
        shared = None if isinstance(noise, str) else next(iter(runs.values())).noise
        _require_doublings(runs)
        planned = tuple(_plan_run(registry, run) for run in runs.values())
        yield NoiseTask(planned, shared, seed, block), tuple(runs)


def _plan_run(registry: Registry, run: SchemeRun) -> PlannedRun:
    return PlannedRun(run, named_problem(registry, run.problem), named_scheme(registry, run.scheme))


def _require_doublings(runs: Mapping[Hashable, SchemeRun]) -> None:
    steps = sorted({run.steps for run in runs.values()})
    if any(count % steps[0] or (count // steps[0]).bit_count() != 1 for count in steps):
        raise UsageError(f"steps on the same noise must be the smallest times powers of 2, got {steps}")


def _probe(registry: Registry, probe: Probe, key: Hashable) -> ProbeTask:
    specs = tuple(named_problem(registry, label) for label in probe.problems)
    return ProbeTask(probe.of, specs, tuple(named_scheme(registry, label) for label in probe.schemes), str(key))


def named_scheme(registry: Registry, label: str) -> Scheme:
    """Return the single scheme with a label."""
    return _only("scheme", label, select_schemes(registry, [label]))


def named_problem(registry: Registry, label: str) -> ProblemSpec:
    """Return the specification of the single problem with a label."""
    return _only("problem", label, select_problems(registry, [label]))


def _only(kind: str, label: str, found: list[Thing]) -> Thing:
    if len(found) != 1:
        raise UsageError(f"expected the label of one {kind}, got {label!r}, which matches {len(found)}")
    return found[0]
