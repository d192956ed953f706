"""Shipped schemes, changed: what is wrong by a known amount is not verified, what is rewritten is not refuted."""

from itertools import groupby
from math import inf

import pandas as pd
import pytest

from mutation.bench import Case, judged, mutants, rewritings, wrongly_verified
from mutation.difference import orders
from mutation.sources import SAME, WRONG, places, variant
from sdaeverify_problems.gbm import gbm
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein import Milstein

# Of one scheme on one problem: 45 such pairs make more than 300 of either kind.
EACH = 8
SHARE = 0.99


def _verdicts(cases: list[Case]) -> pd.DataFrame:
    groups = groupby(cases, key=lambda case: (case.told.partition(":")[0], case.problem))
    return pd.concat([judged(list(group)) for _, group in groups])


def test_the_difference_of_one_step_tells_the_order_that_is_left():
    """Euler-Maruyama differs from Milstein's scheme by so much that order 1/2, and weak order 1, is left on gbm."""
    left = orders(Milstein(), EulerMaruyama(), gbm())

    assert left.strong["x"] == pytest.approx(0.5, abs=0.01)
    assert left.weak["x"] == inf
    assert left.weak["x^2"] == pytest.approx(1.0, abs=0.05)


def test_a_rewriting_differs_by_rounding_and_a_mutant_by_more():
    """Milstein's scheme written in another way at any place makes the same steps; with a sign changed it does not."""
    same = [variant(Milstein(), [place], SAME, "rewriting").scheme for place in places(Milstein(), SAME)]
    signs = [place for place in places(Milstein(), WRONG) if place.kind == "sign"]
    wrong = [variant(Milstein(), [place], WRONG, "mutant").scheme for place in signs]

    assert len(same) > 5
    assert len(wrong) > 2
    assert all(orders(Milstein(), scheme, gbm()).same for scheme in same)
    assert not any(orders(Milstein(), scheme, gbm()).same for scheme in wrong)


@pytest.mark.slow
def test_mutants_are_not_verified():
    """Of 300 mutants and more 99 in 100 have nothing verified that their difference from the original contradicts."""
    cases = list(mutants(seed=1, each=EACH))
    wrong = wrongly_verified(_verdicts(cases))

    assert len(cases) >= 300
    assert wrong.told.nunique() <= (1.0 - SHARE) * len(cases), wrong[
        ["told", "measure", "quantity", "left", "reason"]
    ]


@pytest.mark.slow
def test_rewritings_are_not_refuted():
    """Of 300 rewritings and more, which differ by rounding alone, none has a claim refuted or a cell in error."""
    cases = list(rewritings(seed=1, each=EACH))
    table = _verdicts(cases)
    refuted = table[table.verdict.isin(["refuted", "error", "diverged"])]

    assert len(cases) >= 300
    assert all(case.left.same for case in cases)
    assert refuted.empty, refuted[["told", "measure", "quantity", "reason"]]
