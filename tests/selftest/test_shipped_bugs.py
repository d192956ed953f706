"""The shipped planted bugs: all are refuted, and most of them by more than one line of defence."""

import pytest

from facade import Study, kill_matrix, load_registry, selftest_trial
from sdaeverify import Settings
from sdaeverify.simulate import ensemble

pytestmark = pytest.mark.long

SETTINGS = Settings(paths=1024, max_looks=3)
# Of these, only the contract and exactness tell.
CONTRACT_ALONE = {
    "planted-em-batch-maximum on gbm",
    "planted-em-hidden-state on gbm",
    "planted-em-in-place on gbm",
    "planted-em-own-noise on gbm",
    "planted-em-single-precision on gbm",
}
# Of these, some that are wrong in a narrow region, far out or in a short window are told by the law of single steps
# alone, one by its memory: both are looked at with the contract.
LAW_ALONE = {
    "planted-em-scaled[mark=part,low=0.005,high=0.055,noise_share=0.98] on ou",
    "planted-em-scaled[mark=starts,low=1.5,drift=0.5] on linear-test",
    "planted-em-scaled[mark=x_1,low=-0.03,high=0.08,drift=0] on double-well",
    "planted-em-scaled[mark=x_1,low=1.2,high=1.5,drift=1.2] on gbm",
    "planted-em-scaled[mark=x_1,low=1.2,high=1.5,noise_share=0.9] on gbm",
    "planted-em-stale[low=0.6,high=0.9] on gbm",
}


# Of these, order conditions alone tell.
TREES_ALONE = {
    "planted-platen-general-old-drift on noncommuting",
    "planted-platen-general-old-noise on levy-area",
}


def matrix_of(only, *, orders=True):
    trial = selftest_trial(load_registry(environ={}, lab=True), only)
    study = Study(trial.plan, SETTINGS, orders=orders)
    for _ in study.run():
        pass
    return kill_matrix(trial, [*study.results(), *(study.class_results or ())])


@pytest.mark.slow
def test_every_bug_is_refuted_and_nothing_else():
    """All planted bugs are refuted, equivalent changes and registered schemes are not."""
    matrix = matrix_of("*")

    assert [bug.planted.label for bug in matrix.survivors] == []
    assert [bug.planted.label for bug in matrix.equivalents if bug.kills] == []
    assert [(alarm.cell.scheme.label, alarm.cell.spec.label) for alarm in matrix.false_alarms] == []
    assert matrix.passed


@pytest.mark.slow
def test_without_the_contract_the_measures_refute_what_they_can_see(monkeypatch):
    """Where contract and exactness are not checked, the measures refute every bug whose step is a pure function."""
    monkeypatch.setattr(ensemble, "violation", lambda scheme, view, **_: "")

    matrix = matrix_of("planted-*", orders=False)

    assert {bug.planted.label for bug in matrix.survivors} == CONTRACT_ALONE | LAW_ALONE | TREES_ALONE
    assert [bug.planted.label for bug in matrix.equivalents if bug.kills] == []


@pytest.mark.slow
def test_order_conditions_refute_what_a_problem_cannot_show():
    """Two wrong stages of Platen's scheme leave no trace on their problem: a tree alone tells."""
    unseen = [bug for bug in matrix_of("planted-platen-general-old-*").bugs if bug.planted.label in TREES_ALONE]

    assert len(unseen) == len(TREES_ALONE)
    assert {str(kill) for bug in unseen for kill in bug.kills} == {"weak TA"}


def test_table_of_planted_bugs_is_complete():
    """At least the planted bugs of the reference table are there, two equivalent changes among them."""
    bugs = load_registry(environ={}, lab=True).things("sdaeverify_planted").values()

    assert sum(not bug.equivalent for bug in bugs) >= 41 + 8
    assert sum(bool(bug.equivalent) for bug in bugs) >= 2
    assert len({bug.bug for bug in bugs}) == len(bugs)
