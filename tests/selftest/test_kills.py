"""The kill matrix: bugs by check, survivors, equivalent changes, false alarms."""

import pytest

from facade import Refuter, kill_matrix, selftest_trial
from sdaeverify.measuring import Verdict

from .conftest import Bad, Blunt, Good, bug, curve

SHARP = Refuter(1, "sharp")


def matrix_of(registry, results):
    return kill_matrix(selftest_trial(registry), results)


def test_refuted_bug_is_killed(registry_of, result_of):
    """A bug is killed by the measure and the tier that refute one of its claims."""
    matrix = matrix_of(registry_of(bug()), [result_of(Bad(), Verdict.REFUTED)])

    (found,) = matrix.bugs
    assert found.kills == {SHARP}
    assert found.reason == "sharp x refuted: refuted by tier 1"
    assert found.seconds == 0.5
    assert matrix.passed
    assert not matrix.survivors


def test_several_checks(registry_of, result_of):
    """All checks that refute it are counted, those that do not are columns all the same."""
    results = [
        result_of(Bad(), Verdict.REFUTED),
        result_of(Bad(), Verdict.REFUTED, tier=3, measure=Blunt()),
        result_of(Good(), Verdict.VERIFIED, tier=2),
    ]

    matrix = matrix_of(registry_of(bug()), results)

    assert matrix.bugs[0].kills == {SHARP, Refuter(3, "blunt")}
    assert matrix.checks == (SHARP, Refuter(2, "sharp"), Refuter(3, "blunt"))


def test_contract_is_one_check(registry_of, result_of):
    """A violation of contract is the same check, whichever measure it keeps from being made."""
    results = [result_of(Bad(), Verdict.REFUTED, 0), result_of(Bad(), Verdict.REFUTED, 0, measure=Blunt())]

    assert matrix_of(registry_of(bug()), results).bugs[0].kills == {Refuter(0, "contract")}


@pytest.mark.parametrize("verdict", sorted(set(Verdict) - {Verdict.REFUTED}))
def test_whatever_is_not_refuted_survives(registry_of, result_of, verdict):
    """Neither an inconclusive bug nor one in error is killed."""
    matrix = matrix_of(registry_of(bug()), [result_of(Bad(), verdict)])

    assert [found.planted for found in matrix.survivors] == [bug()]
    assert not matrix.passed


def test_one_refuted_bug_does_not_hide_another(registry_of, result_of):
    """Every bug must be refuted, not most of them."""
    registry = registry_of(bug(), bug("other"))

    matrix = matrix_of(registry, [result_of(Bad(), Verdict.REFUTED), result_of(Bad("other"), Verdict.VERIFIED)])

    assert [found.planted.scheme.kind for found in matrix.survivors] == ["other"]
    assert not matrix.passed


def test_same_scheme_on_two_problems(registry_of, result_of):
    """A bug is refuted on its own problem or not at all."""
    registry = registry_of(bug(), bug(problem="curve"))
    results = [result_of(Bad(), Verdict.REFUTED), result_of(Bad(), Verdict.VERIFIED, problem=curve)]

    matrix = matrix_of(registry, results)

    assert [found.planted.problem for found in matrix.survivors] == ["curve"]


@pytest.mark.parametrize(("verdict", "passed"), [(Verdict.VERIFIED, True), (Verdict.REFUTED, False)])
def test_equivalent_change(registry_of, result_of, verdict, passed):
    """A change that is no bug must survive, and is no survivor."""
    matrix = matrix_of(registry_of(bug(equivalent="it cancels")), [result_of(Bad(), verdict)])

    assert matrix.passed is passed
    assert not matrix.survivors
    assert len(matrix.equivalents) == 1


def test_false_alarm(registry_of, result_of):
    """A refuted claim of a registered scheme fails the test, although every bug is refuted."""
    results = [result_of(Bad(), Verdict.REFUTED), result_of(Good(), Verdict.REFUTED)]

    matrix = matrix_of(registry_of(bug()), results)

    assert [judged.cell.scheme.name for judged in matrix.false_alarms] == ["good"]
    assert not matrix.passed


def test_error_of_a_registered_scheme_is_no_false_alarm(registry_of, result_of):
    """What could not be measured of a registered scheme is neither right nor wrong, and is told."""
    matrix = matrix_of(registry_of(bug()), [result_of(Bad(), Verdict.REFUTED), result_of(Good(), Verdict.ERROR)])

    assert matrix.passed
    assert len(matrix.unmeasured) == 1


def test_bug_that_was_not_run_survives(registry_of):
    """A bug without a problem is a survivor, and says why."""
    matrix = matrix_of(registry_of(bug(problem="lime")), [])

    (found,) = matrix.survivors
    assert found.reason.startswith("not run: unknown problem 'lime'")


def test_reason_of_a_survivor_is_about_a_claim(registry_of, result_of):
    """Beside what does not apply, the finding on a claim is the one that is told."""
    results = [result_of(Bad(), Verdict.NOT_APPLICABLE, measure=Blunt()), result_of(Bad(), Verdict.VERIFIED, tier=3)]

    assert matrix_of(registry_of(bug()), results).bugs[0].reason == "sharp x verified: verified by tier 3"
