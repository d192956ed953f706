"""The check that every run begins with: planted breaches are named, one by one."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from cells import Formula, Rule
from facade import (
    EPS,
    HalfExplicitEuler,
    angle_pendulum,
    circle,
    contract_violation,
    delay_ou,
    double_well,
    exactness_violation,
    gbm,
    noncommuting,
    ou,
    pendulum,
    violation,
)
from right.programmed_schemes import OwnHistory
from sdaeverify import (
    SDE,
    THREE_POINT,
    Array,
    Claim,
    HolonomicSDAE,
    HolonomicState,
    Increment,
    Langevin,
    Law,
    Problem,
    ProblemError,
    Scheme,
    SchemeError,
    Step,
    verify,
)
from sdaeverify.numerics import apply

HALF = Claim(measure="strong", value=0.5, source="made up")


@dataclass(frozen=True)
class Ruled(Formula):
    """The same that claims the strong order 1/2."""

    promised: tuple[Claim, ...] = (HALF,)


class Mechanical(Ruled):
    form: ClassVar[type[Problem]] = HolonomicSDAE


class Damped(Ruled):
    form: ClassVar[type[Problem]] = Langevin


class Coarse(Ruled):
    law: ClassVar[Law] = THREE_POINT


def euler(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    return x + h * problem.drift(0.0, x) + apply(problem.diffusion(0.0, x), noise.dW)


@pytest.mark.parametrize("problem", [gbm(), ou(), circle(), noncommuting()])
def test_the_rule_that_faults_are_planted_in_is_sound(problem: SDE) -> None:
    """Without fault nothing is found, with Gaussian or bounded increments."""
    assert violation(Ruled(euler), problem) == ""
    assert violation(Coarse(euler), problem) == ""


def iterated(problem: SDE, x: Array, h: float, noise: Increment, tolerance: float) -> Array:
    known = x + apply(problem.diffusion(0.0, x), noise.dW)
    y = known
    for _ in range(100):
        before, y = y, known + h * problem.drift(0.0, y)
        if np.abs(y - before).max() < tolerance:
            break
    return y


def needs_many(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    np.zeros(x.shape[1])[1]
    return euler(problem, x, h, noise)


@pytest.mark.parametrize("problem", [ou(x_0=0.01, sigma=0.01), double_well(), noncommuting()])
@pytest.mark.parametrize("tolerance", [1e-13, 1e-14])
def test_an_iteration_that_ends_for_all_paths_together_near_rounding_is_no_violation(problem, tolerance) -> None:
    """A converged path that is iterated on with its neighbours moves by a tolerance near rounding: it is let pass."""

    def together(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return iterated(problem, x, h, noise, tolerance * np.abs(problem.initial(1)).max())

    assert contract_violation(Ruled(together), problem) == ""


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_a_coarse_tolerance_for_all_paths_together_is_told_with_its_size(tolerance) -> None:
    """How far paths see each other is part of what is said: less than the tolerance, and more than a hundredth."""

    def together(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return iterated(problem, x, h, noise, tolerance)

    found = re.search(
        r"in a different batch gives a different result, by ([0-9.e-]+) of",
        contract_violation(Ruled(together), double_well()),
    )
    assert found is not None
    assert 0.01 * tolerance < float(found[1]) < tolerance


def test_what_a_step_raises_passes_through() -> None:
    """A scheme that cannot be run has broken no promise: the error is the caller's."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        raise ZeroDivisionError("no root")

    with pytest.raises(ZeroDivisionError, match="no root"):
        violation(Ruled(rule), gbm())


def test_what_a_step_raises_in_another_batch_is_no_violation() -> None:
    """An error tells nothing of the numbers: it is told as one, with the occasion, the file and the line."""
    with pytest.raises(SchemeError, match=r"^a step of few paths raises IndexError: .* \(\S*cells.py:\d+\)$"):
        violation(Ruled(needs_many), ou())


def test_ill_conditioned_steps_are_not_accused_of_their_rounding() -> None:
    """A last bit that depends on the place in the batch is let pass where the step amplifies it, and only there."""

    def amplified(factor: float) -> Rule:
        def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
            rounded = x * (1.0 + EPS * (np.arange(x.shape[1]) % 2))
            return euler(problem, x, h, noise) + 1e-3 * np.sin(factor * rounded)

        return rule

    def beside(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return euler(problem, x, h, noise) * (1.0 + 1e3 * EPS * (np.arange(x.shape[1]) % 2))

    assert contract_violation(Ruled(amplified(1e6)), ou()) == ""
    assert "another order" in contract_violation(Ruled(beside), ou())


def reuses(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Use the first noise for all columns."""
    return euler(problem, x, h, noise._replace(dW=np.broadcast_to(noise.dW[:1], noise.dW.shape)))


INEXACT: dict[str, tuple[Rule, str]] = {
    "takes h twice": (lambda p, x, h, n: euler(p, x, h, n) + h * p.drift(0.0, x), "dx = c dt"),
    "forgets the drift": (lambda p, x, h, n: x + apply(p.diffusion(0.0, x), n.dW), "dx = c dt"),
    "decays": (lambda p, x, h, n: euler(p, x, h, n) * (1.0 - 1e-12), "dx = 0"),
    "swaps noises": (lambda p, x, h, n: euler(p, x, h, n._replace(dW=n.dW[::-1])), "dx = S dW"),
    "reuses a noise": (reuses, "dx = S dW"),
    "noise times sqrt(2)": (lambda p, x, h, n: euler(p, x, h, n._replace(dW=2.0**0.5 * n.dW)), "dx = S dW"),
    "noise + 1 %": (lambda p, x, h, n: euler(p, x, h, n._replace(dW=1.005 * n.dW)), "dx = S dW"),
    "noise of size h": (lambda p, x, h, n: euler(p, x, h, n._replace(dW=np.sqrt(h) * n.dW)), "dx = S dW"),
}


@pytest.mark.sweep
@pytest.mark.parametrize("fault", INEXACT)
def test_an_error_on_a_trivial_equation_is_named(fault: str) -> None:
    """Each fault that an order test may miss is found on one of the trivial equations."""
    rule, equation = INEXACT[fault]

    found = violation(Ruled(rule), noncommuting())

    assert f"on {equation}" in found


def test_a_bounded_law_is_summed_as_it_was_given() -> None:
    """With three-point increments the sum is that of the increments, and twice that is a fault."""
    assert exactness_violation(Coarse(euler)) == ""
    assert "dx = S dW" in exactness_violation(Coarse(lambda p, x, h, n: euler(p, x, h, n._replace(dW=2.0 * n.dW))))


@pytest.mark.parametrize("power", [0.5, 1.0])
def test_tamed_increments_are_let_pass(power: float) -> None:
    """A relative error that vanishes like h^(1/2) or h is a matter of order; one that stays is none."""
    vanishing = Ruled(lambda p, x, h, n: x + (euler(p, x, h, n) - x) / (1.0 + h**power))
    staying = Ruled(lambda p, x, h, n: x + (euler(p, x, h, n) - x) / (1.0 + 0.1**power))

    assert exactness_violation(vanishing) == ""
    assert "dx = c dt" in exactness_violation(staying)


def test_a_scheme_is_asked_what_it_does_not_refuse() -> None:
    """One that takes a single noise only is tried on that, and its fault is found there."""

    class Single(Ruled):
        def refuses(self, problem: Problem) -> str:
            return "" if problem.noise_dim == 1 else "one noise only"

    class Invariant(Ruled):
        def refuses(self, problem: Problem) -> str:
            return "" if problem.has_constraints else "no constraint"

    class Nothing(Ruled):
        def refuses(self, problem: Problem) -> str:
            return "not this one"

    def wrong(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return x + 1.1 * (euler(problem, x, h, noise) - x)

    assert "dx = c dt" in exactness_violation(Single(wrong))
    assert "dx = c dt" in exactness_violation(Invariant(wrong))
    assert exactness_violation(Single(euler)) == exactness_violation(Invariant(euler)) == ""
    assert exactness_violation(Nothing(wrong)) == ""


def test_a_step_that_fails_where_it_does_not_refuse_is_named() -> None:
    """An error on a trivial equation is one of the step, unless it says itself that it is a refusal."""

    def narrow(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        if len(x) > 1:
            raise IndexError("one component only")
        return euler(problem, x, h, noise)

    def hands_on(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        problem.parts(np.zeros((7, 1)))
        return euler(problem, x, h, noise)

    with pytest.raises(SchemeError, match=r"a step raises IndexError: one component only .* on dx = 0 with 2"):
        exactness_violation(Ruled(narrow))
    assert exactness_violation(Ruled(hands_on)) == ""


def scalar(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Use one noise, and know of no more."""
    if len(noise.dW) > 1:
        raise NotImplementedError("does not support two motions")
    return euler(problem, x, h, noise)


def test_a_step_for_one_motion_is_told_nothing_of_two_where_there_is_one() -> None:
    """What a step does with more motions than a problem has is no fault of it there, and one where they are."""
    doubled = Ruled(lambda p, x, h, n: euler(p, x, h, n._replace(dW=np.sqrt(len(n.dW)) * n.dW)))

    assert violation(Ruled(scalar), gbm()) == violation(doubled, gbm()) == ""
    with pytest.raises(SchemeError, match=r"does not support two motions .* with 2 Brownian motions"):
        exactness_violation(Ruled(scalar), 2)
    found = exactness_violation(Ruled(lambda p, x, h, n: scalar(p, x, h, n._replace(dW=1.01 * n.dW))), 1)
    assert "dx = S dW" in found
    assert "2 Brownian" not in found
    assert "with 2 Brownian motions" in exactness_violation(doubled, 2)


def projected(factor: float) -> Rule:
    """Return Euler's step times a factor, followed by one step of Newton's method onto an invariant."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        y = x + factor * (euler(problem, x, h, noise) - x)
        normal = problem.dg(y)[0]
        return y - normal * problem.constraint(y) / (normal * normal).sum(axis=0)

    return rule


def test_a_scheme_that_needs_an_invariant_is_tried_where_there_is_one() -> None:
    """It need not know which equations have one: what it cannot be tried on refutes nothing."""
    assert exactness_violation(Ruled(projected(1.0))) == ""
    assert "on dx = c dt" in exactness_violation(Ruled(projected(1.1)))


def test_to_need_an_invariant_where_there_is_none_is_an_error_and_no_refutation() -> None:
    """The cell has one clear line; that of an equation with an invariant is measured."""

    class Projected(Scheme):
        name: ClassVar[str] = "projected"
        form: ClassVar[type[SDE]] = SDE
        claims: ClassVar[tuple[Claim, ...]] = (HALF,)

        def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
            """Make one step."""
            return Step(projected(1.0)(problem, state, h, noise))

    verdicts = verify([Projected()], ["ou", "circle"], "strong", paths=40, block=40).verdicts
    found = verdicts.drop_duplicates("problem").set_index("problem")

    assert found.verdict["ou"] == "error"
    assert found.reason["ou"].startswith("the equation has no constraint")
    assert found.verdict["circle"] not in {"error", "refuted"}


@pytest.mark.parametrize(
    "ask", [lambda p, x: p.linearised_constraint(0.0, x, x, x), lambda p, x: p.eliminated(0, x, x)]
)
def test_to_ask_for_y_where_there_is_none_is_no_assertion(ask: Callable[[Any, Array], Any]) -> None:
    """A delay equation without algebraic component says so."""
    with pytest.raises(ProblemError, match="has no algebraic component y"):
        ask(delay_ou(), np.ones((1, 1)))


def of_half_explicit(change: Callable[[HolonomicState, HolonomicState, float, Increment, Any], Any]) -> Scheme:
    inner = HalfExplicitEuler(truncation="none")

    def rule(problem: Any, state: HolonomicState, h: float, noise: Increment) -> Any:
        new = inner.step(problem, state, 0.0, h, noise).state
        return change(state, new, h, noise, problem)

    return Mechanical(rule)


MECHANICAL = {
    "sound": (lambda old, new, h, n, p: new, ""),
    "moves twice": (lambda old, new, h, n, p: new._replace(r=2.0 * new.r - old.r), "free motion"),
    "drifts": (lambda old, new, h, n, p: new._replace(r=new.r + 1e-10), "at rest"),
    "leaks": (lambda old, new, h, n, p: new._replace(mu=new.mu + 1e-9), "at rest"),
    "noise + 1 %": (
        lambda old, new, h, n, p: new._replace(v=new.v + [[0.01], [0.0]] * apply(p.diffusion(0.0, *old[:2]), n.dW)),
        "dv = c dt + S dW",
    ),
}


@pytest.mark.parametrize("fault", MECHANICAL)
def test_constrained_schemes_are_tried_on_a_line(fault: str) -> None:
    """On the linear constraint r_2 = 0 rest, free motion and constant force are known."""
    change, equation = MECHANICAL[fault]

    found = violation(of_half_explicit(change), pendulum())

    assert equation in found
    assert bool(found) is bool(equation)


def langevin(strength: float, drift: float) -> Rule:
    def rule(problem: Langevin, x: Array, h: float, noise: Increment) -> Array:
        n = problem.noise_dim
        q, p = x[:n], x[n:]
        kick = problem.force(q) - drift * problem.friction * p
        return np.concatenate([q + h * p, p + h * kick + strength * problem.strength * noise.dW])

    return rule


def test_langevin_schemes_are_tried_with_constant_force() -> None:
    """Euler's error on damped motion vanishes with h and is let pass; wrong friction or noise is found."""
    assert violation(Damped(langevin(1.0, 1.0)), angle_pendulum()) == ""
    assert "gamma p dt" in violation(Damped(langevin(1.0, 2.0)), angle_pendulum())
    assert "sigma dW" in violation(Damped(langevin(1.01, 1.0)), angle_pendulum())


@pytest.mark.parametrize("form", [SDE, HolonomicSDAE, Langevin])
def test_trivial_problems_start_where_their_solution_does(form: type[Problem]) -> None:
    """At time 0 the solution is the problem's initial state, and it obeys the problem's equation."""
    for trivial in (one for variants in form.trivial_problems() for one in variants):
        problem, t = trivial.problem, 1e-6
        none = np.zeros((problem.noise_dim, 1))
        W = np.full((problem.noise_dim, 1), 1e-3)
        start = problem.parts(problem.initial(1))
        ito = problem.ito()
        change = t * ito.drift(0.0, ito.initial(1)) + apply(ito.diffusion(0.0, ito.initial(1)), W)
        rows = dict(ito.names or {"x": slice(None)})

        for name, value in trivial.solution(0.0, none).items():
            assert np.array_equal(value, start[name])
            assert trivial.solution(t, W)[name] - value == pytest.approx(change[rows[name]], abs=1e-8)


def test_a_form_that_nothing_is_known_of_is_left_alone() -> None:
    """There are trivial problems for known forms only."""

    class Unknown(Problem):
        pass

    assert Unknown.trivial_problems() == ()


def test_a_scheme_with_a_history_of_its_own_is_not_entered_with_another() -> None:
    """Its state has more than `enter` sets, so that its single steps are not compared with the equation."""
    assert violation(OwnHistory(), delay_ou()) == ""
