"""Few levels first: what they are enough for, and what all levels are for."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from facade import DisplacedEuler, EulerMaruyama, Milstein, Strong, Study, gbm, plan, problem_spec, settings_from
from facade import way_FINER as FINER
from sdaeverify import Claim, Settings, verify
from sdaeverify.measuring import Finding, Judgement, Kind, LevelFinding, Measure, Reason, Tally, Verdict, group_sums
from study.test_problem_run import Remembering, small_noise

SETTINGS = Settings(paths=2048, max_looks=3)
FEW, ALL = SETTINGS.first_levels, SETTINGS.levels
ORDER, EXACT = (
    Claim(measure="told", value=1.0, source="test"),
    Claim(measure="told", value="round-off", source="test"),
)


class Counts:
    """An observer of how many paths there are, and on how many levels."""

    def __init__(self, parts, settings):
        self.paths, self.levels = parts["x"].shape[-1], settings.levels
        self.wanted = [frozenset()] * settings.levels

    def after_step(self, level, step, parts):
        """Note nothing."""

    def after_coarsest_step(self, snapshot):
        """Note nothing."""
        assert len(snapshot.levels) == self.levels

    def tally(self):
        """Return the numbers."""
        return Tally(sums={"paths": group_sums(np.ones(self.paths))}, maxima={"levels": np.array([self.levels])})


@dataclass(frozen=True, eq=False)
class Told(Measure):
    """A measure that says what it is told to on the levels of guards, and that a claim is verified on all of them."""

    said: Finding
    enough: int = 10**6

    name: ClassVar[str] = "told"

    def observer(self, problem, parts, settings):
        """Count."""
        return Counts(parts, settings)

    def judge(self, evidence):
        """Say what was told, as long as there are few paths."""
        levels = int(evidence.tally.maxima["levels"][0])
        assert levels == evidence.settings.levels == len(evidence.health.sums["steps"])
        verified = Finding(quantity="x", verdict=Verdict.VERIFIED, claim=ORDER, tier=1)
        found = self.said if levels < ALL and evidence.paths < self.enough else verified
        return Judgement((found,), tuple(LevelFinding("x", level, 0.0) for level in range(levels)))


EULER = EulerMaruyama()


def run(*measures, schemes=(EULER,), settings=SETTINGS, family=gbm, resolve=None):
    """Return the results of a study."""
    study = Study(plan(schemes, [problem_spec(family)], measures, resolve), settings)
    for _ in study.run():
        pass
    return study.results()


def finding(verdict, claim=ORDER, **other):
    """Return a finding on a claim."""
    return Finding(quantity="x", verdict=verdict, claim=claim, **other)


WEAK_GUARD = Reason("{paths} paths show nothing", Kind.GUARD, {"paths": 9}).then(
    Reason("about {paths} would", Kind.MORE_PATHS, {"paths": 900})
)


@pytest.mark.parametrize(
    ("said", "levels"),
    [
        (finding(Verdict.VERIFIED, tier=1), FEW),
        (finding(Verdict.REFUTED, tier=2), FEW),
        (finding(Verdict.VERIFIED, EXACT), FEW),
        (finding(Verdict.OUT_OF_SCOPE, None), FEW),
        (finding(Verdict.VERIFIED), ALL),
        (finding(Verdict.REFUTED), ALL),
        (finding(Verdict.REFUTED, EXACT), ALL),
        (finding(Verdict.INCONCLUSIVE), ALL),
        (finding(Verdict.INCONCLUSIVE, tier=1), ALL),
        (finding(Verdict.INCONCLUSIVE, settled=False), ALL),
        (finding(Verdict.INCONCLUSIVE, settled=False, reason=WEAK_GUARD), ALL),
    ],
    ids=lambda value: (
        f"{value.verdict} {value.tier} {value.reason.kind}" if isinstance(value, Finding) else str(value)
    ),
)
def test_few_levels_are_enough_where_one_step_decides(said, levels):
    """What paths decide or leave open is run again on all levels, and nothing of the guards is left in it."""
    (result,) = run(Told(said))

    assert len(result.levels) == len(result.health.sums["steps"]) == levels
    assert result.findings[0].verdict is (said.verdict if levels == FEW else Verdict.VERIFIED)
    assert result.paths == 256


def test_guards_that_are_too_weak_take_more_paths_before_they_take_more_levels():
    """Where so many more paths would guard, these are taken on the same levels."""
    (result,) = run(Told(finding(Verdict.INCONCLUSIVE, settled=False, reason=WEAK_GUARD), enough=1000))

    assert (len(result.levels), result.paths) == (FEW, 1024)


def test_what_waits_for_all_levels_is_not_decided():
    """A run that is stopped before all levels were tried tells so, whatever paths have said of a claim on few."""
    study = Study(plan([EulerMaruyama()], [problem_spec(gbm)], [Told(finding(Verdict.VERIFIED))]), SETTINGS)
    for _ in study.run():
        if study.problems[0].runs[0].result is not None:
            break
    study.stopped = "interrupted"

    (found,) = study.results()[0].findings

    assert found.verdict is Verdict.INCONCLUSIVE
    assert str(found.reason) == f"interrupted; {FINER}"


def resolve(label):
    """Return a control of gbm's strong order 1."""
    return {scheme.label: scheme for scheme in (EulerMaruyama(), Milstein(), DisplacedEuler())}[label]


def test_controls_are_on_the_levels_of_those_they_are_for():
    """With small noise, a scheme that paths alone can judge is held against its controls on all levels."""
    one, other = run(
        Strong(),
        schemes=(Milstein(), Remembering()),
        family=small_noise,
        resolve=resolve,
        settings=Settings(paths=1024),
    )

    assert {found.verdict for found in one.findings} == {Verdict.VERIFIED}
    assert len(one.health.sums["steps"]) == FEW
    assert {found.verdict for found in other.findings} == {Verdict.INCONCLUSIVE}
    assert len(other.health.sums["steps"]) == ALL


def test_a_wrong_limit_is_refuted_behind_a_right_step():
    """Paths that guard refute what tends to another equation's solution, however right one step is made to look."""
    truth = gbm(b=0.9).pathwise
    wrong = lambda: replace(gbm(), truths=(truth,), controls=())  # noqa: E731
    wrong.__name__ = "wrong"

    (result,) = run(Strong(), family=wrong)

    assert {(found.verdict, found.tier) for found in result.findings} == {(Verdict.REFUTED, 3)}
    assert len(result.levels) >= 2 * ALL


def test_who_says_which_levels_sees_them():
    """Levels that are given are those of all paths, unless guards are given, too."""
    assert settings_from().guards.levels == FEW
    assert settings_from(levels=5).guards.levels == 5
    assert settings_from(levels="8..256").guards.levels == 6
    assert settings_from(levels=5, first_levels=3).guards.levels == 3


def test_the_levels_of_guards_are_those_of_all_paths():
    """What is noted of the coarse levels has the same bits, whether finer ones were drawn beside them or not."""
    few, every = (
        verify("milstein", "gbm", "strong", paths=256, first_levels=n).levels.set_index(["quantity", "steps"])
        for n in (FEW, ALL)
    )

    assert len(few) < len(every)
    assert few.estimate.equals(every.loc[few.index].estimate)
