"""What a calibration does, as asked for."""

import pytest

from facade import (
    SEQUENCE,
    SEQUENCES_A_BLOCK,
    STUDIES,
    CalibrationCase,
    ChainJob,
    PathJob,
    calibration_plan,
    load_registry,
    path_settings,
)
from sdaeverify import Claim, ProblemError, Settings, UsageError

CONSTRAINED = "half-explicit-euler[truncation=none]"
OF_STRONG = set(STUDIES) - {"mean differences"}


@pytest.fixture(scope="module")
def registry():
    """Return what is installed."""
    return load_registry(lab=True)


def test_everything_is_done_by_default(registry):
    """Without patterns every case has all studies it is for, and the families are simulated."""
    plan = calibration_plan(registry, seed=1, repetitions=400)

    assert {placed.case.label for placed in plan.placed} == set(registry.things("sdaeverify_calibration"))
    assert {study for placed in plan.placed for study in placed.studies} == {*STUDIES, "chains"}
    assert plan.families


@pytest.mark.parametrize(
    ("pattern", "cases", "studies"),
    [
        ("milstein on gbm", {"milstein on gbm", "milstein on gbm-heavy"}, OF_STRONG),
        (CONSTRAINED, {f"{CONSTRAINED} on pendulum"}, OF_STRONG),
        ("chains*on ou", {"euler-maruyama on ou"}, {"chains"}),
    ],
)
def test_patterns_choose_studies_and_cases(registry, pattern, cases, studies):
    """A pattern is looked for in the names of study and case, brackets of a label included."""
    plan = calibration_plan(registry, 1, 400, [pattern])

    assert {placed.case.label for placed in plan.placed} == cases
    assert {study for placed in plan.placed for study in placed.studies} == studies
    assert not plan.families


def test_families_need_no_jobs(registry):
    """The families alone need neither paths nor worker processes."""
    plan = calibration_plan(registry, 1, 40, ["families"])

    assert plan.jobs() == []
    assert len(plan.family_rates()) == 6


def test_a_share_makes_fewer_repetitions(registry):
    """Repetitions are counted in samples of 400 paths; a case with a share makes that part of them."""
    jobs = calibration_plan(registry, 1, 400, ["slope*gbm", "slope*circle"]).jobs()

    blocks = {label: sum(job.label == label for job in jobs) for label in ("gbm", "circle")}
    assert blocks == {label: share * 400 * 400 / (SEQUENCE * SEQUENCES_A_BLOCK) for label, share in
                      (("gbm", 1.0), ("circle", 0.52))}  # fmt: skip
    assert all(isinstance(job, PathJob) and not job.judged for job in jobs)


def test_blocks_are_full():
    """The blocks that are run are all of one size, and enough."""
    settings, blocks = path_settings(3, 10)

    assert {settings.paths_of(block) for block in blocks} == {settings.block}
    assert len(blocks) * SEQUENCES_A_BLOCK >= 10
    assert settings.seed == 3


def test_chains_are_split_into_equal_halves(registry):
    """The repetitions of chains are an even number: each half is the other's truth."""
    jobs = calibration_plan(registry, 1, 41, ["chains"]).jobs()

    assert {job.repetitions for job in jobs if isinstance(job, ChainJob)} == {40}


@pytest.mark.parametrize(("repetitions", "only", "words"), [(39, (), "at least 40"), (40, ("nonsense",), "nonsense")])
def test_what_makes_no_sense_is_refused(registry, repetitions, only, words):
    """Too few repetitions and patterns that leave nothing are errors of the user."""
    with pytest.raises(UsageError, match=words):
        calibration_plan(registry, Settings().seed, repetitions, only)


def test_orders_of_the_cases_are_claimed(registry):
    """The order of each registered case is one that its scheme claims: nothing is taken from a measurement."""
    for case in registry.things("sdaeverify_calibration").values():
        scheme = registry.schemes[case.scheme.partition("[")[0]].variants[0]
        claims = [claim for claim in scheme.promises if isinstance(claim, Claim) and claim.measure == "strong"]
        assert case.order in {claim.value.least for claim in claims}, case.label


@pytest.mark.parametrize("wrong", [{"order": 0.0}, {"share": 0.0}, {"share": 1.5}])
def test_cases_that_make_no_sense_are_refused(wrong):
    """An order is positive, a share a part."""
    with pytest.raises(ProblemError):
        CalibrationCase(**{"scheme": "s", "problem": "p", "order": 1.0, **wrong})


def test_a_plugin_file_adds_its_own_case(tmp_path):
    """Who writes a problem can have the intervals tried out on it."""
    file = tmp_path / "mine.py"
    file.write_text(
        "from sdaeverify import hookimpl\nfrom sdaeverify_lab import CalibrationCase\n\n\n"
        "@hookimpl\ndef sdaeverify_calibration():\n"
        "    return [CalibrationCase(scheme='tamed-euler', problem='ou', order=1.0)]\n"
    )

    plan = calibration_plan(load_registry([file], lab=True), 1, 40, ["tamed-euler on ou"])

    assert [placed.case.label for placed in plan.placed] == ["tamed-euler on ou"]
