"""Errors over a whole run: Holm's procedure, and what it makes of the findings."""

from dataclasses import replace

import numpy as np
import pytest

from facade import CellResult, family_wise, holm
from sdaeverify import Claim
from sdaeverify.measuring import Finding, Reason, Verdict

CLAIM = Claim(measure="strong", value=1.0, source="a theorem")
OPEN = Finding(
    quantity="x", verdict=Verdict.INCONCLUSIVE, claim=CLAIM, reason=Reason("order 0.9"), p_verified=0.5, p_refuted=0.5
)


def result(*findings):
    """Return a cell with these findings; which cell it is does not matter here."""
    return CellResult(None, findings)


def verdicts(results):
    """Return the verdicts of all findings."""
    return [finding.verdict for one in results for finding in one.findings]


def test_holm_rejects_as_in_the_published_example():
    """Holm (1979): sorted p-values are compared with alpha/m, alpha/(m-1), ... up to the first that fails."""
    p = {(0, 0): 0.01, (0, 1): 0.04, (1, 0): 0.03, (1, 1): 0.005}

    assert holm(p, 0.05) == {(0, 0), (1, 1)}


def test_what_is_no_test_does_not_count():
    """A deterministic verdict makes the correction of the others no harder."""
    p = {(0, 0): 0.04, (0, 1): float("nan"), (0, 2): float("nan")}

    assert holm(p, 0.05) == {(0, 0)}


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({"p_verified": 1e-5}, Verdict.VERIFIED),
        ({"p_refuted": 1e-5}, Verdict.REFUTED),
        ({"p_verified": 0.009}, Verdict.INCONCLUSIVE),
        ({"p_verified": 1e-5, "claim": None}, Verdict.INCONCLUSIVE),
        ({"p_verified": 1e-5, "tier": 1}, Verdict.INCONCLUSIVE),
        ({"p_verified": 1e-5, "verdict": Verdict.DIVERGED}, Verdict.DIVERGED),
        ({"verdict": Verdict.REFUTED, "p_verified": np.nan, "p_refuted": np.nan}, Verdict.REFUTED),
    ],
)
def test_undecided_findings_are_decided_over_all_tests_of_the_run(changes, verdict):
    """A claim that is significant among all tests of the run is decided, nothing else is."""
    others = [replace(OPEN, quantity=str(k)) for k in range(19)]

    found = family_wise([result(replace(OPEN, **changes)), result(*others)], 0.01)

    assert verdicts(found)[0] is verdict
    assert set(verdicts(found)[1:]) == {Verdict.INCONCLUSIVE}


def test_early_verdicts_are_taken_back_in_a_run_with_too_many_tests():
    """A verdict taken early for a smaller family is inconclusive where the run holds more tests than that."""
    early = replace(OPEN, verdict=Verdict.REFUTED, p_refuted=1e-5)
    others = [replace(OPEN, quantity=str(k)) for k in range(2000)]

    (first, *_) = verdicts(family_wise([result(early, *others)], 0.01))
    (alone,) = verdicts(family_wise([result(early)], 0.01))

    assert first is Verdict.INCONCLUSIVE
    assert alone is Verdict.REFUTED


def test_the_family_wise_error_is_kept():
    """Among runs of 60 true hypotheses, at most a share alpha refutes any; uncorrected, most runs would."""
    rng = np.random.default_rng(1)
    runs, alpha = 2000, 0.05
    p = rng.uniform(size=(runs, 60))
    any_holm = np.mean([bool(holm({(0, j): value for j, value in enumerate(row)}, alpha)) for row in p])

    # 0.05 + 3.1 standard errors of a share of 2000 runs, a one-sided level of 0.001.
    assert any_holm <= alpha + 3.1 * np.sqrt(alpha * (1 - alpha) / runs)
    assert np.mean((p < alpha).any(axis=1)) > 0.9
