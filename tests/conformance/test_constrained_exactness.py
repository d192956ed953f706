"""Exactness with constraints: masses, several constraints, planes, and equations of index 1 without delay."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any, ClassVar

import numpy as np
import pytest

from facade import HalfExplicitEuler, exactness_violation, load_registry
from sdaeverify import (
    Array,
    Claim,
    ConstrainedLangevin,
    DelayState,
    HolonomicSDAE,
    HolonomicState,
    Increment,
    IndexOneSDAE,
    Problem,
    Scheme,
    Step,
    Trivial,
)
from sdaeverify.numerics import apply, solve

FORMS = (HolonomicSDAE, ConstrainedLangevin, IndexOneSDAE)
EVERY = [trivial for form in FORMS for variants in form.trivial_problems() for trivial in variants]
MOTIONS = [trivial for variants in HolonomicSDAE.trivial_problems() for trivial in variants]
STRONG = (Claim(measure="strong", value=0.5, source="made up"),)
# What a velocity is pushed by, from M^{-1} of the problem, the force times h, and the noise.
Push = Callable[[Any, Array, Array], Array]
# Multipliers from the Gram matrix and the defect.
Answer = Callable[[Array, Array], Array]


def right_push(problem: HolonomicSDAE, force: Array, kick: Array) -> Array:
    return problem.inverse_mass(force + kick)


def right_answer(gram: Array, defect: Array) -> Array:
    return solve(gram, defect)


@dataclass(frozen=True)
class Mechanical(Scheme):
    """Half-explicit Euler for affine constraints, written out, with a push and an answer of the constraint."""

    push: Push = right_push
    answer: Answer = right_answer

    name: ClassVar[str] = "planted-mechanics"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = STRONG

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        J = np.broadcast_to(problem.dg(r), (problem.constraints, *r.shape))
        normals = problem.inverse_mass(np.swapaxes(J, 0, 1))
        x = v + self.push(problem, h * problem.force(t, r, v), problem.diffused(t, r, v, noise.dW))
        lam = -self.answer(np.einsum("inp,njp->ijp", J, normals), apply(J, x))
        return Step(HolonomicState(r + h * v, x + apply(normals, lam), mu + lam))


def diagonal(gram: Array, defect: Array) -> Array:
    return defect / np.einsum("iip->ip", gram)


WRONG: dict[str, tuple[Mechanical, str]] = {
    "mass forgotten": (Mechanical(lambda _p, a, w: a + w), "M dv = c dt + S dW, M full with"),
    "mass forgotten in the noise": (
        Mechanical(lambda p, a, w: p.inverse_mass(a) + w),
        "M dv = c dt + S dW, M full with",
    ),
    "mass in the place of its inverse": (
        Mechanical(lambda p, a, w: np.einsum("ij,jp->ip", p.mass if p.mass is not None else np.eye(len(a)), a + w)),
        "M dv = c dt + S dW, M full with",
    ),
    "diagonal of the mass matrix": (
        Mechanical(lambda p, a, w: (a + w) / (np.ones(len(a)) if p.mass is None else np.diag(p.mass))[:, None]),
        "M dv = c dt + S dW, M full with",
    ),
    "Gram matrix cut to its diagonal": (Mechanical(answer=diagonal), "dv = c dt + S dW, two constraints with"),
    "first constraint alone": (
        Mechanical(answer=lambda G, d: solve(G, d) * (np.arange(len(d)) < 1)[:, None]),
        "dv = c dt + S dW, two constraints with",
    ),
}


@pytest.mark.parametrize("mistake", WRONG)
def test_a_mistake_in_mechanics_is_found_on_the_equation_that_names_it(mistake: str) -> None:
    """A mass matrix and a second constraint are added one at a time: the first miss is the missing feature."""
    scheme, equation = WRONG[mistake]
    assert f"not exact on {equation}" in exactness_violation(scheme)


def test_what_moves_an_almost_infinite_mass_is_named() -> None:
    """A mass matrix of which only entries of moderate size are inverted is found by the one that is not."""

    def moderate(problem: HolonomicSDAE, force: Array, kick: Array) -> Array:
        if problem.mass is None:
            return force + kick
        return solve(np.minimum(np.asarray(problem.mass), 10.0)[..., None], force + kick)

    assert "on dv = 0, a mass almost infinite" in exactness_violation(Mechanical(moderate))


def test_a_right_step_written_out_is_exact() -> None:
    """The scheme that mistakes are planted in has none itself."""
    assert exactness_violation(Mechanical()) == ""


def test_one_motion_is_enough_to_see_a_mass() -> None:
    """A problem with one Brownian motion is answered by a variant with one."""
    scheme, equation = WRONG["mass forgotten"]
    assert f"not exact on {equation.removesuffix(' with')}: error" in exactness_violation(scheme, 1)


def test_a_scheme_that_refuses_a_mass_matrix_is_not_refuted() -> None:
    """What a scheme refuses says nothing against it."""

    @dataclass(frozen=True)
    class Unit(Mechanical):
        def refuses(self, problem: HolonomicSDAE) -> str:
            return "" if problem.mass is None else "no mass matrix"

    assert exactness_violation(Unit(lambda _p, a, w: a + w)) == ""


@pytest.mark.parametrize("trivial", EVERY, ids=lambda trivial: trivial.name)
def test_solutions_of_trivial_problems_start_at_the_problem_s_start(trivial: Trivial) -> None:
    """At time 0 the solution is the initial state, in the components that it has."""
    problem = trivial.problem
    given = problem.parts(problem.initial(3))
    for name, part in trivial.solution(0.0, np.zeros((problem.noise_dim, 3))).items():
        np.testing.assert_allclose(part, given[name], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("trivial", MOTIONS, ids=lambda trivial: trivial.name)
def test_trivial_motions_are_solved_by_the_inherent_equation(trivial: Trivial) -> None:
    """The known components move as drift and diffusion of the equation with eliminated multipliers say."""
    problem, equation = trivial.problem, trivial.problem.ito()
    x = np.concatenate(problem.initial(1))
    W, t = np.random.default_rng(3).standard_normal((problem.noise_dim, 1)), 0.2
    moved = problem.parts(problem.state(t * equation.drift(0.0, x) + equation.diffused(0.0, x, W)))
    start = trivial.solution(0.0, 0.0 * W)
    for name, part in trivial.solution(t, W).items():
        np.testing.assert_allclose(part - start[name], moved[name], rtol=0.0, atol=1e-14)


@dataclass(frozen=True)
class Plane(Scheme):
    """Euler's step projected onto the planes, with a factor of its noise; for the limit alone if it says so."""

    when: frozenset[str]
    answer: Answer = right_answer
    factor: float = 1.0

    name: ClassVar[str] = "planted-plane"
    form: ClassVar[type[ConstrainedLangevin]] = ConstrainedLangevin

    @property
    def promises(self) -> tuple[Claim, ...]:
        """One strong order."""
        return (Claim(measure="strong", value=0.5, when=self.when, source="made up"),)

    def step(self, problem: ConstrainedLangevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        J = np.broadcast_to(problem.dg(state), (problem.constraints, *state.shape))
        moved = h * problem.drift(state) + problem.strength * self.factor * noise.dW
        lam = self.answer(np.einsum("idp,jdp->ijp", J, J), apply(J, moved))
        return Step(state + moved - np.einsum("idp,ip->dp", J, lam))


def test_overdamped_dynamics_are_held_to_planes() -> None:
    """Noise of a wrong strength and a Gram matrix without its off-diagonal entries are named; projection is exact."""
    limit = frozenset({"constrained"})

    assert exactness_violation(Plane(limit)) == ""
    assert "on dX = Pi (c dt + sigma dW) on a plane" in exactness_violation(Plane(limit, factor=1.01))
    assert "on dX = Pi (c dt + sigma dW) on two planes" in exactness_violation(Plane(limit, diagonal))


def test_a_claim_for_the_limit_is_not_held_to_positive_stiffness_parameters() -> None:
    """A scheme that ignores eps is exact where it claims to converge, and wrong where it claims it for every eps."""
    assert "on dX = Pi c dt + sigma dW near two planes" in exactness_violation(Plane(frozenset()))


@dataclass(frozen=True)
class Pastless(Scheme):
    """Explicit Euler for x of an equation of index 1, and y at a time between the begin and the end of the step."""

    end: float = 1.0
    crossed: bool = True

    name: ClassVar[str] = "planted-pastless"
    form: ClassVar[type[IndexOneSDAE]] = IndexOneSDAE
    claims: ClassVar[tuple[Claim, ...]] = STRONG

    def step(self, problem: IndexOneSDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert not problem.delay
        (x, y), dW = state, noise.dW
        B = np.broadcast_to(problem.diffusion(t, x, x, y), (len(x), *dW.shape))
        kick = apply(B, dW) if self.crossed else np.einsum("iip,ip->ip", B, dW)
        new = x + h * problem.drift(t, x, x, y) + kick
        return Step(DelayState(new, problem.eliminated(t + self.end * h, new, new)))


@pytest.mark.long
def test_schemes_of_index_one_are_tried_without_delay() -> None:
    """None of their trivial problems has a delay; an early y and a diagonal cut from the noise are found."""
    assert exactness_violation(Pastless()) == ""
    assert "on dx = 0, y = x + s t" in exactness_violation(Pastless(0.5))
    assert "on dx = S dW, y = x + s t" in exactness_violation(Pastless(crossed=False))


def test_every_shipped_scheme_is_exact_on_the_trivial_problems_of_its_forms() -> None:
    """No scheme in use misses one of them."""
    found = {
        scheme.label: exactness_violation(scheme)
        for entry in load_registry().schemes.values()
        for scheme in entry.variants
        if not entry.on_request
    }
    assert {label: text for label, text in found.items() if text} == {}


def test_half_explicit_steps_are_exact_with_any_truncation() -> None:
    """A truncation that cuts coarse steps cuts no short ones."""
    for truncation in ("theory", "none", 1e-3):
        assert exactness_violation(HalfExplicitEuler(truncation=truncation)) == ""


def test_forms_offer_problems_with_each_of_their_features() -> None:
    """There are a mass matrix, up to three constraints, both regimes of eps, and noise of several motions."""
    motions = [trivial.problem for trivial in MOTIONS]
    assert {(p.mass is None, p.constraints) for p in motions} == {
        *product((True, False), (1, 2)),
        (False, 3),
    }
    dynamics: list[Problem] = [each.problem for (each,) in ConstrainedLangevin.trivial_problems()]
    assert {(p.eps > 0.0, p.constraints) for p in dynamics} == {
        (False, 1),
        (False, 2),
        (True, 2),
        (False, 3),
        (True, 3),
    }
