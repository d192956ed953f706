"""Judgement in workers: the same results, and a judgement that fails costs its own rows alone."""

import os
import time
from collections import deque
from dataclasses import dataclass
from typing import ClassVar

import pytest

from facade import (
    SCREENING,
    DisplacedEuler,
    EulerMaruyama,
    Limits,
    Milstein,
    Processes,
    StochasticTheta,
    Strong,
    Study,
    Weak,
    gbm,
    plan,
    problem_spec,
    run_block,
)
from sdaeverify import Settings
from sdaeverify.measuring import Finding, Judgement, Measure, Verdict
from sdaeverify.study.blocks import Blocks, Judging
from sdaeverify.study.problem_run import ProblemRun

from .fragile import BOTH, TWICE, blaming

SETTINGS = Settings(paths=40, block=40, levels=3, coarsest=2)
SCHEMES = {scheme.label: scheme for scheme in (EulerMaruyama(), Milstein(), StochasticTheta(), DisplacedEuler())}


@dataclass(frozen=True)
class Process(Measure):
    """A measure that finds the process in which it is judged, or never comes to an end."""

    hangs: bool = False

    name: ClassVar[str] = "process"

    def judge(self, evidence):
        """Return the number of the process."""
        while self.hangs:
            time.sleep(0.01)
        return Judgement((Finding(quantity=str(os.getpid()), verdict=Verdict.OUT_OF_SCOPE),), ())


def looked_at(measures):
    """Return a problem in progress with the evidence of its first look, its controls included."""
    schemes = list(SCHEMES.values())[:3]
    made = plan(schemes, [problem_spec(gbm)], measures, lambda label: SCHEMES.get(label, Milstein()))
    problem = ProblemRun(made.problems[0], SETTINGS)
    for block in (SCREENING, 0):
        task = problem.task()
        problem.absorb(task, run_block(task, block))
    return problem


def judged(executor, problem):
    """Judge on an executor, and return the results of the cells and the scheme and measure of those that failed."""
    (done,) = Blocks(executor, None).results(deque([Judging(problem, problem.judgement())]), 1)
    return done.judged, {(each.cell.scheme.name, each.cell.measure.name) for each in done.failed}


def test_results_are_the_same_in_workers(fragile):
    """Evidence, controls and results are sent as bytes, and no result depends on where it is judged."""
    problem = looked_at((Strong(), Weak()))
    assert problem.judgement().plan.control_cells

    here, there = judged(None, problem), judged(fragile(), problem)

    assert [repr((each.findings, each.levels)) for each in here[0]] == [
        repr((each.findings, each.levels)) for each in there[0]
    ]
    assert len(here[0]) == 6
    assert not here[1] | there[1]


def test_a_judgement_that_ends_its_process_costs_its_own_rows(fragile):
    """The cells of the scheme are in error with the reason, and no further look is taken at them."""
    problem = looked_at((Strong(), Weak()))
    (done,) = Blocks(fragile(BOTH, blaming("milstein")), None).results(
        deque([Judging(problem, problem.judgement())]), 1
    )

    done.absorb()

    lost = [run for run in problem.runs if run.cell.scheme.name == "milstein"]
    assert {(each.cell.scheme.name, each.cell.measure.name) for each in done.failed} == BOTH
    assert {str(run.result.findings[0].reason) for run in lost} == {TWICE}
    assert all(run.settled and run.cell.seen is not None for run in lost)
    assert {run.result.findings[0].verdict for run in lost} == {Verdict.ERROR}
    assert Verdict.ERROR not in {
        finding.verdict for run in problem.runs if run not in lost for finding in run.result.findings
    }


@pytest.mark.long
def test_a_judgement_that_hangs_is_ended():
    """Judgement runs in a worker, where a measure that never comes to an end loses its own rows."""
    with Processes(1, limits=Limits(5.0)) as executor:
        study = Study(plan([Milstein()], [problem_spec(gbm)], [Process(), Strong()]), SETTINGS)
        list(study.run(executor))
        found, _ = study.results()
        hanging = Study(plan([Milstein()], [problem_spec(gbm)], [Process(hangs=True), Strong()]), SETTINGS)
        list(hanging.run(executor))
        lost, strong = hanging.results()

    assert int(found.findings[0].quantity) != os.getpid()
    assert str(lost.findings[0].reason) == "no verdict within 5 s (--timeout)"
    assert strong.findings[0].verdict is not Verdict.ERROR
