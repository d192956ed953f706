"""The effort measure: bounds that are kept, exceeded, or about to be."""

import numpy as np
import pytest
from scipy.stats import binom

from facade import UniformlyAccurate, exponential_strip, penalised_sphere
from paper_measures.stiff_cells import AFFINE, SETTINGS, Climbing, Explicit, Right, judged, probed, whole
from sdaeverify import Claim
from sdaeverify.measuring import Evidence, Tally, Verdict, packed, unpacked
from sdaeverify_measures.effort import ALONG, PROBED, Effort, chernoff
from sdaeverify_measures.effort.iterations import RUNS, Iterations, RunIterations

MEASURE, NAME = Effort(), "newton_iterations"


def at_most(count):
    """Return the claim of a bound."""
    return Claim(measure="effort", value="iterations", bound=count, source="test")


def often(most, part):
    """Return the claim of a bound in a part of the steps."""
    return Claim(measure="effort", value="iterations", bound=most, share=part / 100, source="test")


def test_newton_takes_three_to_four_iterations_on_a_sphere():
    """The means lie between 2.5 and 4.5 for all eps from 1e-8 to 10; along runs, few steps take more than six."""
    found = judged(MEASURE, Right(), penalised_sphere(d=3), often(6, 90))[NAME]

    assert found.verdict is Verdict.VERIFIED
    assert 2.5 < found.low <= found.estimate < 4.5


@pytest.mark.sweep
@pytest.mark.parametrize(("problem", "most"), [(AFFINE, 2), (exponential_strip(), 6)])
def test_newton_is_bounded_for_every_eps(problem, most):
    """No step takes more iterations, and the mean does not grow as eps tends to 0."""
    found = judged(MEASURE, Right(), problem, at_most(most))[NAME]

    assert found.verdict is Verdict.VERIFIED
    assert found.low <= found.estimate <= found.high == most


def test_one_step_beyond_the_bound_refutes_it():
    """A single path in 256 that takes four more iterations is a counterexample."""
    found = judged(MEASURE, Climbing(more=4), AFFINE)[NAME]

    assert found.verdict is Verdict.REFUTED
    assert str(found.reason).startswith("6 iterations in a step")


def test_growth_below_the_bound_is_refuted():
    """Iterations that grow by 0.3 in each decade of 1/eps stay below five on the grid and have no bound."""
    found = judged(MEASURE, Climbing(slope=0.3), AFFINE)[NAME]

    assert found.high <= 5.0
    assert found.verdict is Verdict.REFUTED
    assert "more iterations for eps = 1e-08" in str(found.reason)


def test_claims_that_are_too_low_unknown_or_not_made():
    """One iteration is too few for Newton, other words and numbers decide nothing."""
    assert judged(MEASURE, Right(), AFFINE, at_most(1))[NAME].verdict is Verdict.REFUTED
    for value in ("few", 5.0):
        unknown = Claim(measure="effort", value=value, source="test")
        assert judged(MEASURE, Right(), AFFINE, unknown)[NAME].verdict is Verdict.INCONCLUSIVE


def test_means_are_shown_for_every_eps():
    """Two values of eps a decade from 1e-8 to 10; a linear problem takes two iterations for each of them."""
    rows = whole(MEASURE, Right(), AFFINE).levels

    assert [row.details["eps"] for row in rows[:19]] == pytest.approx([10.0 ** (-8 + 0.5 * k) for k in range(19)])
    assert {row.details["eps"] for row in rows[19:]} == set(RUNS)
    assert {row.estimate for row in rows} == {2.0}


def test_a_scheme_that_reports_no_iterations_has_not_been_tested():
    """Its claim is in error: it is neither verified nor put aside as not applicable."""
    assert MEASURE.refuses(Explicit(), AFFINE) == ""
    (found,) = whole(MEASURE, Explicit(), AFFINE).findings

    assert found.verdict is Verdict.ERROR
    assert found.claim is not None
    assert str(found.reason) == "its steps report no iterations, so that the claim cannot be tested"


def test_a_bound_in_a_part_of_the_steps():
    """One step in 256 that takes six of them: none in every one of them, and none in half a per cent of them."""
    scheme = Climbing(more=4)
    verdicts = [judged(MEASURE, scheme, AFFINE, claim)[NAME].verdict for claim in (at_most(5), often(5, 90))]

    assert verdicts == [Verdict.REFUTED, Verdict.VERIFIED]
    assert judged(MEASURE, scheme, AFFINE, often(1, 90))[NAME].verdict is Verdict.REFUTED
    close = judged(MEASURE, scheme, AFFINE, often(5, 99.5))[NAME]
    assert close.verdict is Verdict.INCONCLUSIVE
    assert "paths do not decide" in str(close.reason)


class Late(Right):
    """From the ninth step on, each one that is longer than a five hundredth of the horizon takes 40 iterations."""

    def prepare(self, problem, h):
        """Return the step."""
        step, late = super().prepare(problem, h), h > problem.horizon / 500

        def stepper(state, t, noise):
            result = step(state, t, noise)
            taken = result.costs["newton_iterations"] + 38 * (late and t > 8.5 * h)
            return result._replace(costs={"newton_iterations": taken})

        return stepper


def test_iterations_are_looked_at_along_the_run_and_at_its_own_step_sizes():
    """What the first eight steps and the shortest ones do not show is seen."""
    for claim in (at_most(5), often(5, 90)):
        found = judged(MEASURE, Late(), AFFINE, claim)[NAME]
        assert found.verdict is Verdict.REFUTED
        assert found.high == 40.0


def test_coarse_steps_without_root_do_not_count():
    """Where the longest steps have no root the others decide, and where no size has roots nothing does."""
    iterations = unpacked(PROBED, Iterations, probed(MEASURE, Right(), AFFINE))
    runs = unpacked(ALONG, RunIterations, probed(MEASURE, Right(), AFFINE))
    coarse, everywhere = runs.failed.copy(), np.full_like(runs.failed, 0.5)
    coarse[-1, 0], wild = 0.5, runs.most.copy()
    wild[..., 0] = 40.0

    def verdict(failed, most=runs.most):
        tally = packed(PROBED, iterations).merge(packed(ALONG, runs._replace(failed=failed, most=most)))
        return MEASURE.judge(Evidence(Right(), AFFINE, AFFINE, SETTINGS, tally, Tally())).findings[0].verdict

    assert verdict(coarse, wild) is Verdict.VERIFIED
    assert verdict(0.0 * coarse, wild) is Verdict.REFUTED
    assert verdict(everywhere) is Verdict.INCONCLUSIVE


@pytest.mark.parametrize(("share", "count"), [(0.0, 200), (0.02, 200), (0.2, 50)])
def test_the_bound_of_a_share_is_above_the_binomial_probability(share, count):
    """Chernoff's bound holds for shares that are 0 or 1, the widest there are."""
    below = (
        binom.cdf(round(share * count), count, 0.1) if share < 0.1 else binom.sf(round(share * count) - 1, count, 0.1)
    )

    assert below <= float(chernoff(np.array(share), 0.1, np.array(count))) <= 50.0 * below


def test_what_makes_no_sense_is_refused():
    """Schemes without claim."""
    scheme = UniformlyAccurate()
    unclaimed = not any(claim.measure == "effort" for claim in scheme.promises)
    assert bool(MEASURE.refuses(scheme, AFFINE)) is unclaimed
