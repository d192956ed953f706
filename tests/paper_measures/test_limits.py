"""The limits measure: exponents of eps that are known, and schemes that have no limit."""

from dataclasses import replace

import pytest

from facade import EulerMaruyama, ou, penalised_sphere
from paper_measures.stiff_cells import AFFINE, Explicit, Ignorant, Leaving, Right, judged, whole
from sdaeverify import Claim
from sdaeverify.measuring import Verdict
from sdaeverify_measures.limits import StiffLimits

MEASURE = StiffLimits()
KEPT = dict.fromkeys(("x", "zeta", "x without noise", "zeta without noise"), Verdict.VERIFIED)


@pytest.mark.parametrize("xi", ["gaussian", "three-point"])
def test_exponents_of_the_theory_are_verified(xi):
    """Distances of the uniformly accurate scheme behave like sqrt(eps), without noise like eps."""
    found = judged(MEASURE, Right(xi=xi), AFFINE)

    assert {name: finding.verdict for name, finding in found.items()} == KEPT
    assert [finding.estimate for finding in found.values()] == pytest.approx([0.5, 0.5, 1.0, 1.0], abs=1e-4)


def test_a_scheme_that_leaves_the_manifold_is_refuted():
    """The explicit expansion tends to a limit on the sphere that does not keep the constraint."""
    found = judged(MEASURE, Leaving(), penalised_sphere(d=3))

    assert found["zeta"].verdict is Verdict.REFUTED
    assert found["zeta"].estimate == pytest.approx(0.0, abs=0.01)
    assert found["x"].verdict is Verdict.VERIFIED


def test_exponents_that_are_claimed_too_high_are_refuted():
    """With noise the exponent is not 1; words decide nothing; and without a claim it is shown."""
    high = Claim(measure="limits", quantities=("x",), value=1.0, source="test")
    words = Claim(measure="limits", quantities=("zeta",), value="soon", source="test")
    found = judged(MEASURE, Right(), AFFINE, high, words)

    assert {name: found[name].verdict for name in found} == {
        "x": Verdict.REFUTED,
        "zeta": Verdict.INCONCLUSIVE,
        "x without noise": Verdict.OUT_OF_SCOPE,
        "zeta without noise": Verdict.OUT_OF_SCOPE,
    }


def test_what_ignores_eps_is_in_its_limit():
    """Constrained Euler differs from its limit by rounding at most, which keeps any exponent."""
    found = judged(MEASURE, Ignorant(), AFFINE)

    assert {name: finding.verdict for name, finding in found.items()} == KEPT
    assert str(found["x"].reason) == "no distance beyond round-off at any of 7 eps"


def test_distances_are_shown_for_every_eps():
    """On the affine problem |zeta| in the root mean square is proportional to sqrt(eps) to three digits."""
    rows = [row for row in whole(MEASURE, Right(), AFFINE).levels if row.quantity == "zeta"]
    ratios = [row.estimate / row.details["eps"] ** 0.5 for row in rows]

    assert len(rows) == 7
    assert ratios == pytest.approx([ratios[0]] * 7, rel=1e-3)


def test_paths_without_root_leave_it_open():
    """Where more than one path in a hundred meets a step without root, nothing is decided."""
    problem = replace(penalised_sphere(d=3, horizon=500.0), truths=())
    found = {finding.quantity: finding for finding in whole(MEASURE, Right(), problem).findings}

    assert {finding.verdict for finding in found.values()} == {Verdict.INCONCLUSIVE}
    assert "no root on 100 % of the paths" in str(found["x"].reason)


def test_what_makes_no_sense_is_refused():
    """Equations without eps, schemes without claim, and schemes that have no limit."""
    assert "no stiffness parameter" in MEASURE.refuses(EulerMaruyama(), ou())
    assert "not run in the limit eps = 0" in MEASURE.refuses(Explicit(), AFFINE)
