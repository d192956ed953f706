"""Verdicts on claims about one step for all eps: kept, broken, without roots, and not made."""

import numpy as np
import pytest

from facade import ONE_STEP, UniformDefects, Uniformity, sphere_product
from facade import uniform_errors_LEVELS as LEVELS
from paper_measures.stiff_cells import AFFINE, SETTINGS, UNIFORM, Right, replace_claims
from sdaeverify import Claim
from sdaeverify.measuring import Evidence, Tally, Verdict, packed

CLAIM = Claim(measure="uniformity", quantities=(ONE_STEP,), value=1.5, source="test")
MOMENTS = 5


def record(order, euler=2.0, failed=0):
    """Return defects of some orders, the first moment's order being given, with roots but at some long steps."""
    orders = np.array([order, 1.5, 2.0, 1.5, 1.5])[:, None]
    floor = np.full((MOMENTS, len(LEVELS)), 1e-16)
    return UniformDefects(
        LEVELS,
        LEVELS**orders,
        np.ones((MOMENTS, len(LEVELS))),
        LEVELS ** np.where(orders == order, euler, 2.0),
        floor,
        floor,
        np.where(np.arange(len(LEVELS)) < failed, 0.1, 0.0),
    )


def findings(given, *claims):
    """Return the findings on a record."""
    evidence = Evidence(replace_claims(Right(), claims), AFFINE, AFFINE, SETTINGS, packed(ONE_STEP, given), Tally())
    return {finding.quantity: finding for finding in Uniformity().judge(evidence).findings}


@pytest.mark.parametrize(
    ("given", "verdict"),
    [
        (record(1.5), Verdict.VERIFIED),
        (record(1.0), Verdict.REFUTED),
        (record(1.5, euler=1.0), Verdict.REFUTED),
        (record(1.0, failed=2), Verdict.REFUTED),
        (record(1.5, failed=2), Verdict.VERIFIED),
        (record(1.5, failed=3), Verdict.INCONCLUSIVE),
        (record(np.nan), Verdict.INCONCLUSIVE),
    ],
)
def test_the_least_order_of_all_moments_decides(given, verdict):
    """A claim of 3/2 needs it of each moment, against half steps and Euler's, at three step sizes with roots."""
    found = findings(given, CLAIM)[ONE_STEP]

    assert found.verdict is verdict
    assert found.tier == 1


def test_orders_that_still_change_decide_nothing():
    """Order 1.2 at the finest steps, and rising by a tenth from one to the next, is not held against the claim."""
    local = 1.0 + 0.1 * np.arange(len(LEVELS))
    sizes = np.exp(-np.cumsum(np.log(4.0) * local))
    found = findings(record(1.5)._replace(halves=np.tile(sizes, (MOMENTS, 1))), CLAIM)

    assert found[ONE_STEP].verdict is Verdict.VERIFIED
    rising = np.exp(-np.cumsum(np.log(4.0) * (local - 0.2)))
    found = findings(record(1.5)._replace(halves=np.tile(rising, (MOMENTS, 1))), CLAIM)
    assert found[ONE_STEP].verdict is Verdict.INCONCLUSIVE


def test_words_decide_nothing_and_orders_along_paths_are_no_claim_about_one_step():
    """One step is judged where it is named."""
    words = Claim(measure="uniformity", quantities=(ONE_STEP,), value="always", source="test")

    assert findings(record(1.5), words)[ONE_STEP].verdict is Verdict.INCONCLUSIVE
    assert ONE_STEP not in findings(record(1.5), UNIFORM)


def test_what_cannot_be_probed_is_inconclusive_and_says_why():
    """Too many atoms leave the claim open."""
    problem, scheme = sphere_product(), replace_claims(Right(xi="three-point"), (CLAIM,))
    found = Uniformity().judge(Evidence(scheme, problem, problem, SETTINGS, Tally(), Tally())).findings[-1]

    assert (found.quantity, found.verdict) == (ONE_STEP, Verdict.INCONCLUSIVE)
    assert "too many values" in str(found.reason)
