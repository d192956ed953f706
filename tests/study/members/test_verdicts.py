"""Claims put to random members: right schemes are verified, wrong ones refuted, with the features that are needed."""

import importlib
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    ConstrainedEuler,
    Drift,
    HalfExplicitEuler,
    MemberClass,
    SemiImplicitProjectionEuler,
    StochasticTheta,
    Strong,
    Weak,
    WrongLag,
    class_cells,
    member_classes,
    member_rows,
)
from sdaeverify import Claim, ConstrainedLangevin, DelaySDAE, HolonomicSDAE, HolonomicState, Step
from sdaeverify.measuring import Finding, Measure, Reason, Verdict

SEED = 11
MEASURES = (Strong(), Weak(), Drift())
(MECHANICS,), (KEPT, _), (DELAYS,) = (
    [MemberClass(kind) for kind in form.generic_classes()] for form in (HolonomicSDAE, ConstrainedLangevin, DelaySDAE)
)


def verdicts(scheme, kind, measures=MEASURES):
    """Return the rows on a class, by measure."""
    return {row.measure: row for row in member_rows(scheme, kind, measures, SEED)}


@dataclass(frozen=True)
class Wrong(HalfExplicitEuler):
    """The half-explicit scheme without truncation; projections are as before, its kick is not."""

    truncation: str | float = "none"

    name: ClassVar[str] = "wrong-half-explicit"

    def kick(self, problem, r, v, t, h, dW):
        """Return the change of v before its projection."""
        return problem.inverse_mass(h * problem.force(t, r, v) + problem.diffused(t, r, v, dW))

    def step(self, problem, state, t, h, noise):
        """Make one step: where the right one goes, then the velocity by another kick."""
        right = HalfExplicitEuler(truncation="none").step(problem, state, t, h, noise)
        r, v, mu = state
        old, new = problem.linearised(r), problem.linearised(right.state.r)
        x = v + self.kick(problem, r, v, t, h, noise.dW)
        lam = -new.gram(old).solve(new.times(x))
        return Step(HolonomicState(right.state.r, x + problem.push(old, lam), mu + lam), right.failed)


class Massless(Wrong):
    """The mass matrix is forgotten in force and noise."""

    name: ClassVar[str] = "massless"

    def kick(self, problem, r, v, t, h, dW):
        """Return h a + B dW."""
        return h * problem.force(t, r, v) + problem.diffused(t, r, v, dW)


class Diagonal(Wrong):
    """The impulse of each constraint is found as if it were alone."""

    name: ClassVar[str] = "diagonal"

    def step(self, problem, state, t, h, noise):
        """Make one step with the diagonal of the Gram matrix."""
        right = super().step(problem, state, t, h, noise)
        r, v, mu = state
        x = v + self.kick(problem, r, v, t, h, noise.dW)
        old, new = problem.linearised(r), problem.linearised(right.state.r)
        pushed = [problem.inverse_mass(np.broadcast_to(row, r.shape)) for row in problem.dg(r)]
        gram = np.array([new.times(each)[place] for place, each in enumerate(pushed)])
        lam = -new.times(x) / gram
        return Step(HolonomicState(right.state.r, x + problem.push(old, lam), mu + lam), right.failed)


class FlatLimit(ConstrainedEuler):
    """Projects the increment onto the tangent plane, not the point onto the manifold."""

    name: ClassVar[str] = "flat-limit"

    def step(self, problem, state, t, h, noise):
        """Make one step along the tangent plane."""
        at = problem.near(state)
        y = problem.strength * noise.dW + h * problem.drift(state)
        return Step(state + y - at.normal(y))


@pytest.mark.long
@pytest.mark.parametrize(
    ("scheme", "kind"),
    [
        (HalfExplicitEuler(truncation="none"), MECHANICS),
        (Wrong(), MECHANICS),
        (SemiImplicitProjectionEuler(), MECHANICS),
        (ConstrainedEuler(), KEPT),
    ],
    ids=lambda each: getattr(each, "name", ""),
)
def test_right_schemes_are_verified(scheme, kind):
    """Orders and constraints of right schemes are verified on all members."""
    found = verdicts(scheme, kind)
    assert {*found} == {"strong", "weak", "drift"}
    assert {row.verdict for row in found.values()} == {Verdict.VERIFIED}


@pytest.mark.long
def test_a_forgotten_mass_is_refuted_and_named():
    """A scheme that forgets M^-1 is refuted, and the reason names the mass matrix."""
    row = verdicts(Massless(), MECHANICS, [Weak()])["weak"]
    assert row.verdict is Verdict.REFUTED
    assert row.why.endswith("only with a mass matrix that is not the identity")
    assert row.order < 0.5


def test_a_diagonal_gram_matrix_is_refuted_and_named():
    """A scheme with the diagonal of the Gram matrix alone is refuted where there are several constraints."""
    row = verdicts(Diagonal(), MECHANICS, [Drift()])["drift"]
    assert row.verdict is Verdict.REFUTED
    assert row.why.endswith("only with several constraints")


class OneUpdate(ConstrainedEuler):
    """Onto the manifold by one update of Newton's method."""

    name: ClassVar[str] = "one-update"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        y = state + problem.strength * noise.dW + h * problem.drift(state)
        old, new = problem.near(state).J, problem.near(y)
        return Step(y - old.transposed(new.J.gram(old).solve(new.zeta)))


class SmoothUpdate(SemiImplicitProjectionEuler):
    """The position onto the constraint by one update of Newton's method, near round-off after short steps."""

    name: ClassVar[str] = "smooth-update"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        right = super().step(problem, state, t, h, noise)
        y = state.r + h * state.v
        J = problem.linearised(y)
        r = y - problem.push(J, J.gram(J).solve(problem.constraint(y)))
        return Step(right.state._replace(r=r, v=problem.tangent(problem.linearised(r), right.state.v)[0]))


def test_an_iteration_that_ends_early_is_not_verified():
    """One update of Newton's method is refuted where positions are noisy, and left open where velocities are."""
    assert verdicts(OneUpdate(), KEPT, [Drift()])["drift"].verdict is Verdict.REFUTED
    row = verdicts(SmoothUpdate(), MECHANICS, [Drift()])["drift"]
    assert row.verdict is Verdict.INCONCLUSIVE
    assert "too few iterations" in row.premise


def test_a_tangent_step_is_refuted_where_constraints_are_curved():
    """A scheme that stays in the tangent plane leaves the manifold where it is curved, and nowhere else."""
    row = verdicts(FlatLimit(), KEPT, [Drift()])["drift"]
    assert row.verdict is Verdict.REFUTED
    assert row.why.endswith("only with curved constraints")


def test_a_forgotten_delay_is_refuted_and_named():
    """A scheme that takes lagged values of now is refuted, and the reason names the delay."""
    row = verdicts(WrongLag(reading="present"), DELAYS, [Drift()])["drift"]
    assert row.verdict is Verdict.REFUTED
    assert row.why.endswith("only with algebraic components and a delay")


class TooStrong(StochasticTheta):
    """Euler's step with a tenth too much noise."""

    name: ClassVar[str] = "too-strong"

    def step(self, problem, state, t, h, noise):
        """Make one step with other noise."""
        return super().step(problem, state, t, h, noise._replace(dW=1.1 * noise.dW))


@dataclass(frozen=True)
class PartlyWrong(StochasticTheta):
    """The theta method with other noise at late times or for large increments, or with a wrong lag."""

    part: str = "late"

    name: ClassVar[str] = "partly-wrong"
    form: ClassVar = (DelaySDAE,)

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        if self.part == "late" and t > 0.9 * problem.horizon:
            noise = noise._replace(dW=0.8 * noise.dW)
        elif self.part == "large":
            noise = noise._replace(dW=np.clip(noise.dW, -2.5 * np.sqrt(h), 2.5 * np.sqrt(h)))
        elif self.part == "lag" and 0.5 * problem.delay < t < 0.8 * problem.delay:
            noise = noise._replace(lagged=0.0 * noise.lagged + problem.past(0.0))
        return super().step(problem, state, t, h, noise)


@pytest.mark.parametrize("part", ["late", "large", "lag"])
def test_steps_on_delayed_members_follow_the_equation_everywhere(part):
    """A step that is wrong at some times, or for some noise only, is refuted on members with a delay."""
    assert verdicts(PartlyWrong(part=part), DELAYS, [Strong()])["strong"].verdict is Verdict.REFUTED


class FewMotions(StochasticTheta):
    """The theta method that knows two Brownian motions."""

    name: ClassVar[str] = "few-motions"
    form: ClassVar = (DelaySDAE,)

    def step(self, problem, state, t, h, noise):
        """Make one step without further motions."""
        known = np.arange(len(noise.dW))[:, None] < 2
        return super().step(problem, state, t, h, noise._replace(dW=np.where(known, noise.dW, 0.0)))


class TwoRows(ConstrainedEuler):
    """A step with a tenth less noise if there are more than two constraints."""

    name: ClassVar[str] = "two-rows"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        share = 0.9 if len(problem.constraint(state)) > 2 else 1.0
        return super().step(problem, state, t, h, noise._replace(dW=share * noise.dW))


class FourPositions(Wrong):
    """The half-explicit scheme that moves four components of the velocity."""

    name: ClassVar[str] = "four-positions"

    def kick(self, problem, r, v, t, h, dW):
        """Return the change of the first four components."""
        return np.where(np.arange(len(r))[:, None] < 4, super().kick(problem, r, v, t, h, dW), 0.0)


@pytest.mark.parametrize(
    ("scheme", "kind"), [(FewMotions(), DELAYS), (TwoRows(), KEPT), (FourPositions(), MECHANICS)]
)
def test_a_class_has_more_components_than_its_members(scheme, kind):
    """A step that is right for the sizes of the members only is refuted by trivial equations of larger ones."""
    row = verdicts(scheme, kind, [Strong()])["strong"]
    assert row.verdict is Verdict.REFUTED
    assert "not exact on" in row.premise


@pytest.mark.long
def test_a_defect_on_every_member_needs_no_feature():
    """Where a claim is refuted with all features left out, delay and algebraic components too, none is named."""
    row = verdicts(TooStrong(theta=0.0), DELAYS, [Strong()])["strong"]
    assert row.verdict is Verdict.REFUTED
    assert "only with" not in row.why


class Noting(Measure):
    """A measure that refutes the strong order on the members it is given the indices of."""

    name = "strong"

    def __init__(self, *refuting):
        self.refuting, self.seen = refuting, []

    def judge_member(self, scheme, view):
        """Return a finding on the first claim."""
        if view not in self.seen:
            self.seen.append(view)
        refuted = self.seen.index(view) in self.refuting
        verdict = Verdict.REFUTED if refuted else Verdict.VERIFIED
        claim = next(each for each in scheme.promises if each.measure == self.name)
        return [Finding(quantity="state", verdict=verdict, reason=Reason("as it was noted"), claim=claim)]


def test_a_lone_refuting_member_does_not_refute():
    """One member of three that refutes leaves the claim open; a second one of a fresh draw refutes it."""
    scheme = HalfExplicitEuler(truncation="none")
    once, twice = Noting(1), Noting(1, 2)
    (row,) = member_rows(scheme, MECHANICS, [once], SEED)
    assert (row.verdict, len(once.seen)) == (Verdict.INCONCLUSIVE, 3)
    assert "1 of 3" in row.premise
    (row,) = member_rows(scheme, MECHANICS, [twice], SEED)
    assert row.verdict is Verdict.REFUTED


def test_a_measure_without_an_answer_is_left_out():
    """A measure that has no `judge_member` gives no row and no cell, though it is claimed."""

    class Silent(Measure):
        name = "strong"

    scheme = HalfExplicitEuler(truncation="none")
    assert [*member_rows(scheme, MECHANICS, [Silent()], SEED)] == []
    assert any(claim.measure == "strong" for claim in member_classes(scheme, SEED)[MECHANICS])
    cell = type("Cell", (), {"scheme": scheme, "measure": Silent()})()
    assert [*class_cells([cell], SEED)] == []


def test_a_claim_with_a_trait_is_put_to_members_with_it():
    """Strong order 1 without Milstein's term is put to members whose noise does not depend on velocities."""
    found = member_classes(HalfExplicitEuler(truncation="none"), SEED)
    narrowed = {kind.name: [claim.value.least for claim in own] for kind, own in found.items() if kind != MECHANICS}
    assert narrowed == {"HolonomicSDAE without velocity-noise": [1.0]}


class MeanTheta(StochasticTheta):
    """It claims weak order 1 of the mean of x alone."""

    claims: ClassVar = (Claim(measure="weak", value=1.0, quantities=("x",), source="test"),)


@pytest.mark.long
def test_a_claim_about_a_named_mean_is_not_put_to_members_and_the_row_says_so():
    """There was no row at all, and the gate had a cell for it that nothing answered."""
    kind = next(iter(member_classes(MeanTheta(), SEED)))
    row = verdicts(MeanTheta(), kind, [Weak()])["weak"]

    assert row.verdict is Verdict.INCONCLUSIVE
    assert "the claim is about the mean of x only" in row.why
    assert verdicts(StochasticTheta(), DELAYS, [Weak()])["weak"].verdict is Verdict.VERIFIED


class Marked:
    """The steps of another scheme, with one field that marks every path."""

    mark = ""

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        made = super().step(problem, state, t, h, noise)
        return made._replace(**{self.mark: np.ones(noise.dW.shape[1], dtype=bool)})


class TruncatedTheta(Marked, StochasticTheta):
    """Each step is marked as truncated."""

    mark = "truncated"


class FailedTheta(Marked, StochasticTheta):
    """Each path is marked as failed."""

    mark = "failed"


class FailedHalfExplicit(Marked, HalfExplicitEuler):
    """The same of a scheme for mechanics."""

    mark = "failed"


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("scheme", "unmarked", "kind"),
    [
        (TruncatedTheta(), StochasticTheta(), DELAYS),
        (FailedTheta(), StochasticTheta(), DELAYS),
        (FailedHalfExplicit(truncation="none"), HalfExplicitEuler(truncation="none"), MECHANICS),
    ],
)
def test_an_order_is_not_verified_by_steps_that_are_all_truncated_or_fail(scheme, unmarked, kind):
    """They were verified on two of two members, as the same steps without marks are; a wrong one is refuted above."""
    assert verdicts(unmarked, kind, [Strong()])["strong"].verdict is Verdict.VERIFIED
    found = verdicts(scheme, kind, [Strong(), Weak()])

    assert {row.verdict for row in found.values()} == {Verdict.INCONCLUSIVE}
    assert all("no order can be observed" in row.why for row in found.values())


def test_a_form_of_others_brings_its_own_class(monkeypatch):
    """A form with jumps offers a class: Euler's strong order is verified, a wrong jump is refuted and named."""
    source = Path(__file__).parents[2] / "thirdparty" / "jump_diffusion" / "src"
    monkeypatch.syspath_prepend(str(source))
    schemes = importlib.import_module("sdaeverify_jumps.jump_euler")

    for scheme, verdict in (
        (schemes.JumpEuler(), Verdict.VERIFIED),
        (schemes.MarcusJumpEuler(), Verdict.REFUTED),
    ):
        ((kind, _),) = member_classes(scheme, SEED).items()
        assert kind.name == "JumpDiffusion"
        row = verdicts(scheme, kind, [Strong()])["strong"]
        assert row.verdict is verdict
    assert row.why.endswith("only with jumps that depend on the state")
    # Means of jumps have no quadrature: paths are asked alone.
    assert verdicts(scheme, kind, [Weak()])["weak"].verdict is Verdict.INCONCLUSIVE
