"""Every check of a scheme is seen to fail on a scheme with that one fault, and on no other."""

from dataclasses import dataclass
from itertools import count
from typing import ClassVar

import numpy as np
import pytest

from sdaeverify import SDE, THREE_POINT, Claim, Law, Scheme, Step
from sdaeverify.numerics import apply
from sdaeverify.testing import check_scheme, checks
from testing.asking import of_scheme

NAMES = [check.name for check in checks("scheme")]
SOUND = (Claim(measure="strong", value=0.5, source="a book"),)


def euler(problem, x, h, noise, t=0.0):
    return x + h * problem.drift(t, x) + apply(problem.diffusion(t, x), noise.dW)


@dataclass(frozen=True)
class Sound(Scheme):
    """Euler's scheme, in which the faults are planted."""

    theta: float = 0.5

    name: ClassVar[str] = "sound"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = SOUND
    source: ClassVar[str] = "a book"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return Step(euler(problem, state, h, noise, t))


class NoDataclass(Sound):
    """Parameters of such a class are those of its base."""

    more: int = 1


@dataclass(frozen=True)
class Doubled(Sound):
    """A scheme that changes its parameter."""

    def __post_init__(self):
        object.__setattr__(self, "theta", 2.0 * self.theta)


@dataclass(frozen=True)
class Forgetful(Sound):
    """A scheme whose copies are others."""

    def __reduce__(self):
        return Forgetful, (self.theta + 1.0,)


@dataclass(frozen=True)
class Loose(Sound):
    """A scheme whose parameters can be set."""


Loose.__setattr__ = object.__setattr__


@dataclass(frozen=True)
class Wordless(Sound):
    def step(self, problem, state, t, h, noise):
        return Step(euler(problem, state, h, noise))


@dataclass(frozen=True)
class Anonymous(Sound):
    """A scheme from nowhere."""

    source: ClassVar[str] = " "
    claims: ClassVar[tuple[Claim, ...]] = ()


@dataclass(frozen=True)
class Boasting(Sound):
    """A scheme that claims something about a measure that nobody knows."""

    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strnog", value=0.5, source="a book"),)


@dataclass(frozen=True)
class Vague(Sound):
    """A scheme whose claim is about a component that no problem has."""

    claims: ClassVar[tuple[Claim, ...]] = (*SOUND, Claim(measure="strong", value=0.5, source="x", quantities=("X",)))


@dataclass(frozen=True)
class Nowhere(Sound):
    """A scheme whose claim holds for traits that no problem has together."""

    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source="a book", when=frozenset({"delayed-noise", "no-delay"})),
    )


@dataclass(frozen=True)
class Clocked(Sound):
    """A scheme whose instance counts its steps and makes every fourth one longer."""

    def step(self, problem, state, t, h, noise):
        made = self.__dict__.get("made", 0) + 1
        object.__setattr__(self, "made", made)
        return super().step(problem, state, t, h if made % 4 else 1.01 * h, noise)


@dataclass(frozen=True)
class Failing(Sound):
    """A scheme that fails on some of the paths, and says so."""

    def step(self, problem, state, t, h, noise):
        failed = np.arange(state.shape[1]) % 2 > 0
        return Step(np.where(failed, state, super().step(problem, state, t, h, noise).state), failed=failed)


@dataclass(frozen=True)
class Silent(Failing):
    """A scheme that rejects on some of the paths, and does not say that it jumps."""

    def step(self, problem, state, t, h, noise):
        return Step(super().step(problem, state, t, h, noise).state)


@dataclass(frozen=True)
class Rejecting(Silent):
    """The same that says it, or takes no noise."""

    strength: float = 1.0

    discontinuous_in_noise: ClassVar[bool] = True

    def step(self, problem, state, t, h, noise):
        return super().step(problem, state, t, h, noise._replace(dW=self.strength * noise.dW))


@dataclass(frozen=True)
class Bounded(Sound):
    """A scheme with bounded increments, of which two thirds vanish."""

    law: ClassVar[Law] = THREE_POINT


def prepared(make):
    """Return a scheme whose rule (problem, x, h, noise) -> x is made anew for each problem and step size."""

    @dataclass(frozen=True)
    class Prepared(Sound):
        """A scheme that is one rule."""

        def prepare(self, problem, h):
            rule = make()
            return lambda state, t, noise: Step(rule(problem, state, h, noise))

    return Prepared()


def ruled(rule):
    """Return a scheme that is a rule (problem, x, h, noise) -> x."""
    return prepared(lambda: rule)


def counting():
    calls = count()
    return lambda p, x, h, n: euler(p, x, h, n) * (1.0 + 1e-14 * next(calls))


def two_steps():
    """Adams-Bashforth: the last drift is remembered by the state it led to, so that a call repeats itself."""
    drifts = {}

    def rule(problem, x, h, noise):
        f = problem.drift(0.0, x)
        before = drifts.get(x.tobytes(), f)
        new = x + h * (1.5 * f - 0.5 * before) + apply(problem.diffusion(0.0, x), noise.dW)
        drifts[new.tobytes()] = f
        return new

    return rule


def writing(problem, x, h, noise):
    x += 0.0
    return euler(problem, x, h, noise)


def needing_two(problem, x, h, noise):
    np.zeros(x.shape[1])[1]
    return euler(problem, x, h, noise)


def exchanging(problem, x, h, noise):
    """Use the noise of the path 13 places further in a long batch."""
    dW = np.roll(noise.dW, 13, axis=1) if x.shape[1] > 200 and x.shape[1] % 13 == 0 else noise.dW
    return euler(problem, x, h, noise._replace(dW=dW))


def right_in_blocks_of_13(problem, x, h, noise):
    """Double the drift unless there are few paths or a multiple of 13."""
    return euler(problem, x, h, noise) + h * problem.drift(0.0, x) * (x.shape[1] > 32 and x.shape[1] % 13 > 0)


def wrong_in_large_batches(problem, x, h, noise):
    """Double the drift from 10^4 paths on."""
    return euler(problem, x, h, noise) + h * problem.drift(0.0, x) * (x.shape[1] >= 10_000)


def right_for_powers_of_two(problem, x, h, noise):
    """Double the drift unless the number of steps is a power of two."""
    return euler(problem, x, h, noise) + h * problem.drift(0.0, x) * (np.log2(problem.horizon / h) % 1.0 > 1e-9)


def wrong_for_fifty(problem, x, h, noise):
    """Add a tenth of the drift in a run of fifty steps."""
    return euler(problem, x, h, noise) + 0.1 * h * problem.drift(0.0, x) * (abs(problem.horizon / h - 50.0) < 0.5)


FAULTS = {
    "declaration": [(NoDataclass(), "put @dataclass")],
    "label": [(Doubled(), "creates a different scheme")],
    "pickle": [(Forgetful(), "not equal to it")],
    "frozen": [(Loose(), "can be set")],
    "docstring": [(Wordless(), "no docstring")],
    "source": [(Anonymous(), "source is empty")],
    "claims": [(Boasting(), "did you mean strong")],
    "exact-on-trivial-equations": [(ruled(lambda p, x, h, n: euler(p, x, 2.0 * h, n)), "dx = c dt")],
    "inputs-untouched": [(ruled(writing), "writes into")],
    "state-like-its-own": [(ruled(lambda p, x, h, n: euler(p, x, h, n)[:, 1:]), "expected a state like")],
    "any-number-of-paths": [(ruled(needing_two), "IndexError")],
    "finite": [(ruled(lambda p, x, h, n: euler(p, x, h, n) / (x > x.min())), "not finite on 1 of")],
    "same-call-same-bits": [(prepared(counting), "same step made twice")],
    "paths-in-any-order": [
        (ruled(lambda p, x, h, n: euler(p, x, h, n) + 1e-12 * np.arange(x.shape[1])), "another order")
    ],
    "paths-alone": [
        (
            ruled(lambda p, x, h, n: euler(p, x, h, n) * (1.0 + 1e-11 * x.mean())),
            "each path must be stepped by itself",
        ),
        (ruled(exchanging), "each path must be stepped by itself"),
        (ruled(right_in_blocks_of_13), "each path must be stepped by itself"),
        (ruled(wrong_in_large_batches), "each path must be stepped by itself"),
    ],
    "any-number-of-steps": [
        (ruled(right_for_powers_of_two), "differs from steps of T/8 and T/16"),
        (ruled(wrong_for_fifty), "a step of T/50 differs from"),
    ],
    "declared-noise-only": [(ruled(lambda p, x, h, n: euler(p, x, h, n) + 1e-3 * n.H), "not declare: H")],
    "equation-alone": [
        (ruled(lambda p, x, h, n: euler(p, x, h, n) if "Kloeden" in p.source else x), "depends on the source"),
        (ruled(lambda p, x, h, n: euler(p, x, h if p.truths else 2.0 * h, n)), "observables or the truths"),
    ],
    "noise-is-used": [
        (ruled(lambda p, x, h, n: x + h * p.drift(0.0, x)), "ignores the sign or size of the noise on"),
        (
            ruled(lambda p, x, h, n: euler(p, x, h, n._replace(dW=n.dW * (x > x.min())))),
            "the step ignores the sign or size of the noise on 1 of",
        ),
        (Silent(), "ignores the sign or size of the noise on"),
        (Rejecting(strength=0.0), "ignores the sign or size of the noise on"),
    ],
    "own-memory": [(ruled(lambda p, x, h, n: n.dW), "view of the noise")],
    "state-is-whole": [
        (prepared(two_steps), "from a copy of its state after 3 steps"),
        (prepared(counting), "from a copy"),
        (Clocked(), "the scheme has memory outside its state"),
    ],
    "claims-tested": [
        (Vague(), "no result is about 'X'"),
        (Nowhere(), "applies to no registered problem with delayed-noise, no-delay"),
    ],
}


def test_every_check_of_a_scheme_has_a_fault():
    """Nothing is asked that was never seen to fail."""
    assert list(FAULTS) == NAMES


@pytest.mark.parametrize(("check", "scheme", "text"), [(c, *pair) for c, pairs in FAULTS.items() for pair in pairs])
def test_a_fault_is_found_by_its_check(check, scheme, text):
    """The check of this fault fails, and says what is wrong in one line."""
    outcome = of_scheme(scheme, check, "ou")

    assert outcome["status"] == "failed"
    assert text in outcome["reason"]
    assert "\n" not in outcome["reason"]


@pytest.mark.parametrize("problem", ["ou", "gbm", "noncommuting", "circle"])
def test_the_scheme_in_which_faults_are_planted_is_sound(problem):
    """Without fault, every check passes."""
    assert {row["status"] for row in check_scheme(Sound(), [problem])} == {"passed"}


def test_a_drift_that_is_remembered_elsewhere_is_found_by_no_other_check():
    """Memory that is found again by the state is no violation of purity: only a copied state shows it."""
    rows = check_scheme(
        prepared(two_steps), ["double-well"], expected_failures=[{"check": "pickle", "reason": "the class is local"}]
    )

    assert {row["check"] for row in rows if row["status"] == "failed"} == {"state-is-whole"}


def test_what_cannot_be_declared_is_not_run():
    """A class without @dataclass fails its declaration, and the checks that would run it are skipped."""
    statuses = {row["check"]: row["status"] for row in check_scheme(NoDataclass(), ["ou"])}

    assert statuses["declaration"] == "failed"
    assert {statuses[check.name] for check in checks("scheme") if check.category == "behaviour"} == {"skipped"}


@pytest.mark.parametrize("scheme", [Failing(), Bounded(), Rejecting()])
def test_paths_that_cannot_hear_are_not_counted(scheme):
    """A step that fails or rejects stays where it was, and an increment of zero has no sign."""
    assert of_scheme(scheme, "noise-is-used", "gbm")["status"] == "passed"


def test_a_step_whose_noise_cancels_at_one_size_hears_it():
    """The drift at the middle takes back all of dW for the rate 2/h, as at T/2 for the rate 4, but not at T/4."""

    def middle(problem, x, h, noise):
        """Take the drift at the middle of x and Euler's step."""
        kick = problem.diffused(0.0, x, noise.dW)
        return x + h * problem.drift(0.0, x + 0.5 * h * problem.drift(0.0, x) + 0.5 * kick) + kick

    def steep():
        """Return dx = -4 x dt + x dW."""
        linear = {"drift": lambda t, x: -4.0 * x, "diffusion": lambda t, x: x[:, None]}
        return SDE(**linear, start=[1.0], noise_dim=1, horizon=1.0, source="planted")

    assert of_scheme(ruled(middle), "noise-is-used", steep)["status"] == "passed"


def test_paths_without_noise_are_not_asked_whether_they_hear_it():
    """At x = 0 linear noise vanishes, and no step can show that it was heard."""

    def from_nothing():
        """Start where there is no noise."""
        linear = {"drift": lambda t, x: 1.0 - x, "diffusion": lambda t, x: x[:, None]}
        return SDE(**linear, start=[0.0], noise_dim=1, horizon=1.0, source="planted")

    assert of_scheme(Sound(), "noise-is-used", from_nothing)["status"] == "passed"


def test_paths_that_end_together_near_rounding_are_remarked():
    """An iteration that all paths end together at 1e-14 fails no check: it is said, with its size."""

    def together(p, x, h, n):
        known = euler(p, x, 0.0, n)
        y = known
        for _ in range(100):
            before, y = y, known + h * p.drift(0.0, y)
            if np.abs(y - before).max() < 1e-14:
                break
        return y

    outcome = of_scheme(ruled(together), "paths-alone", "ou")
    assert outcome["status"] == "skipped"
    assert "of the state's size: let an iteration end" in outcome["reason"]
