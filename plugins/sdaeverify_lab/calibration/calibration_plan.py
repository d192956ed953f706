"""The plan of a calibration: cases, studies, and the jobs that give their rates."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from fnmatch import fnmatchcase

from sdaeverify import Scheme, UsageError
from sdaeverify.measuring import Measure
from sdaeverify.studying import Advanced, ProblemSpec, Registry, select_problems, select_schemes

from ..cases import CalibrationCase
from .rates import Rate
from .repeated import POOLED
from .samples import ChainJob, PathJob, Sample, join_samples, path_settings
from .studies import (
    CELLS,
    family_rates,
    look_rates,
    mean_difference_rates,
    published_rates,
    slope_rates,
    verdict_rates,
)

# Least number of repetitions of samples of 400 paths; smaller samples have more, larger ones fewer.
FEWEST = 40
CASES = "sdaeverify_calibration"
MEASURES = ("strong", "weak")
QUARTER = POOLED // 4
CHAINS_STUDY, FAMILIES, JUDGED = "chains", "families", ("published", "verdicts")
STUDIES: dict[str, Callable[[Sample], Iterator[Rate]]] = {
    "slope": slope_rates,
    "looks": look_rates,
    "mean differences": mean_difference_rates,
    "published": published_rates,
    "verdicts": verdict_rates,
}


CalibrationJob = PathJob | ChainJob


@dataclass(frozen=True)
class Placed:
    """A case with its scheme, its problem and its studies."""

    case: CalibrationCase
    scheme: Scheme
    spec: ProblemSpec
    studies: tuple[str, ...]


@dataclass(frozen=True)
class CalibrationPlan:
    """The work of a calibration.

    Attributes
    ----------
    placed : tuple of Placed
    measures : tuple of Measure
        Measures of errors along paths, and of expectations.
    seed : int
    repetitions : int
        Number of samples of 400 paths, of groups of chains, and of families.
    families : bool
        Whether families of tests are simulated.
    """

    placed: tuple[Placed, ...]
    measures: tuple[Measure, ...]
    seed: int
    repetitions: int
    families: bool

    def jobs(self) -> list[CalibrationJob]:
        """Return all jobs, with the samples of a case in order."""
        return [*self._path_jobs(), *self._chain_jobs()]

    def family_rates(self) -> list[Rate]:
        """Return the rates that need no paths."""
        return list(family_rates(self.seed, self.repetitions)) if self.families else []

    def _path_jobs(self) -> Iterator[PathJob]:
        by_problem: dict[tuple[str, float], list[Placed]] = {}
        for placed in self.placed:
            if set(placed.studies) & set(STUDIES):
                by_problem.setdefault((placed.spec.label, placed.case.share), []).append(placed)
        for (_, share), group in by_problem.items():
            judged = any(study in JUDGED for placed in group for study in placed.studies)
            settings, blocks = path_settings(self.seed, max(2, round(self.repetitions * share / QUARTER)))
            cases = tuple((placed.case, placed.scheme) for placed in group)
            yield from (PathJob(group[0].spec, cases, settings, block, self.measures, judged) for block in blocks)

    def _chain_jobs(self) -> Iterator[ChainJob]:
        for placed in self.placed:
            if CHAINS_STUDY in placed.studies:
                yield ChainJob(placed.spec, placed.case, placed.scheme, self.seed, 2 * (self.repetitions // 2))


def calibration_plan(registry: Registry, seed: int, repetitions: int, only: Sequence[str] = ()) -> CalibrationPlan:
    """Plan the calibration of the registered cases.

    Parameters
    ----------
    registry : Registry
    seed, repetitions : int
        See `CalibrationPlan`.
    only : sequence of str, optional
        Patterns; a study of a case is included if its name or that of the case contains one of them.

    Raises
    ------
    UsageError
        If there are too few repetitions, a pattern is empty, or no study is selected.
    """
    if repetitions < FEWEST:
        raise UsageError(f"repetitions must be at least {FEWEST}, got {repetitions}")
    if not all(only):
        raise UsageError(
            "--only expects a part of the name of a study or cell, got an empty text; leave it out for all"
        )
    cases = registry.things(CASES)
    placed = [_place(registry, case, only) for case in cases.values()]
    made = CalibrationPlan(
        tuple(one for one in placed if one.studies),
        tuple(registry.measures[name].thing for name in MEASURES),
        seed,
        repetitions,
        _is_asked_for(only, FAMILIES, f"runs of {CELLS} cells"),
    )
    if not (made.placed or made.families):
        known = ", ".join([*STUDIES, CHAINS_STUDY, FAMILIES, *cases])
        raise UsageError(f"nothing is left to calibrate by --only {', '.join(only)}; known are {known}")
    return made


def _place(registry: Registry, case: CalibrationCase, only: Sequence[str]) -> Placed:
    (scheme,), (spec,) = select_schemes(registry, [case.scheme]), select_problems(registry, [case.problem])
    studies = [study for study in _studies(case) if _is_asked_for(only, study, case.label)]
    return Placed(case, scheme, spec, tuple(studies))


def _studies(case: CalibrationCase) -> Iterable[str]:
    strong = [study for study in STUDIES if case.strong and (study != "mean differences" or case.weak)]
    return [*strong, *([CHAINS_STUDY] if case.stationary else [])]


def _is_asked_for(only: Sequence[str], study: str, case: str) -> bool:
    name = f"{study} {case}"
    # Brackets may belong to a label or to a pattern.
    return not only or any(pattern in name or fnmatchcase(name, f"*{pattern}*") for pattern in only)


# Execution of a calibration: jobs on an executor, rates in the order of the plan.


class Calibration:
    """Execution of a calibration plan.

    Parameters
    ----------
    plan : CalibrationPlan

    Attributes
    ----------
    rates : list of Rate
        Rates, complete when `run` is exhausted.
    """

    def __init__(self, plan: CalibrationPlan) -> None:
        self.plan = plan
        self.jobs = plan.jobs()
        self.rates: list[Rate] = []

    @property
    def total(self) -> int:
        """Number of jobs."""
        return len(self.jobs)

    def run(self, executor: Executor | None = None, _: int = 1) -> Iterator[Advanced]:
        """Run all jobs, in this process without an executor, and compute the rates."""
        samples: dict[str, list[Sample]] = {}
        chains: list[Rate] = []
        results = map(run_job, self.jobs) if executor is None else executor.map(run_job, self.jobs)
        for done, (job, result) in enumerate(zip(self.jobs, results, strict=True), start=1):
            for part in result:
                if isinstance(part, Sample):
                    samples.setdefault(part.case.label, []).append(part)
                else:
                    chains.append(part)
            yield Advanced(done, len(self.jobs), job.label)
        self.rates = [*self._path_rates(samples), *chains, *self.plan.family_rates()]

    def _path_rates(self, samples: dict[str, list[Sample]]) -> Iterator[Rate]:
        found = {label: join_samples(parts) for label, parts in samples.items()}
        for study, rates in STUDIES.items():
            for placed in self.plan.placed:
                if study in placed.studies:
                    yield from rates(found[placed.case.label])


def run_job(job: CalibrationJob) -> list[Sample] | list[Rate]:
    """Run a job, in a worker process or in this one."""
    return job.run()
