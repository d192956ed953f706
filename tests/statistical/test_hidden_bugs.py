"""No claim is verified that is false, also where nothing refutes it; what has to be refuted is a planted bug."""

import pytest

from sdaeverify import verify
from sdaeverify_lab.planted._within import ScaledEuler

FALSE = {
    "h < 1e-5": (ScaledEuler("h", high=1e-5, of_drift=0.5), "gbm", ("strong", "weak")),
    "early window of a long run": (ScaledEuler("part", 0.005, 0.055, noise_share=0.98), "gbm[horizon=16]", "strong"),
    "second window of a long run": (ScaledEuler("part", 0.07, 0.12, noise_share=0.98), "gbm[horizon=16]", "strong"),
    "two thirds of a long run": (ScaledEuler("part", 0.26, 0.93, noise_share=0.98), "ou[horizon=16]", "strong"),
}


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "problem", "measures"), FALSE.values(), ids=FALSE)
def test_what_is_false_is_not_verified(scheme, problem, measures):
    """None of the false claims of a cell is verified, and there are some."""
    table = verify([scheme], [problem], measures, paths=4096).verdicts
    false = table[(table.scheme == scheme.label) & (table.claim != "")]

    assert len(false)
    assert false[false.verdict == "verified"].empty, false[["measure", "quantity", "verdict", "reason"]].to_string()
