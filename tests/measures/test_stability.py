"""The stability measure: claims that are kept, broken and not decided."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from cells import Rule
from facade import (
    EulerMaruyama,
    HalfExplicitEuler,
    LaggedAlgebraicTheta,
    Milstein,
    Stability,
    StochasticTheta,
    circle,
    double_well,
    forced_ou,
    gbm,
    gbm_algebraic,
    harmonic_langevin,
    linear_test,
    ou,
    pendulum,
)
from probe import linear_cells as c
from sdaeverify import SDE, Array, Claim, Increment, MeanSquareStability, Problem, Scheme, Settings, Step
from sdaeverify.measuring import Evidence, Finding, Judgement, Tally, Verdict

SETTINGS = Settings(paths=40, levels=3)
INF = float("inf")
A_STABLE = Claim(measure="stability", value="A-stable", source="test")
CONDITIONAL = Claim(measure="stability", value="conditional", source="test")


def judged(scheme: Scheme, problem: Problem) -> Judgement:
    """Probe and judge a cell."""
    measure, view = Stability(), problem.view(scheme.form)
    assert view is not None
    assert measure.refuses(scheme, problem) == ""
    tally = measure.probe(scheme, view, SETTINGS)
    return measure.judge(Evidence(scheme, problem, view, SETTINGS, tally, Tally()))


def finding(rule: Rule, problem: SDE, claim: Claim) -> Finding:
    """Return the finding on a claim about a step of one formula."""
    return judged(c.Formula(rule, (claim,)), problem).findings[0]


def theta(value: float) -> Rule:
    """Return the theta method for linear drifts."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        A = problem.drift(0.0, np.eye(len(x)))
        known = c.euler(problem, x, h, noise) - value * h * A @ x
        return np.linalg.solve(np.eye(len(x)) - value * h * A, known)

    return rule


def test_an_a_stable_scheme_is_verified() -> None:
    """The trapezoidal rule, on a scalar equation, on a stiffer one and on a system, without a boundary."""
    system = c.linear([[-1.0, 30.0], [-30.0, -1.0]], [0.5 * np.eye(2), [[0.0, 0.6], [0.6, 0.0]]])
    for problem in (linear_test(), linear_test(-10.0, 2.0), system):
        (found,) = judged(StochasticTheta(), problem).findings
        assert found.verdict is Verdict.VERIFIED
        assert found.estimate == INF
        assert found.details["windows"] == "all h"
        assert found.tier == 2
        assert str(found.method) == "spectral radius (T2)"


@pytest.mark.parametrize(("value", "boundary"), [(0.499, 80.0), (0.49, 8.0), (0.0, 0.16)])
def test_a_scheme_that_is_not_a_stable_is_refuted_with_its_boundary(value: float, boundary: float) -> None:
    """Theta of .499 loses stability at h = 80 on a = -10, b = 2, far beyond any step size of a run."""
    found = finding(theta(value), linear_test(-10.0, 2.0), A_STABLE)
    assert found.verdict is Verdict.REFUTED
    assert found.estimate == pytest.approx(boundary, rel=1e-12)
    assert f"stable only for h < {boundary:g}" in str(found.reason)


def test_the_same_schemes_are_conditionally_stable() -> None:
    """Below their boundaries, as claimed by the shipped ones."""
    for scheme, boundary in ((EulerMaruyama(), 0.75), (Milstein(), 2.0 / 3.0)):
        (found,) = judged(scheme, linear_test()).findings
        assert found.verdict is Verdict.VERIFIED
        assert found.claim is not None
        assert found.claim.value.text == "conditional"
        assert found.estimate == pytest.approx(boundary, rel=1e-12)
    assert finding(theta(0.499), linear_test(-10.0, 2.0), CONDITIONAL).verdict is Verdict.VERIFIED


def test_a_scheme_that_is_unstable_for_small_steps_is_refuted() -> None:
    """Twice the noise, which makes second moments grow: neither claim is kept."""

    def noisy(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return c.euler(problem, x, h, noise._replace(dW=2.5 * noise.dW))

    for claim in (A_STABLE, CONDITIONAL):
        found = finding(noisy, linear_test(), claim)
        assert found.verdict is Verdict.REFUTED
        assert found.estimate == 0.0
        assert "unstable for small h" in str(found.reason)


def test_windows_that_are_no_interval_are_all_reported() -> None:
    """And the first one ends A-stability."""
    found = finding(c.two_windows, linear_test(), A_STABLE)
    assert found.verdict is Verdict.REFUTED
    assert found.details["windows"] == "h < 0.5; 2 < h < 3"
    assert found.estimate == pytest.approx(0.5, rel=1e-12)


def test_nothing_is_said_on_problems_that_are_not_stable_themselves() -> None:
    """A-stability promises nothing there; additive noise does not make a problem unstable."""
    found = finding(theta(0.5), gbm(), A_STABLE)
    assert found.verdict is Verdict.OUT_OF_SCOPE
    assert "the exact solution is not stable" in str(found.reason)
    assert finding(theta(0.5), ou(), A_STABLE).verdict is Verdict.VERIFIED
    assert finding(theta(0.5), ou(-1.0), A_STABLE).verdict is Verdict.OUT_OF_SCOPE


def test_a_truth_that_contradicts_the_coefficients_is_noticed() -> None:
    """The verdict would otherwise rest on either."""
    problem = linear_test()
    wrong = replace(problem, truths=(MeanSquareStability(stable=False, source="wrong"),))
    found = finding(theta(0.5), wrong, A_STABLE)
    assert found.verdict is Verdict.INCONCLUSIVE
    assert "contradicts the declared stability" in str(found.reason)


def test_a_curved_manifold_leaves_no_direction_out() -> None:
    """The centre of a circle has no nearest point on it; the second moment on the circle is constant."""
    found = finding(c.euler, circle(), CONDITIONAL)
    assert found.verdict is Verdict.INCONCLUSIVE
    assert "only marginally stable" in str(found.reason)


def test_a_problem_on_the_boundary_of_stability_decides_nothing() -> None:
    """With 2a + b^2 = 0 the second moment is constant."""
    found = finding(theta(0.5), c.linear(-0.5, [1.0]), A_STABLE)
    assert found.verdict is Verdict.INCONCLUSIVE
    assert "only marginally stable" in str(found.reason)


def turned(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Turn the plane, whatever the problem: rho = 1."""
    return np.stack([np.cos(h) * x[0] - np.sin(h) * x[1], np.sin(h) * x[0] + np.cos(h) * x[1]])


@pytest.mark.parametrize(
    ("rule", "reason"),
    [
        (c.tamed, "not linear in the state"),
        (c.implicit_in_noise, "second moment infinite"),
        (turned, "not distinguishable from 1 at"),
    ],
)
def test_what_cannot_be_decided_is_inconclusive_with_a_reason(rule: Rule, reason: str) -> None:
    """Steps that are not linear, poles in the noise, and radii of 1, whichever of the two is claimed."""
    problem = c.linear(-2.0 * np.eye(2), [np.eye(2)])
    tally = Stability().probe(c.Formula(rule, (A_STABLE,)), problem, SETTINGS)
    for claim in (A_STABLE, CONDITIONAL):
        evidence = Evidence(c.Formula(rule, (claim,)), problem, problem, SETTINGS, tally, Tally())
        (found,) = Stability().judge(evidence).findings
        assert found.verdict is Verdict.INCONCLUSIVE
        assert reason in str(found.reason)


def test_a_step_without_root_is_inconclusive() -> None:
    """Some step sizes have no step at all."""

    class Rootless(c.Formula):
        """Fail beyond h = 5."""

        def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> c.Step:
            step = super().step(problem, state, t, h, noise)
            return step._replace(failed=np.full(state.shape[1], h > 5.0))

    (found,) = judged(Rootless(theta(1.0), (A_STABLE,)), linear_test()).findings
    assert found.verdict is Verdict.INCONCLUSIVE
    assert "no root at" in str(found.reason)
    assert 4.0 < found.estimate < 5.0


def test_claims_that_are_not_known_or_not_made_are_not_judged() -> None:
    """An order of stability means nothing; without a claim, the largest stable step of the run is told."""
    unknown = finding(theta(0.5), linear_test(), replace(A_STABLE, value="L-stable"))
    assert unknown.verdict is Verdict.INCONCLUSIVE
    assert "'L-stable'" in str(unknown.reason)
    for rate, most in ((-2.0, 1 / 8), (-22.0, 1 / 16), (-200.0, 0.0)):
        (unclaimed,) = judged(c.Formula(c.euler), linear_test(rate, 0.5)).findings
        assert unclaimed.verdict is Verdict.OUT_OF_SCOPE
        assert unclaimed.estimate == most
        assert unclaimed.details["windows"] == (f"h <= {most} in the run" if most else "none in the run")


def test_a_claim_is_not_judged_by_the_step_sizes_of_the_run() -> None:
    """Evidence that was made without the claim verifies nothing, though all these step sizes are stable."""
    rule, problem = theta(0.0), linear_test()
    tally = Stability().probe(c.Formula(rule), problem, SETTINGS)
    for claim in (A_STABLE, CONDITIONAL):
        evidence = Evidence(c.Formula(rule, (claim,)), problem, problem, SETTINGS, tally, Tally())
        (found,) = Stability().judge(evidence).findings
        assert found.verdict is Verdict.INCONCLUSIVE
        assert "only the step sizes of the run" in str(found.reason)


@dataclass(frozen=True)
class NeverSolved(LaggedAlgebraicTheta):
    """A step that keeps the y of the start, which `enter` makes consistent."""

    name: ClassVar[str] = "never-solved"
    claims: ClassVar[tuple[Claim, ...]] = (A_STABLE,)

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Increment) -> Step:
        """Make the step, and take y back."""
        made = super().step(problem, state, t, h, noise)
        return made._replace(state=made.state._replace(y=state.y))


@pytest.mark.long
def test_steps_that_a_run_does_not_make_decide_nothing() -> None:
    """The memory of a run is looked at where evidence is made; the same step with its y solved for is measured."""
    for scheme, unlike in ((NeverSolved(), True), (LaggedAlgebraicTheta(), False)):
        (found,) = judged(scheme, gbm_algebraic()).findings
        assert ("steps of a run differ" in str(found.reason)) is unlike
        assert found.verdict is (Verdict.INCONCLUSIVE if unlike else Verdict.VERIFIED)


def test_levels_are_the_spectral_radii_at_the_step_sizes_of_the_run() -> None:
    """With certified widths."""
    rows = judged(EulerMaruyama(), linear_test()).levels
    assert [row.h for row in rows] == [1 / 8, 1 / 16, 1 / 32]
    assert [row.estimate for row in rows] == pytest.approx([(1 - 2 * r.h) ** 2 + r.h for r in rows], rel=1e-13)
    assert all(row.details["certified_width"] == pytest.approx(1e-12, rel=1e-3) for row in rows)
    assert all(row.level is None for row in rows)


def raising(t: float, x: Array) -> Array:
    if np.abs(x).max() > 50.0:
        raise ValueError("too far out")
    return -x


@pytest.mark.parametrize(
    ("scheme", "problem", "reason"),
    [
        (EulerMaruyama(), double_well(), "drift is not linear"),
        (EulerMaruyama(), forced_ou(), "depends on time"),
        (HalfExplicitEuler(), pendulum(), "not"),
        (
            EulerMaruyama(),
            SDE(
                drift=raising,
                diffusion=lambda t, x: x[None],
                start=[1.0],
                noise_dim=1,
                horizon=1.0,
                source="test",
            ),
            "too far out",
        ),
    ],
    ids=["curved", "forced", "constrained", "raising"],
)
def test_problems_that_are_not_linear_are_refused(scheme: Scheme, problem: Problem, reason: str) -> None:
    """With a reason, whatever their coefficients do far out."""
    assert reason in Stability().refuses(scheme, problem)


def test_missing_evidence_is_inconclusive() -> None:
    """A cell that was not probed has no verdict."""
    problem = linear_test()
    for scheme, verdict in (
        (EulerMaruyama(), Verdict.INCONCLUSIVE),
        (c.Formula(c.euler), Verdict.OUT_OF_SCOPE),
    ):
        evidence = Evidence(scheme, problem, problem, SETTINGS, Tally(), Tally())
        (found,) = Stability().judge(evidence).findings
        assert found.verdict is verdict


@pytest.mark.sweep
@pytest.mark.parametrize("claims", [(), (CONDITIONAL,)])
def test_a_scheme_with_a_reversible_memory_is_unstable_at_every_step_size(claims: tuple[Claim, ...]) -> None:
    """The companion of the reversible Heun method grows: its cell comes back, within bounds that its memory sets."""
    (found,) = judged(c.ReversibleHeun(claims), harmonic_langevin()).findings
    assert found.details["windows"] == ("none" if claims else "none in the run")
    assert found.verdict is (Verdict.REFUTED if claims else Verdict.OUT_OF_SCOPE)


def test_dear_second_moments_are_measured_for_a_claim_alone() -> None:
    """Thirty components have a matrix of 465 rows: not one of the small ones that every cell is given."""
    problem = c.linear(-np.eye(30), [0.1 * np.eye(30)], np.ones(30))
    for claims, reason in (((), "their matrix with 465 rows is costly"), ((CONDITIONAL,), "")):
        assert Stability().refuses(c.Formula(c.euler, claims), problem).endswith(reason)


def test_memories_whose_matrices_would_fill_the_computer_are_refused() -> None:
    """Three hundred components and a hundred noises: 9 x 10^6 entries at the least."""
    problem = SDE(
        drift=lambda t, x: -x,
        diffusion=lambda t, x: np.ones((300, 100, 1)),
        start=np.ones(300),
        noise_dim=100,
        horizon=1.0,
        source="test",
    )
    assert "too many for matrices" in Stability().refuses(c.Formula(c.euler, (CONDITIONAL,)), problem)


def test_a_state_without_a_component_of_the_problem_is_refused() -> None:
    """Its parts are called x where the problem has q and p: it was a KeyError."""
    assert Stability().refuses(c.AdamsBashforth(), harmonic_langevin()).endswith("has no q, p")
