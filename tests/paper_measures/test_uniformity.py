"""The uniformity measure: claims that are kept and broken, and figures that are known."""

import numpy as np
import pytest

import sdaeverify
from facade import (
    INVARIANT,
    ConstrainedEuler,
    EulerMaruyama,
    UniformErrors,
    Uniformity,
    affine_constraint,
    exponential_strip,
    ou,
    penalised_sphere,
)
from paper_measures.stiff_cells import AFFINE, SETTINGS, Right, judged, whole
from sdaeverify import Claim, Increment, Moment
from sdaeverify.measuring import Evidence, Tally, Verdict, packed
from sdaeverify.probing import invariant_observables

pytestmark = pytest.mark.long

MEASURE = Uniformity()


def test_weak_order_one_and_strong_order_one_half_on_the_affine_problem():
    """The suprema over eps behave like h and like sqrt(h), as the closed recursions do."""
    found = judged(MEASURE, Right(), AFFINE)

    assert {name: finding.verdict for name, finding in found.items()} == dict.fromkeys(
        ("weak", "strong"), Verdict.VERIFIED
    )
    assert found["weak"].estimate == pytest.approx(1.0, abs=0.06)
    # With two eps a decade the supremum moves along in steps, over which its slope is off by as much as this.
    assert found["strong"].estimate == pytest.approx(0.5, abs=0.03)
    assert {finding.tier for finding in found.values()} == {2}


def test_suprema_are_those_of_the_exact_moments():
    """The supremum shown for E x_1 x_1 is the largest error over the grid that the problem's own truths have."""
    rows = [row for row in whole(MEASURE, Right(), AFFINE).levels if row.quantity == "weak"]
    row = next(row for row in rows if row.details["functional"] == "E x_1 x_1" and row.h == 0.5 / 16)

    errors = [exact_error(eps) for eps in 10.0 ** np.linspace(-8, 1, 19)]

    assert row.estimate == pytest.approx(max(errors), rel=1e-6)
    assert row.details["worst_eps"] == pytest.approx(10.0 ** np.linspace(-8, 1, 19)[int(np.argmax(errors))])


def exact_error(eps):
    """Return |E x_1^2 - truth| after 16 steps by the recursion of a linear step."""
    problem = affine_constraint(eps)
    truth = next(each for each in problem.truths if isinstance(each, Moment) and each.observable == "x_1^2")
    h, step = 0.5 / 16, Right().prepare(problem, 0.5 / 16)
    mean, covariance = problem.initial(1)[:, 0], np.zeros((2, 2))
    for _ in range(16):
        corners = mean[:, None] + np.concatenate([np.zeros((2, 1)), np.eye(2)], axis=1)
        at = step(corners, 0.0, Increment(np.zeros((2, 3)), None)).state
        M = at[:, 1:] - at[:, :1]
        pushed = (
            step(np.repeat(mean[:, None], 2, axis=1), 0.0, Increment(np.sqrt(h) * np.eye(2), None)).state - at[:, :1]
        )
        mean, covariance = at[:, 0], M @ covariance @ M.T + pushed @ pushed.T
    return abs(mean[0] ** 2 + covariance[0, 0] - truth.value(0.5))


def test_claims_that_are_too_high_unknown_or_not_made():
    """Strong order one is refuted, words decide nothing, and without a claim the order is shown."""
    strong = Claim(measure="uniformity", quantities=("strong",), value=1.0, source="test")
    found = judged(MEASURE, Right(), AFFINE, strong)
    assert found["strong"].verdict is Verdict.REFUTED
    assert found["weak"].verdict is Verdict.OUT_OF_SCOPE

    words = judged(MEASURE, Right(), AFFINE, Claim(measure="uniformity", value="always", source="test"))
    assert {finding.verdict for finding in words.values()} == {Verdict.INCONCLUSIVE}


def test_what_makes_no_sense_is_refused():
    """Equations without eps, schemes without claim, and atoms where errors have to be sampled on one path."""
    assert "no stiffness parameter" in MEASURE.refuses(EulerMaruyama(), ou())
    assert "no stiffness parameter" in MEASURE.refuses(EulerMaruyama(), AFFINE)
    assert "no claim about uniformity" in MEASURE.refuses(ConstrainedEuler(), AFFINE)
    assert "three-point increments are not Brownian" in MEASURE.refuses(
        Right(xi="three-point"), penalised_sphere(d=3)
    )
    assert MEASURE.refuses(Right(), penalised_sphere(d=3)) == ""


def test_an_eps_that_no_quantity_is_known_for_is_named_and_verifies_nothing():
    """As long as one quantity is known for every eps, the others may leave some out; the reason says which."""
    h, eps = 0.05 * 0.5 ** np.arange(4), 10.0 ** np.arange(-8.0, 2.0)
    problem = exponential_strip()
    count = len(invariant_observables(problem))
    error = np.broadcast_to(np.minimum(h, eps[:, None])[..., None], (len(eps), len(h), count))
    blurred = np.where(eps == 10.0, 1.0, 0.0)[:, None, None] * np.ones_like(error)
    one = np.where(np.arange(count) == 0, 0.0, blurred)

    def found(floor):
        record = UniformErrors(h, eps, error, floor, np.ones((len(eps), count)))
        given = Evidence(Right(), problem, problem, SETTINGS, packed(INVARIANT, record), Tally())
        (finding,) = MEASURE.judge(given).findings
        return finding

    assert found(0.0 * error).verdict is Verdict.VERIFIED
    assert "not resolved" not in str(found(0.0 * error).reason)
    assert found(one).verdict is Verdict.VERIFIED
    assert "|n|^2 is below the noise for eps = 10" in str(found(one).reason)
    assert found(blurred).verdict is Verdict.INCONCLUSIVE


def test_few_paths_leave_it_open():
    """With too few paths for an interval, nothing is said of errors along them, and one step is told all the same."""
    rows = sdaeverify.verify("uniform-expansion", "tube-torus", "uniformity", paths=64).verdicts
    told = dict(zip(rows.quantity, rows.verdict, strict=True))

    assert told == {"weak": "inconclusive", "strong": "inconclusive", "one step": "verified"}
