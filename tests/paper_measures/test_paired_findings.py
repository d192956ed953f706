"""Orders of suprema over eps from sampled errors: prescribed means, references that blur, steps without root."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.stats import binom

from facade import PAIRED, SHARE, PairedErrors, Uniformity, penalised_sphere, torus
from paper_measures.stiff_cells import Right, replace_claims
from sdaeverify import Claim, Settings, Step
from sdaeverify.measuring import Evidence, Tally, Verdict, packed
from sdaeverify.numerics import GROUPS
from sdaeverify_measures.uniformity.paired_findings import PairedMeans

H = 0.1 * 0.5 ** np.arange(4)
EPS = 10.0 ** np.arange(-8.0, 2.0)
A_GROUP, NOISE, Q = 100, 2e-4, 4
PROBLEM, SETTINGS = penalised_sphere(d=3), Settings(paths=SHARE * GROUPS * A_GROUP)
CLAIM = Claim(measure="uniformity", value=0.5, source="test")


def record(weak, strong=lambda eps, h: h**0.5 + 0.0 * eps, blurred=0.0, noise=NOISE, seed=0):
    """Return the evidence of errors that are functions of eps and h, with noise in the means of groups."""
    rng, grid = np.random.default_rng(seed), (EPS[:, None], H)
    shape = (len(EPS), GROUPS, len(H))
    means = np.broadcast_to(weak(*grid)[:, None, :, None], (*shape, Q)) + noise * rng.standard_normal((*shape, Q))
    squares = np.broadcast_to(strong(*grid)[:, None] ** 2, shape) * (1.0 + 0.01 * rng.standard_normal(shape))
    values = np.broadcast_to(np.array([0.0, 1.0])[:, None], (len(EPS), GROUPS, 2, Q))
    none = np.zeros((len(EPS), GROUPS, len(H) + 1))
    parts = (means, squares, np.full((len(EPS), GROUPS, Q), blurred), values)
    return PairedErrors(*(A_GROUP * part for part in parts), none, none, np.full(GROUPS, A_GROUP), H, EPS)


def judged(given, claim=CLAIM):
    """Return the findings on a record."""
    scheme = replace_claims(Right(), (claim,))
    evidence = Evidence(scheme, PROBLEM, PROBLEM, SETTINGS, packed(PAIRED, given), Tally(), level=SETTINGS.level)
    return {finding.quantity: finding for finding in Uniformity().judge(evidence).findings}


@dataclass(frozen=True)
class Still(Right):
    """It makes no step where eps is above a bound."""

    beyond: float = 0.0

    def prepare(self, problem, h):
        """Return the step."""
        still = lambda state, t, noise: Step(state, np.ones(state.shape[1], dtype=bool))  # noqa: E731
        return still if problem.eps > self.beyond else super().prepare(problem, h)


def first_order(eps, h):
    """Return C min(h, eps): flat at fixed eps < h, of order one as a supremum."""
    return np.minimum(h, eps)


def peak(eps, h):
    """Return an error of order one for every eps and of order zero as a supremum."""
    return 0.1 * np.exp(-(np.log10(eps / h) ** 2) / 8.0)


def test_uniform_orders_are_verified():
    """Weak order one and strong order one half keep a claim of one half, with intervals that contain them."""
    found = judged(record(first_order))

    assert [finding.verdict for finding in found.values()] == [Verdict.VERIFIED, Verdict.VERIFIED]
    assert found["weak"].low <= 1.0 <= found["weak"].high
    assert found["strong"].low <= 0.5 <= found["strong"].high
    assert {finding.tier for finding in found.values()} == {3}


def test_errors_that_are_not_uniform_are_refuted():
    """A peak at eps = h, and a strong error that stays."""
    found = judged(record(peak, strong=lambda eps, h: 0.1 + 0.0 * (eps + h)))

    assert [finding.verdict for finding in found.values()] == [Verdict.REFUTED, Verdict.REFUTED]
    assert all(abs(finding.estimate) < 0.1 for finding in found.values())


def test_steps_that_are_too_coarse_refute_nothing():
    """Half an order at first and order one over the last two halvings is not held against a claim of one."""
    claim = Claim(measure="uniformity", value=1.0, margin=0.1, source="test")
    given = record(lambda eps, h: np.minimum(h, 0.05) + 0.0 * eps, noise=1e-6)

    assert judged(given, claim)["weak"].verdict is Verdict.INCONCLUSIVE


def test_noise_decides_nothing_and_says_what_would():
    """Errors of a few standard errors are inconclusive, with the number of paths that would decide."""
    found = judged(record(first_order, noise=0.02))

    assert found["weak"].verdict is Verdict.INCONCLUSIVE
    assert "paths would decide" in str(found["weak"].reason)


def test_a_reference_that_is_itself_off_decides_nothing():
    """Where twice the reference's step changes it by as much as the largest error, nothing follows."""
    assert judged(record(first_order, blurred=0.1))["weak"].verdict is Verdict.INCONCLUSIVE
    assert judged(record(peak, blurred=0.1))["weak"].verdict is Verdict.INCONCLUSIVE


def rootless(where):
    """Return numbers of failed paths: two in a hundred where told."""
    return np.where(where[:, None, None], 2.0, 0.0) + np.zeros((len(EPS), GROUPS, len(H) + 1))


@pytest.mark.parametrize("where", [EPS > 0.5, EPS < 2e-8, np.isclose(EPS, 1e-4)])
def test_an_eps_without_roots_decides_nothing_and_is_named(where):
    """Two paths in a hundred without root: that eps alone is left out, nothing is verified, and the rest refutes."""
    wrong = record(lambda eps, h: np.where(where[:, None], 1.0, np.minimum(h, eps)))._replace(failed=rootless(where))
    stays = record(peak)._replace(failed=rootless(where))

    found, refuted = judged(wrong)["weak"], judged(stays)["weak"]

    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.p_verified == 1.0
    assert found.estimate == pytest.approx(1.0, abs=0.1)
    named = f"eps = {EPS[where][0]:.3g}" if where.sum() == 1 else f"2 eps from {EPS[where][0]:.3g} to 10"
    assert f"no error is known for {named}" in str(found.reason)
    assert refuted.verdict is Verdict.REFUTED
    assert judged(record(lambda eps, h: np.where(where[:, None], 1.0, h)))["weak"].verdict is Verdict.REFUTED


def test_no_eps_with_roots_decides_nothing():
    """Where every eps is left out, there is no order."""
    nowhere = judged(record(first_order)._replace(failed=rootless(EPS > 0.0)))

    assert {finding.verdict for finding in nowhere.values()} == {Verdict.INCONCLUSIVE}
    assert all(np.isnan(finding.estimate) for finding in nowhere.values())


def test_a_scheme_that_makes_no_step_but_for_the_smallest_eps_is_not_verified():
    """It stands still and says so for eps > 1e-7: its order over the other two eps is no order over all of them."""
    problem, settings = torus(), Settings(paths=800, coarsest=2, levels=5)
    scheme = replace_claims(Still(beyond=1e-7), (CLAIM,))

    tally = Uniformity().probe(scheme, problem, settings)
    findings = Uniformity().judge(Evidence(scheme, problem, problem, settings, tally, Tally(), level=0.05)).findings

    assert {finding.verdict for finding in findings} == {Verdict.INCONCLUSIVE}
    assert all("to 10, where a step has no root on more than 1 % of the paths" in str(f.reason) for f in findings)


def test_a_coarsest_step_without_roots_is_left_out():
    """Where only the longest step fails, the order is that of the others."""
    failed = np.zeros((len(EPS), GROUPS, len(H) + 1))
    failed[..., 0] = 2.0
    given = record(lambda eps, h: np.where(h > 0.06, 0.0, np.minimum(h, eps)))._replace(failed=failed)

    assert judged(given)["weak"].verdict is Verdict.VERIFIED


def test_paths_that_are_lost():
    """More than one in a hundred at the shortest step is an error without bound; a few leave the claim open."""
    lost = np.zeros((len(EPS), GROUPS, len(H) + 1))
    lost[3, :, -1] = 2.0
    many = judged(record(first_order)._replace(lost=lost))["weak"]
    few = judged(record(first_order)._replace(lost=0.1 * lost))["weak"]

    assert (many.verdict, few.verdict) == (Verdict.REFUTED, Verdict.INCONCLUSIVE)
    assert "not finite at h = 0.00625, eps = 1e-05" in str(many.reason)


def test_words_decide_nothing_and_no_claim_is_out_of_scope():
    """Only orders are known, and without a claim the order is shown."""
    words = judged(record(first_order), Claim(measure="uniformity", value="always", source="test"))
    unclaimed = judged(record(first_order), replace(CLAIM, quantities=("strong",)))

    assert {finding.verdict for finding in words.values()} == {Verdict.INCONCLUSIVE}
    assert unclaimed["weak"].verdict is Verdict.OUT_OF_SCOPE
    assert unclaimed["weak"].estimate == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [1e-2, 1e-1])
def test_tests_keep_their_level_at_the_bound(noise):
    """Where the supremum falls exactly as fast as asked for, neither test rejects more often than it may."""
    rng, samples, order = np.random.default_rng(2), 1000, 0.5
    means = H[:, None] ** order * np.array([0.3, 1.0, 1.0])[:, None, None] * np.ones(2)
    errors = noise * rng.standard_normal((samples, GROUPS, *means.shape))
    nothing = np.zeros((GROUPS, 3, 2))
    found = [PairedMeans(means + each, nothing, H, EPS[:3], 1.0, ("a", "b"), EPS[:0]) for each in errors]

    most = binom.ppf(1.0 - 1e-4, samples, 0.05)
    assert sum(sample.falls(order) <= 0.05 for sample in found) <= most
    assert sum(sample.stays(order)[0] <= 0.05 for sample in found) <= most
