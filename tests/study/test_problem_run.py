"""Look by look: who gets more paths, and what is known at the end."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    CellResult,
    DisplacedEuler,
    EulerMaruyama,
    Milstein,
    Stability,
    StochasticTheta,
    Strong,
    Study,
    gbm,
    ou,
    plan,
    problem_spec,
    withhold,
)
from sdaeverify import SDE, Claim, Control, Scheme, Settings, Step
from sdaeverify.measuring import Evidence, Finding, Judgement, Measure, Tally, Verdict, group_sums
from sdaeverify.study.problem_run import ProblemRun

SETTINGS = Settings(paths=8192, levels=4, coarsest=4)
CLAIM = Claim(measure="patient", value=1.0, source="test")


class Notebook:
    """An observer that counts paths."""

    def __init__(self, parts, settings):
        self.paths = parts["x"].shape[-1]
        self.wanted = [frozenset()] * settings.levels

    def after_step(self, level, step, parts):
        """Note nothing."""

    def after_coarsest_step(self, snapshot):
        """Note nothing."""

    def tally(self):
        """Return the number of paths."""
        return Tally(sums={"paths": group_sums(np.ones(self.paths))})


@dataclass(frozen=True)
class Patient(Measure):
    """A measure that is satisfied with some number of paths."""

    p: float = 1e-9
    wants: int = 1000

    name: ClassVar[str] = "patient"

    def observer(self, problem, parts, settings):
        """Count the paths."""
        return Notebook(parts, settings)

    def judge(self, evidence: Evidence) -> Judgement:
        """Verify as soon as there are enough paths."""
        enough = evidence.paths >= self.wants
        verdict = Verdict.VERIFIED if enough else Verdict.INCONCLUSIVE
        p = self.p if enough else 1.0
        found = Finding(quantity="x", verdict=verdict, claim=CLAIM, p_verified=p, p_refuted=1.0, settled=enough)
        return Judgement((found,), ())


def run(schemes, measures, settings=SETTINGS, family=gbm, resolve=None):
    """Return the results of a study and its events."""
    study = Study(plan(schemes, [problem_spec(family)], measures, resolve), settings)
    events = list(study.run())
    return study.results(), events


@pytest.mark.parametrize(
    ("wants", "looks", "taken"), [(1, 6, 256), (300, 6, 1024), (1500, 6, 2048), (10**6, 6, 8192), (1, 1, 8192)]
)
def test_a_cell_gets_paths_until_it_is_settled(wants, looks, taken):
    """After the second look paths double until the measure is satisfied, and end with the largest number."""
    (result,), _ = run([EulerMaruyama()], [Patient(wants=wants)], replace(SETTINGS, max_looks=looks))

    assert result.paths == taken
    assert result.findings[0].verdict is (Verdict.VERIFIED if wants <= 8192 else Verdict.INCONCLUSIVE)


def test_a_patient_cell_does_not_cost_the_others():
    """Of two cells of a problem, only the one that is not settled gets more paths."""

    class Slow(Patient):
        """The same with another name."""

        name: ClassVar[str] = "slow"

    results, _ = run([EulerMaruyama()], [Patient(wants=1), Slow(wants=2000)])

    assert [result.paths for result in results] == [256, 2048]


def test_controls_go_on_with_the_cells_they_are_for():
    """Controls of a measure take no further look when none of its cells is open, whoever else's are."""
    schemes = {scheme.label: scheme for scheme in (DisplacedEuler(), EulerMaruyama(), Milstein())}
    made = plan(
        [Milstein()], [problem_spec(gbm)], [Strong(), Patient()], lambda label: schemes.get(label, Milstein())
    )
    problem = ProblemRun(made.problems[0], SETTINGS)
    before = {(entry.scheme.name, each.name) for entry in problem.task().entries for each in entry.measures}
    settled = Finding(quantity="x", verdict=Verdict.VERIFIED, claim=CLAIM)
    strong = next(run for run in problem.runs if run.cell.measure.name == "strong")
    strong.result = CellResult(strong.cell, (settled,))

    after = {(entry.scheme.name, each.name) for entry in problem.task().entries for each in entry.measures}

    assert {("milstein", "strong"), ("displaced-euler", "strong"), ("milstein", "patient")} <= before
    assert after == {("milstein", "patient")}


def test_p_values_are_of_all_looks():
    """The p-value of a sequence is the least of its looks times their number."""
    (result,), _ = run([EulerMaruyama()], [Patient(p=1e-5)])

    assert result.findings[0].p_verified == pytest.approx(5e-5)


def test_a_problem_is_finished_when_its_last_cell_is():
    """Finished problems are told once, with the results they keep."""
    results, events = run([EulerMaruyama()], [Patient(wants=300)])

    finished = [event for event in events if event.results]
    assert len(finished) == 1
    assert [r.paths for r in finished[0].results] == [r.paths for r in results]


def test_everything_is_screened_before_any_path():
    """One step of each scheme on all problems is looked at first, and counts for half of the work."""
    specs, measures = [problem_spec(gbm), problem_spec(ou)], [Stability(), Patient(wants=1)]
    study = Study(plan([EulerMaruyama()], specs, measures), SETTINGS)
    told = []
    for event in study.run():
        told.append((event.done, event.total))
        sampled = any(run.evidence.paths for problem in study.problems for run in problem.runs)
        assert sampled == (len(told) > 2)

    assert told[:2] == [(1, 4), (2, 4)]
    assert told[-1] == (4, 4)


def test_interrupted_studies_keep_what_they_know():
    """Cells that were judged are reported with the paths they had, and why they got no more."""
    study = Study(plan([EulerMaruyama()], [problem_spec(gbm)], [Patient(wants=10**6)]), SETTINGS)
    events = study.run()
    # One step and a block of paths are computed and judged.
    for _ in range(3):
        next(events)
    study.stopped = "interrupted"

    (result,) = study.results()

    assert result.paths == 256
    assert str(result.findings[0].reason).startswith("interrupted")


class Broken(Patient):
    """A measure that fails while it is planned."""

    name: ClassVar[str] = "broken"

    def refuses(self, scheme, problem):
        """Fail."""
        return {}["missing"]


def test_a_measure_that_fails_as_it_is_planned_costs_only_its_own_cells():
    """The others of the scheme are run."""
    results, _ = run([EulerMaruyama()], [Broken(), Patient()])

    assert [result.findings[0].verdict for result in results] == [Verdict.VERIFIED, Verdict.ERROR]
    assert "measure broken: KeyError: 'missing'" in str(results[1].findings[0].reason)


def small_noise() -> SDE:
    """Return geometric Brownian motion with noise so small that Euler-Maruyama looks like order 1 along paths."""
    control = Control(measure="strong", order=1.0, positive="milstein", negative="euler-maruyama")
    return replace(gbm(0.5, 0.01), controls=(control,))


class Remembering(Scheme):
    """Euler-Maruyama with memory that cannot be set, so that paths alone can judge it; it claims order 1."""

    name: ClassVar[str] = "remembering"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=1.0, source="planted"),)

    def start(self, problem, paths, h):
        return np.concatenate([problem.initial(paths)] * 2)

    def parts(self, problem, state):
        return problem.parts(state[:1])

    def step(self, problem, state, t, h, noise):
        x = EulerMaruyama().step(problem, state[:1], t, h, noise).state
        return Step(np.concatenate([x, state[:1]]))


def resolve(label):
    """Return the scheme of a label."""
    known = (Milstein(), EulerMaruyama(), DisplacedEuler())
    return next(scheme for scheme in known if scheme.label == label)


def test_paths_verify_nothing_where_they_cannot_tell_the_control():
    """With small noise, paths see order 1 of a scheme of order 1/2; the control does not let that pass."""
    uncontrolled = lambda: replace(small_noise(), controls=())  # noqa: E731
    uncontrolled.__name__ = "uncontrolled"

    (fooled,), _ = run([Remembering()], [Strong()], family=uncontrolled)
    (controlled,), _ = run([Remembering()], [Strong()], family=small_noise, resolve=resolve)

    assert {finding.verdict for finding in fooled.findings} == {Verdict.VERIFIED}
    assert {finding.verdict for finding in controlled.findings} == {Verdict.INCONCLUSIVE}
    assert "negative control euler-maruyama is not refuted" in str(controlled.findings[0].reason)


def noisier():
    """Return geometric Brownian motion with the truth of one whose noise is half as strong again."""
    return replace(gbm(), truths=(gbm(b=0.9).pathwise,))


def test_a_wrong_truth_is_not_the_scheme_s_fault():
    """Where a control that has the order is refuted by paths, too, the problem is suspect; else the scheme is."""
    explicit = StochasticTheta(theta=0.0)
    uncontrolled = lambda: replace(noisier(), controls=())  # noqa: E731
    uncontrolled.__name__ = "uncontrolled"

    settings = Settings(paths=1024, max_looks=3)

    (blamed,), _ = run([explicit], [Strong()], settings, uncontrolled)
    (excused,), _ = run([explicit], [Strong()], settings, noisier, resolve)

    assert {finding.verdict for finding in blamed.findings} == {Verdict.REFUTED}
    assert {finding.verdict for finding in excused.findings} == {Verdict.ERROR}
    assert (
        "the exact solution of the problem is in doubt: euler-maruyama, known to have order 0.5, is refuted here"
        in str(excused.findings[0].reason)
    )


class Withholding(Patient):
    """A measure that takes back at its second look what it was sure of at the first."""

    name: ClassVar[str] = "withholding"

    def judge(self, evidence: Evidence) -> Judgement:
        """Verify with few paths, withhold with more; a second quantity asks for more of them."""
        sure = Finding(quantity="x", verdict=Verdict.VERIFIED, claim=CLAIM, p_verified=self.p, p_refuted=1.0)
        enough = evidence.paths >= self.wants
        other = Finding(quantity="y", verdict=Verdict.INCONCLUSIVE, claim=CLAIM, settled=enough)
        return Judgement((withhold(sure, "something was seen") if enough else sure, other), ())


def test_what_a_look_withholds_no_earlier_one_brings_back():
    """A correction for looks and tests is made of what is left standing alone."""
    (result,), _ = run([EulerMaruyama()], [Withholding()])
    found = result.findings[0]

    assert result.paths == 1024
    assert (found.verdict, found.p_verified) == (Verdict.INCONCLUSIVE, 1.0)
    assert str(found.reason) == "something was seen"
