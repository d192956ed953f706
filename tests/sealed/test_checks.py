"""What is told of a solver beside its claims: seeds, repetition, standard errors, and the motions it has used."""

from typing import ClassVar

import numpy as np
import pytest

from sdaeverify import SDE, Claim
from sdaeverify.studying import Source
from sdaeverify_sealed import Ends, Means, Sealed
from sdaeverify_sealed.checks import CLOSE, check_seeds
from sdaeverify_sealed.sample import Budget, moments_of_motions, seed_of
from sdaeverify_sealed.solvers import OwnEuler
from sealed.solving import rows, solver, verdicts

UNBIASED = Claim(measure="weak", value="unbiased", bound=0.05, quantities=("x",), source="made up")
QUICK = Budget(paths=2**13, looks=2)


class Exact(Sealed):
    """The exact law of x at T of dx = -x dt + sigma dW, by one normal variable a path."""

    name: ClassVar[str] = "exact"
    steps: ClassVar[tuple[int, ...]] = (1, 2, 3, 4, 5, 6)
    claims: ClassVar[tuple[Claim, ...]] = (UNBIASED,)

    def drawn(self, seed, paths):
        return np.random.default_rng(seed).standard_normal(paths)

    def run(self, problem: SDE, h, T, paths, seed):
        # Mean and variance at T by the moment equations of the problem: x is normal.
        mean, square = (truth.value(T) for truth in moments(problem))
        return (mean + np.sqrt(square - mean**2) * self.drawn(seed, paths))[None]


def moments(problem):
    named = {truth.observable: truth for truth in problem.truths if hasattr(truth, "observable")}
    known = {truth.observable: truth for truth in problem.truths if callable(getattr(truth, "value", None))}
    assert named
    return known["x"], known["x^2"]


GOING_ON = np.random.default_rng(11)


class Unrepeatable(Exact):
    """The same with numbers of one generator that goes on, whatever the seed is."""

    name: ClassVar[str] = "unrepeatable"

    def drawn(self, seed, paths):
        return GOING_ON.standard_normal(paths)


class Antithetic(Exact):
    """The same with paths in pairs of opposite noise."""

    name: ClassVar[str] = "antithetic"

    def drawn(self, seed, paths):
        half = super().drawn(seed, -(-paths // 2))
        return np.concatenate([half, -half])[:paths]


class Declared(Antithetic):
    """The same that says so."""

    name: ClassVar[str] = "declared"
    independent: ClassVar[bool] = False


class FourSeeds(Exact):
    """The same that uses two bits of its seed."""

    name: ClassVar[str] = "four-seeds"

    def drawn(self, seed, paths):
        return super().drawn(seed % 4, paths)


class Telling(Exact):
    """The same that returns the mean of x, and a standard error that takes dependent samples for independent ones."""

    name: ClassVar[str] = "telling"
    factor: ClassVar[float] = 0.5

    def run(self, problem, h, T, paths, seed):
        x = super().run(problem, h, T, paths, seed)[0]
        return Means({"x": x.mean()}, {"x": self.factor * x.std(ddof=1) / np.sqrt(paths)})


class RightlyTelling(Telling):
    """The same with the right standard error."""

    name: ClassVar[str] = "rightly-telling"
    factor: ClassVar[float] = 1.0


def found(made):
    """Return the verdicts on a solver by check and measure on ou."""
    told, _ = rows([made], "ou", QUICK)
    return {row.measure: row.finding.verdict.value for row in told}


def test_a_right_solver_passes():
    """The exact law is verified, and nothing is told beside."""
    assert found(Exact()) == {
        "weak": "verified",
        "standard errors": "verified",
        "own seeds": "verified",
        "same seed": "verified",
    }


def test_two_results_of_one_seed_are_a_fact():
    """A solver that cannot be repeated is judged as any other; what it is is told in one line."""
    told, _ = rows([Unrepeatable()], "ou", QUICK)
    (fact,) = (row.finding for row in told if row.measure == "same seed")

    assert {row.finding.verdict.value for row in told if row.measure != "same seed"} == {"verified"}
    assert fact.verdict.value == "not_applicable"
    assert "gives two results" in str(fact.reason)


@pytest.mark.parametrize("made", [FourSeeds(), solver("planted-seedless")], ids=lambda made: made.name)
def test_seeds_that_give_the_same_are_refuted(made):
    """Runs that are equal have no standard error: the check fails, and no claim is judged."""
    told = found(made)

    assert told["own seeds"] == "refuted"
    assert told["weak"] == "inconclusive"


def test_paths_that_depend_on_each_other_are_refuted_unless_declared():
    """Pairs of opposite noise are told by the spread between seeds; verdicts on the mean do not rest on it."""
    assert found(Antithetic())["standard errors"] == "refuted"
    assert found(Antithetic())["weak"] == "verified"
    assert "standard errors" not in found(Declared())


def test_a_stated_standard_error_is_compared_with_the_spread():
    """Half of the standard error is refuted, the right one verified; the mean is verified with both."""
    assert found(Telling())["standard errors"] == "refuted"
    assert found(RightlyTelling())["standard errors"] == "verified"
    assert found(Telling())["weak"] == found(RightlyTelling())["weak"] == "verified"


@pytest.mark.long
@pytest.mark.parametrize("name", ["planted-clipped", "planted-loud"])
def test_a_motion_that_is_none_is_refuted(name):
    """Increments of another law are told by W(T), and no claim of the solver is verified beside."""
    told = verdicts([solver(name)], "ou", Budget(paths=2**15, looks=1))

    assert told[name, "Brownian motion", "W(T)"] == "refuted"
    assert "verified" not in {
        verdict for (_, measure, _), verdict in told.items() if measure in {"weak", "invariant"}
    }


def test_a_motion_has_its_moments():
    """Of normal variables all moments are 0 within five standard errors; of signs the fourth is off by 2."""
    rng = np.random.default_rng(3)
    W = 2.0**0.5 * rng.standard_normal((2, 40_000))

    assert np.all(
        np.abs(moments_of_motions(W, 2.0)) < 5.0 * np.array([1, 1, 2**0.5, 1, 2**0.5, 96**0.5, 96**0.5]) / 200
    )
    assert moments_of_motions(np.sign(W), 1.0)[-1] == pytest.approx(-2.0)
    assert CLOSE < 2.0


def test_seeds_have_an_address():
    """The same address has the same seed, another one another, all of them positive numbers of 31 bits."""
    source = Source(1, "ou", 0, 10)
    seeds = {
        seed_of(source, "weak", level, look, group) for level in range(4) for look in range(3) for group in range(20)
    }

    assert len(seeds) == 240
    assert 1 <= min(seeds) <= max(seeds) < 2**31
    assert seed_of(source, "weak", 0, 0, 0) in seeds
    assert check_seeds(["a", "b", "a"], [1, 2, 1]).failed == ""


class Wrong(OwnEuler):
    """A solver that returns something else than it should."""

    name: ClassVar[str] = "wrong"
    claims: ClassVar[tuple[Claim, ...]] = (UNBIASED,)
    returned: ClassVar[object] = None

    def run(self, problem, h, T, paths, seed):
        return type(self).returned(paths)


@pytest.mark.parametrize(
    ("returned", "verdict", "told"),
    [
        (lambda paths: np.zeros((2, paths)), "error", "returned states of shape (2, 205), expected (1, 205)"),
        (lambda paths: np.zeros((1, paths - 1)), "error", "returned states of shape (1, 204)"),
        (lambda paths: {"x": np.zeros(paths)}, "error", "returned x of shape (205,)"),
        (lambda paths: Ends(np.zeros((1, paths)), np.zeros(paths)), "error", "returned W of shape (205,)"),
        (lambda paths: {"y": np.zeros((1, paths))}, "error", "returned no component that x needs"),
        (lambda paths: Means({"x^2": 1.0}), "error", "returned no mean of x; a claim that names its quantities"),
        (lambda paths: "a text", "error", "returned str, expected an array"),
        (lambda paths: None, "error", "returned"),
        (lambda paths: 1 / 0, "error", "ZeroDivisionError"),
        (lambda paths: np.random.default_rng().standard_normal((1, paths)) * np.nan, "diverged", "not finite"),
    ],
)
def test_what_is_no_law_is_one_line(returned, verdict, told):
    """A wrong shape, kind or number, or an error of the solver, is one line of its cell."""
    made = type("Wrong", (Wrong,), {"returned": staticmethod(returned)})()
    found, _ = rows([made], "ou", QUICK)

    assert found[0].finding.verdict.value == verdict
    assert told in str(found[0].finding.reason)
    assert "\n" not in str(found[0].finding.reason)
