"""A calibration under way: jobs over an executor, rates in the order of the plan."""

from collections.abc import Iterator
from concurrent.futures import Executor

from ...study import Advanced
from .plan import STUDIES, CalibrationPlan, Job
from .rates import Rate
from .samples import Sample, joined


class Calibration:
    """A plan with what has been found.

    Parameters
    ----------
    plan : CalibrationPlan

    Attributes
    ----------
    rates : list of Rate
        Complete when `run` has come to its end.
    """

    def __init__(self, plan: CalibrationPlan) -> None:
        self.plan = plan
        self.jobs = plan.jobs()
        self.rates: list[Rate] = []

    def run(self, executor: Executor | None = None) -> Iterator[Advanced]:
        """Do all jobs, in this process if there is no executor, then count."""
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
        found = {label: joined(parts) for label, parts in samples.items()}
        for study, rates in STUDIES.items():
            for placed in self.plan.placed:
                if study in placed.studies:
                    yield from rates(found[placed.case.label])


def run_job(job: Job) -> list[Sample] | list[Rate]:
    """Do a job, in a worker process or in this one."""
    return job.run()
