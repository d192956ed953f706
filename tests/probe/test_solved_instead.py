"""Mistakes of authors are named from the rates of steps, each rightly, and of right schemes nothing is said."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import pytest

from facade import (
    MISTAKES,
    SCALINGS,
    STRENGTHS,
    load_registry,
    rows_of_classes,
    solved_instead,
    tree_classes_of,
    violation,
)
from sdaeverify import SDE, Array, Increment, Langevin, Scheme, Step
from sdaeverify.numerics import apply
from sdaeverify_lab.planted.coefficients import HeunOfItoDrift, ImplicitNoise, WithoutItoCorrection
from sdaeverify_lab.planted.contracts import WritesIntoState
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from trees.wrong import timed

SAYS = {
    "stratonovich": "Ito's equation is given, Stratonovich's is solved",
    "ito": "the drift is Stratonovich's, the noise is Ito's",
}


def drift(t: float, x: Array) -> Array:
    """Return a drift that is no multiple of anything else."""
    return np.stack([np.sin(x[1]) + 0.4 * np.cos(t) - 0.3 * x[0], np.cos(x[0] + x[1]) - 0.5])


def diffusion(t: float, x: Array) -> Array:
    """Return a diffusion of general noise with two motions."""
    first = [0.8 + 0.2 * np.sin(x[1] + t), 0.3 * np.cos(x[0])]
    second = [0.2 + 0.3 * np.cos(x[0]), 0.7 - 0.2 * np.sin(x[0] - x[1])]
    return np.stack([np.stack(first), np.stack(second)]).swapaxes(0, 1)


def generic() -> SDE:
    """Return an equation with general noise that depends on time."""
    return SDE(drift=drift, diffusion=diffusion, start=[0.3, -0.2], noise_dim=2, horizon=1.0, source="test")


def dynamics() -> Langevin:
    """Return Langevin dynamics whose numbers have no simple powers in common."""
    return Langevin(
        force=lambda q: np.sin(q) - 0.4 * q,
        friction=1.6,
        strength=0.7,
        position=[0.3, -0.4],
        momentum=[0.1, 0.5],
        horizon=1.0,
        source="test",
    )


def correction(problem: SDE, t: float, x: Array) -> Array:
    """Return half the sum of DB_j B_j by differences."""
    B, eps = problem.diffusion(t, x), 1e-6
    parts = (
        problem.diffusion(t, x + eps * B[:, j])[:, j] - problem.diffusion(t, x - eps * B[:, j])[:, j]
        for j in range(2)
    )
    return sum(parts) / (4.0 * eps)


@dataclass(frozen=True)
class Wrong(EulerMaruyama):
    """Euler-Maruyama with one line of its own.

    Attributes
    ----------
    line : callable
        From problem, time, state, step size and noise to the move of a step.
    """

    line: Callable[..., Array] = field(default=lambda *_: 0.0)

    name: ClassVar[str] = "wrong"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return Step(state + self.line(problem, t, state, h, noise.dW))


def euler(a: float = 1.0, c: float = 0.0, noise: Callable[..., Array] | None = None) -> Wrong:
    """Return a step with the drift a f + c/2 DB B and another noise."""
    noise = noise or (lambda B, dW, h: apply(B, dW))

    def line(problem: SDE, t: float, x: Array, h: float, dW: Array) -> Array:
        more = c * correction(problem, t, x) if c else 0.0
        return h * (a * problem.drift(t, x) + more) + noise(problem.diffusion(t, x), dW, h)

    return Wrong(line)


def tamed(divisor: Callable[[Array], Array]) -> Wrong:
    """Return Euler-Maruyama with the drift f/divisor(|f|)."""

    def line(problem: SDE, t: float, x: Array, h: float, dW: Array) -> Array:
        f = problem.drift(t, x)
        return h * f / divisor(np.sqrt((f**2).sum(axis=0))) + apply(problem.diffusion(t, x), dW)

    return Wrong(line)


def lengths(B: Array) -> Array:
    """Return the lengths of the rows of B."""
    return np.sqrt((B**2).sum(axis=1))


PLANTED = {
    "Stratonovich solved": (euler(c=1.0), SAYS["stratonovich"]),
    "Heun with Ito's drift": (HeunOfItoDrift(), SAYS["stratonovich"]),
    "the trapezoidal rule for noise": (ImplicitNoise(), SAYS["stratonovich"]),
    "corrected twice": (WithoutItoCorrection(), SAYS["ito"]),
    "correction without half, added": (euler(c=2.0), "backward Ito"),
    "correction without half": (euler(c=-2.0), "the drift lacks the whole correction"),
    "one increment": (euler(noise=lambda B, dW, h: B.sum(axis=1) * dW[:1]), "motions share one increment"),
    "first motion": (euler(noise=lambda B, dW, h: B[:, 0] * dW[:1]), "only the first Brownian motion acts"),
    "transposed": (euler(noise=lambda B, dW, h: np.einsum("jip,jp->ip", B, dW)), "transposed"),
    "covariance": (
        euler(noise=lambda B, dW, h: np.einsum("ikp,jkp,jp->ip", B, B, dW)),
        "the covariance is used in place of the diffusion",
    ),
    "independent": (euler(noise=lambda B, dW, h: lengths(B) * dW), "their correlation is lost"),
    "all at 0": (
        Wrong(lambda p, t, x, h, dW: h * p.drift(0.0, x) + apply(p.diffusion(0.0, x), dW)),
        "the coefficients are evaluated at t = 0",
    ),
    "drift at 0": (
        Wrong(lambda p, t, x, h, dW: h * p.drift(0.0, x) + apply(p.diffusion(t, x), dW)),
        "the drift is evaluated at t = 0",
    ),
    "diffusion at 0": (
        Wrong(lambda p, t, x, h, dW: h * p.drift(t, x) + apply(p.diffusion(0.0, x), dW)),
        "the diffusion is evaluated at t = 0",
    ),
    "h xi": (euler(noise=lambda B, dW, h: np.sqrt(h) * apply(B, dW)), "the noise is h xi"),
    "h dW": (euler(noise=lambda B, dW, h: h * apply(B, dW)), "the noise is h dW"),
    "xi": (euler(noise=lambda B, dW, h: apply(B, dW) / np.sqrt(h)), "the noise is xi"),
    "no drift": (euler(a=0.0), "the drift is left out"),
    "still": (Wrong(lambda p, t, x, h, dW: 0.0 * x), "a step returns its state unchanged"),
    "all but still": (
        Wrong(lambda p, t, x, h, dW: h**2 * p.drift(t, x)),
        "the drift is left out, the noise is left out",
    ),
    "sign": (euler(a=-1.0), "the drift has the wrong sign"),
    "halved": (euler(a=0.5), "the drift is halved"),
    "doubled noise": (euler(noise=lambda B, dW, h: 2.0 * apply(B, dW)), "multiplied by 4, the noise by 2"),
    "no noise": (euler(noise=lambda B, dW, h: 0.0 * apply(B, dW)), "the noise is left out"),
    "drift times x": (
        Wrong(lambda p, t, x, h, dW: h * p.drift(t, x) * x + apply(p.diffusion(t, x), dW)),
        "the drift is multiplied by the state",
    ),
    "diffusion times x": (
        Wrong(lambda p, t, x, h, dW: h * p.drift(t, x) + x * apply(p.diffusion(t, x), dW)),
        "the diffusion is multiplied by the state",
    ),
    "tamed": (tamed(lambda size: 1.0 + size), "it is tamed without the step size"),
    "truncated": (tamed(lambda size: np.maximum(1.0, size)), "it is truncated without the step size"),
}


@pytest.mark.sweep
@pytest.mark.parametrize(("scheme", "says"), PLANTED.values(), ids=PLANTED)
def test_mistakes_are_named(scheme, says):
    """Each one-line mistake is named, and by no other sentence."""
    assert says in solved_instead(scheme, generic())


def test_every_entry_is_planted():
    """No mistake is in the dictionary without a scheme that makes it."""
    said = [says for _, says in PLANTED.values()]
    sentences = [each.sentence for each in MISTAKES] + [*SCALINGS.values()]

    assert not [each for each in sentences if not any(says in each for says in said)]


@dataclass(frozen=True)
class WrongDynamics(Scheme):
    """Euler's method for Langevin dynamics with another line.

    Attributes
    ----------
    force, friction, strength : callable
        Factor of the force, and friction and strength from gamma and sigma.
    """

    force: float = 1.0
    friction: Callable[[float, float], float] = field(default=lambda g, s: g)
    strength: Callable[[float, float], float] = field(default=lambda g, s: s)

    name: ClassVar[str] = "wrong-dynamics"
    form: ClassVar[type] = Langevin
    claims: ClassVar[tuple[Any, ...]] = ()

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n, numbers = problem.noise_dim, (problem.friction, problem.strength)
        q, p = state[:n], state[n:]
        moved = self.force * problem.force(q) - self.friction(*numbers) * p
        return Step(np.concatenate([q + h * p, p + h * moved + self.strength(*numbers) * noise.dW]))


OF_STRENGTHS = {
    (1.0, -2, 0): lambda g, s: s / g,
    (1.0, -1, 0): lambda g, s: s / np.sqrt(g),
    (0.5, 0, 0): lambda g, s: s / np.sqrt(2.0),
    (0.5, -1, 0): lambda g, s: s / np.sqrt(2.0 * g),
    (0.5, -2, 0): lambda g, s: s / g / np.sqrt(2.0),
    (1.0, 0, 2): lambda g, s: s**2,
    (1.0, 1, 0): lambda g, s: s * np.sqrt(g),
    (1.0, 2, 0): lambda g, s: s * g,
}
DYNAMICS = {
    "friction halved": (WrongDynamics(friction=lambda g, s: 0.5 * g), "the friction is halved"),
    "no friction": (WrongDynamics(friction=lambda g, s: 0.0), "the friction is left out"),
    "friction of another sign": (WrongDynamics(friction=lambda g, s: -g), "the friction has the wrong sign"),
    "friction squared": (WrongDynamics(friction=lambda g, s: g**2), "the friction is gamma^2 where gamma is meant"),
    "force of another sign": (WrongDynamics(force=-1.0), "the force has the wrong sign"),
    "force halved": (WrongDynamics(force=0.5), "the force is halved"),
    "no noise": (WrongDynamics(strength=lambda g, s: 0.0), "the noise is left out"),
    "doubled variance": (WrongDynamics(strength=lambda g, s: np.sqrt(2.0) * s), "the noise is multiplied by 2"),
}


@pytest.mark.sweep
@pytest.mark.parametrize("powers", STRENGTHS, ids=str)
def test_strengths_of_langevin_noise(powers):
    """A wrong formula for the strength is told by the powers of friction and strength that it has."""
    assert (
        solved_instead(WrongDynamics(strength=OF_STRENGTHS[powers]), dynamics())
        == f"the noise is {STRENGTHS[powers]}"
    )


@pytest.mark.sweep
@pytest.mark.parametrize(("scheme", "says"), DYNAMICS.values(), ids=DYNAMICS)
def test_mistakes_in_langevin_dynamics(scheme, says):
    """Factors of force, friction and noise are told."""
    assert says in solved_instead(scheme, dynamics())


class UnscaledDynamics(WrongDynamics):
    """The noise is sqrt(h) dW."""

    name: ClassVar[str] = "unscaled-dynamics"

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=np.sqrt(h) * noise.dW))


def test_noise_of_langevin_dynamics_that_does_not_scale():
    """A power of h is told as for other equations."""
    assert "the noise is h xi" in solved_instead(UnscaledDynamics(), dynamics())


def test_what_no_entry_explains_has_no_sentence():
    """Two mistakes at once, or one that is in no dictionary, are not named."""
    both = euler(c=1.0, noise=lambda B, dW, h: 1.5 * apply(B, dW))
    other = Wrong(lambda p, t, x, h, dW: h * p.drift(t, 0.9 * x + 0.1) + apply(p.diffusion(t, x), dW))

    more = tamed(lambda size: 1.0 + 2.0 * size)

    assert [solved_instead(scheme, generic()) for scheme in (both, other, more)] == ["", "", ""]


def test_a_step_that_writes_into_its_argument_is_not_still():
    """Its result is its changed argument, which says nothing about the state before."""
    wrong = WritesIntoState()

    assert "unchanged" not in solved_instead(wrong, generic())
    assert "unchanged" in solved_instead(Wrong(lambda p, t, x, h, dW: 0.0 * x), generic())


def test_a_random_equation_tells_mistakes_with_the_same_rates_apart():
    """On an equation whose correction is its drift, a factor of the drift is not taken for a correction."""
    same = SDE(
        drift=lambda t, x: 0.5 * x,
        diffusion=lambda t, x: x[None],
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="test",
    )
    said = {a: solved_instead(euler(a=a), same) for a in (1.3, 2.0, 3.0)}

    assert said == {
        1.3: "the drift is multiplied by 1.3",
        2.0: "the drift is doubled",
        3.0: "the drift is multiplied by 3",
    }
    assert SAYS["stratonovich"] in solved_instead(HeunOfItoDrift(), same)


def test_where_two_entries_are_the_same_mistake_nothing_is_said(monkeypatch):
    """If two entries explain the rates of every equation, none is preferred."""
    twice = (*MISTAKES, MISTAKES[0]._replace(sentence="the same mistake in other words"))
    monkeypatch.setattr("sdaeverify.probe.local.solved_instead.MISTAKES", twice)

    assert solved_instead(PLANTED["Stratonovich solved"][0], generic()) == ""


def linear(rate: float, noise: Callable[..., Array]) -> SDE:
    """Return dx = rate x dt + noise dW with one component."""
    return SDE(
        drift=lambda t, x: rate * x,
        diffusion=lambda t, x: noise(x)[None],
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="test",
    )


def harmonic() -> Langevin:
    """Return Langevin dynamics with the force -2 q."""
    return Langevin(
        force=lambda q: -2.0 * q,
        friction=1.6,
        strength=0.7,
        position=[0.5],
        momentum=[0.2],
        horizon=1.0,
        source="test",
    )


@dataclass(frozen=True)
class Pulled(WrongDynamics):
    """Euler's method with a further force -q."""

    name: ClassVar[str] = "pulled"

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        after, n = super().step(problem, state, t, h, noise).state, problem.noise_dim
        return Step(np.concatenate([after[:n], after[n:] - h * state[:n]]))


def plus(a: float) -> Wrong:
    """Return Euler-Maruyama with a further drift a x."""
    return Wrong(lambda p, t, x, h, dW: h * (p.drift(t, x) + a * x) + apply(p.diffusion(t, x), dW))


# Another mistake that has the rates of one that is known, on one problem; the known one there, and both sentences.
ALIKE = {
    "drift": (
        linear(-1.0, np.ones_like),
        plus(1.0),
        euler(a=0.0),
        "the drift is left out",
        "there is a further drift x",
    ),
    "correction": (
        linear(0.3, lambda x: x),
        plus(0.5),
        HeunOfItoDrift(),
        f"dx = (f + (1/2) sum DB_j B_j) dt + B dW: {SAYS['stratonovich']}",
        "",
    ),
    "force": (harmonic(), Pulled(), WrongDynamics(force=1.5), "the force is multiplied by 1.5", ""),
}


@pytest.mark.sweep
@pytest.mark.parametrize(("problem", "other", "known", "says", "of_other"), ALIKE.values(), ids=ALIKE)
def test_a_mistake_is_named_only_if_it_is_one_on_other_equations(problem, other, known, says, of_other):
    """On a linear equation a further drift x may look like any wrong factor; it is never called one."""
    assert solved_instead(other, problem) == of_other
    assert solved_instead(known, problem) == says


@pytest.mark.long
def test_nothing_is_said_of_right_schemes():
    """No shipped scheme for SDEs or Langevin dynamics has a sentence, neither on problems nor on classes."""
    registry = load_registry(environ={})
    schemes = list(registry.things("sdaeverify_schemes").values())
    problems = [
        generic(),
        dynamics(),
        *(registry.things("sdaeverify_problems")[name]() for name in ("gbm", "ou")),
    ]
    said = {
        (scheme.label, problem.source): text
        for scheme in schemes
        for problem in problems
        if (view := scheme.view_of(problem)) is not None and not scheme.refuses(view)
        if (text := solved_instead(scheme, view, paths=any(claim.measure == "strong" for claim in scheme.promises)))
    }

    assert said == {}


def test_classes_name_mistakes_of_stages():
    """A class verdict says which coefficient is taken at a wrong time, and `why` begins with it."""
    wrong = timed(PlatenWeak2General(), "old-drift", "drift", scale=0.0)
    (kind,) = [each for each in tree_classes_of(wrong) if each.name == "general"]
    (row,) = [each for each in rows_of_classes(wrong, [kind], 2) if each.verdict == "refuted"]

    assert row.mistake == "the drift is evaluated only at t; the mean time of stages must be t + h/2"
    assert row.why.startswith(row.mistake)


@dataclass(frozen=True)
class Variance(EulerMaruyama):
    """Euler-Maruyama with noise of the variance 4 h."""

    name: ClassVar[str] = "variance-4"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=2.0 * noise.dW))


def test_classes_name_another_equation():
    """A class verdict of order 0 names the equation that is solved; a right scheme has no sentence."""
    (kind,) = [each for each in tree_classes_of(Variance()) if each.name == "scalar"]
    wrong, right = ([*rows_of_classes(scheme, [kind], 1)] for scheme in (Variance(), EulerMaruyama()))

    assert "multiplied by 4, the noise by 2" in wrong[0].why
    assert not any(each.mistake for each in right)


def test_langevin_classes_name_another_equation():
    """Of BAOAB without its last kick the force is halved."""

    class WithoutLast(BAOAB):
        name: ClassVar[str] = "without-last"

        def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
            after = super().step(problem, state, t, h, noise).state
            n = problem.noise_dim
            return Step(np.concatenate([after[:n], after[n:] - 0.5 * h * problem.force(after[:n])]))

    (kind,) = [each for each in tree_classes_of(WithoutLast()) if each.name == "langevin"][:1]
    rows = [*rows_of_classes(WithoutLast(), [kind], 2)]

    assert rows[0].mistake == "it solves another equation: the force is halved"


def test_a_violation_ends_with_the_mistake():
    """What a cell is refuted by says what the step solves instead; a right scheme violates nothing."""
    problem = generic()

    assert violation(Variance(), problem).endswith(": the variance of the noise is multiplied by 4, the noise by 2")
    assert violation(HeunOfItoDrift(), problem).endswith("Ito's equation is given, Stratonovich's is solved")
    assert violation(EulerMaruyama(), problem) == ""
