"""The effort measure: bounds that are kept, exceeded, or about to be."""

from functools import partial

import pytest

from measures.stiff_cells import AFFINE, Climbing, Explicit, Right, judged, whole
from sdaeverify import Claim
from sdaeverify.measure import Verdict
from sdaeverify.measures.effort import Effort
from sdaeverify_problems.constrained_curve import constrained_curve
from sdaeverify_problems.exponential_strip import exponential_strip
from sdaeverify_problems.penalised_sphere import penalised_sphere
from sdaeverify_problems.rigid_trimer import rigid_trimer
from sdaeverify_problems.sphere_product import sphere_product
from sdaeverify_problems.torus import torus
from sdaeverify_problems.tube_torus import tube_torus
from sdaeverify_schemes.uniformly_accurate import UniformlyAccurate

MEASURE, NAME = Effort(), "newton_iterations"


def at_most(count):
    """Return the claim of a bound."""
    return Claim(measure="effort", value=f"at most {count} iterations", source="test")


CURVED = {
    "torus": torus,
    "tube torus": tube_torus,
    "sphere": partial(penalised_sphere, d=3),
    "trimer": rigid_trimer,
    "two spheres": sphere_product,
    "curve": constrained_curve,
}


@pytest.mark.parametrize("theta", [0.0, pytest.param(1.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", CURVED)
def test_newton_takes_three_to_four_iterations_on_curved_problems(name, theta):
    """The means lie between 2.5 and 4.5 for all eps from 1e-8 to 10, and no step takes more than five."""
    found = judged(MEASURE, Right(theta=theta), CURVED[name]())[NAME]

    assert found.verdict is Verdict.VERIFIED
    assert 2.5 < found.low <= found.estimate < 4.5
    assert found.high <= 5.0


@pytest.mark.parametrize("problem", [AFFINE, exponential_strip()])
def test_newton_is_bounded_by_five_for_every_eps(problem):
    """No step takes more than five iterations, and the mean does not grow as eps tends to 0."""
    found = judged(MEASURE, Right(), problem)[NAME]

    assert found.verdict is Verdict.VERIFIED
    assert found.low <= found.estimate <= found.high <= 5.0


def test_one_step_beyond_the_bound_refutes_it():
    """A single path in 256 that takes four more iterations is a counterexample."""
    found = judged(MEASURE, Climbing(more=4), AFFINE)[NAME]

    assert found.verdict is Verdict.REFUTED
    assert found.reason.startswith("6 iterations in a step")


def test_growth_below_the_bound_is_refuted():
    """Iterations that grow by 0.3 in each decade of 1/eps stay below five on the grid and have no bound."""
    found = judged(MEASURE, Climbing(slope=0.3), AFFINE)[NAME]

    assert found.high <= 5.0
    assert found.verdict is Verdict.REFUTED
    assert "more for eps = 1e-08" in found.reason


def test_claims_that_are_too_low_unknown_or_not_made():
    """One iteration is too few for Newton, other words and numbers decide nothing."""
    assert judged(MEASURE, Right(), AFFINE, at_most(1))[NAME].verdict is Verdict.REFUTED
    for value in ("few", 5.0):
        unknown = Claim(measure="effort", value=value, source="test")
        assert judged(MEASURE, Right(), AFFINE, unknown)[NAME].verdict is Verdict.INCONCLUSIVE


def test_means_are_shown_for_every_eps():
    """Two values of eps a decade from 1e-8 to 10; a linear problem takes two iterations for each of them."""
    rows = whole(MEASURE, Right(), AFFINE).levels

    assert [row.details["eps"] for row in rows] == pytest.approx([10.0 ** (-8 + 0.5 * k) for k in range(19)])
    assert {row.estimate for row in rows} == {2.0}


def test_what_makes_no_sense_is_refused():
    """Schemes that solve nothing, and schemes without claim."""
    assert MEASURE.refuses(Explicit(), AFFINE) == "its steps report no iterations"
    scheme = UniformlyAccurate()
    unclaimed = not any(claim.measure == "effort" for claim in scheme.promises)
    assert bool(MEASURE.refuses(scheme, AFFINE)) is unclaimed
