"""What a run cannot show is said at its end: features that none of its problems has, and claims tested nowhere."""

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import pytest

from facade import (
    angle_pendulum,
    driven_double_pendulum,
    gbm,
    load_registry,
    noncommuting,
    ou,
    pendulum,
    plan,
    problem_spec,
    select_measures,
    select_problems,
    select_schemes,
    unseen,
    unseen_features,
)
from sdaeverify import (
    SDE,
    Claim,
    ConstrainedLangevin,
    DelaySDAE,
    Feature,
    HolonomicSDAE,
    IndexOneSDAE,
    Langevin,
    Problem,
    Scheme,
)

REGISTRY = load_registry()
MISSED, TIME = "HolonomicSDAE: no problem of this run has ", "a force or noise that depends on time"


def made(schemes: Any, problems: Any, measures: Any = "weak") -> Any:
    """Return the plan of a run."""
    return plan(
        select_schemes(REGISTRY, schemes), select_problems(REGISTRY, problems), select_measures(REGISTRY, measures)
    )


@pytest.mark.parametrize(
    ("schemes", "problems", "lines"),
    [
        (
            "half-explicit-euler[truncation=none]",
            "pendulum",
            [f"{MISSED}a mass matrix, several constraints, multiplicative noise or {TIME}"],
        ),
        (
            "half-explicit-euler[truncation=none]",
            "pendulum,sphere-langevin[m_2=2]",
            [f"{MISSED}several constraints, multiplicative noise or {TIME}"],
        ),
        ("half-explicit-euler[truncation=none]", "driven-double-pendulum", []),
        ("euler-maruyama", "pendulum", []),
        ("euler-maruyama", "noncommuting,growing-volatility", []),
        ("euler-maruyama", "three-motions", ["SDE: no problem of this run has coefficients that depend on time"]),
        ("baoab", "angle-pendulum", []),
        ("baoab", "harmonic-langevin", ["Langevin: no problem of this run has a force that is not linear"]),
        (
            "penalised-euler",
            "affine-constraint",
            ["ConstrainedLangevin: no problem of this run has several constraints or a curved constraint"],
        ),
        ("stochastic-theta", "delay-pair,delay-linear", []),
    ],
)
def test_features_without_a_problem_are_named(schemes: str, problems: str, lines: Sequence[str]) -> None:
    """A form counts where a scheme solves it itself: of a view nothing is said."""
    assert list(unseen_features(made(schemes, problems))) == lines


def test_every_feature_has_a_problem_in_a_default_run() -> None:
    """A run of everything has a problem for each feature of each form."""
    assert unseen_features(made((), ())) == ()


def test_every_scheme_of_anyone_meets_every_feature_of_its_form() -> None:
    """A scheme that is not shipped is put to all problems of a default run, whatever schemes they list."""

    class Theirs(Scheme):
        name: ClassVar[str] = "theirs"

    lines = []
    for kind in (SDE, HolonomicSDAE, ConstrainedLangevin, DelaySDAE, Langevin):
        scheme = type("Theirs", (Theirs,), {"form": kind})()
        theirs = plan([scheme], select_problems(REGISTRY), select_measures(REGISTRY, "weak"))
        lines += unseen_features(theirs)
    assert lines == []


@pytest.mark.parametrize("form", [SDE, Langevin, HolonomicSDAE, ConstrainedLangevin, DelaySDAE, IndexOneSDAE])
def test_features_are_measured_in_every_trivial_problem(form: type[Problem]) -> None:
    """Each feature can be asked of each problem of the form: the answer is a truth value."""
    for variants in form.trivial_problems():
        for trivial in variants:
            for feature in form.features():
                assert feature.found(trivial.problem) in {True, False}


def test_features_are_measured_and_not_declared() -> None:
    """A mass matrix that is given as the identity is none, and noise is multiplicative whatever the traits say."""

    def found(problem: Problem) -> set[str]:
        return {feature.name for feature in type(problem).features() if feature.found(problem)}

    assert "a mass matrix" in found(driven_double_pendulum())
    assert "a mass matrix" not in found(pendulum())
    assert "multiplicative noise" in found(gbm())
    assert "multiplicative noise" not in found(ou())
    assert "noises that do not commute" in found(noncommuting())
    assert found(angle_pendulum()) == {"a force that is not linear"}
    unit = HolonomicSDAE(
        mass=np.eye(2),
        force=lambda _t, r, _v: 0.0 * r,
        diffusion=lambda _t, r, _v: 0.0 * r[:, None],
        constraint=lambda r: r[1:],
        position=[0.0, 0.0],
        velocity=[1.0, 0.0],
        noise_dim=1,
        horizon=1.0,
        source="made up",
    )
    assert found(unit) == set()


class Broken(Scheme):
    """A scheme with claims about two traits that no problem has together."""

    name: ClassVar[str] = "with-claims"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=1.0, source="made up"),
        Claim(measure="weak", value=2.0, when=frozenset({"scalar-noise", "constrained"}), source="made up"),
        Claim(measure="strong", value=2.0, when=frozenset({"constrained"}), source="made up"),
    )

    def step(self, problem: SDE, state: Any, t: float, h: float, noise: Any) -> Any:
        """Raise: no step is made."""
        raise NotImplementedError


def test_claims_tested_nowhere_are_counted_in_one_line() -> None:
    """Only claims about measures of the run count; the traits that no problem has are named."""
    (line,) = [text for text in unseen(made(Broken(), "gbm")) if "tested nowhere" in text]
    words = "1 claim was tested nowhere: with-claims, weak order >= 2.0: no problem of this run has both"
    assert line == f"{words} constrained and scalar-noise"
    (line,) = [text for text in unseen(made(Broken(), "gbm", ("weak", "strong"))) if "tested nowhere" in text]
    assert line.startswith("2 claims were tested nowhere: ")
    assert line.endswith("; 1 more")
    assert not [text for text in unseen(made(Broken(), "circle")) if "tested nowhere" in text]


def test_a_problem_that_cannot_be_evaluated_has_no_feature() -> None:
    """A coefficient that raises is reported by the run: here it says nothing."""

    def broken() -> SDE:
        def drift(t: float, x: Any) -> Any:
            if t > 0.0:
                raise ArithmeticError("no such time")
            return -x

        return SDE(
            drift=drift,
            diffusion=lambda _t, x: x[:, None],
            start=[1.0],
            noise_dim=1,
            horizon=1.0,
            source="made up",
        )

    euler, weak = select_schemes(REGISTRY, "euler-maruyama"), select_measures(REGISTRY, "weak")
    assert "coefficients that depend on time" in unseen_features(plan(euler, [problem_spec(broken)], weak))[0]


class Tagged(SDE):
    """A form of another author with a feature of its own."""

    @classmethod
    def features(cls) -> tuple[Feature, ...]:
        """Return one feature."""
        return (Feature("a long horizon", lambda problem: problem.horizon > 1.0),)


class TaggedEuler(Scheme):
    """A scheme for it."""

    name: ClassVar[str] = "tagged-euler"
    form: ClassVar[type[SDE]] = Tagged


@pytest.mark.parametrize(
    ("horizon", "lines"), [(1.0, ["Tagged: no problem of this run has a long horizon"]), (2.0, [])]
)
def test_a_form_of_another_author_brings_its_own_features(horizon: float, lines: Sequence[str]) -> None:
    """Nothing in the framework knows the form or its feature by name."""

    def tagged() -> Tagged:
        return Tagged(
            drift=lambda _t, x: -x,
            diffusion=lambda _t, x: 0.0 * x[:, None],
            start=[1.0],
            noise_dim=1,
            horizon=horizon,
            source="made up",
        )

    made_by_hand = plan([TaggedEuler()], [problem_spec(tagged)], select_measures(REGISTRY, "weak"))
    assert list(unseen_features(made_by_hand)) == lines
