"""Whose errors reach which components: through the equation, through a scheme's steps, through its memory."""

import dataclasses
from collections.abc import Callable
from typing import ClassVar, NamedTuple

import numpy as np
import pytest

from cells import Formula
from facade import (
    EulerMaruyama,
    HalfExplicitEuler,
    judge_strong,
    local_strong,
    ou,
    pendulum,
    strong_orders,
    violation,
)
from probe.weak_cells import equation
from sdaeverify import SDE, Array, Increment, Scheme, Step
from sdaeverify.measuring import Verdict
from sdaeverify.numerics import apply
from sdaeverify.probe.local.reach import core, reach
from sdaeverify.probing import OneStep, cloud

Coupling = Callable[[float, Array], Array]
NAMES = {"a": slice(0, 1), "b": slice(1, 2)}
NONE = [[1, 0], [0, 1]]
ON_A = [[1, 0], [1, 1]]


def problem(coupling: Coupling = lambda t, a: 0.0 * a, noise: float = 0.0, start: float = 1.0) -> SDE:
    """Return growth a, and b with noise of its own, driven by a through its drift or its noise."""

    def drift(t: float, x: Array) -> Array:
        return np.stack([-0.5 * x[0], coupling(t, x[0]) - x[1]])

    def diffusion(t: float, x: Array) -> Array:
        zero = np.zeros_like(x[0])
        return np.stack([np.stack([0.8 * x[0], zero]), np.stack([zero, 0.6 + noise * x[0]])])

    traits = frozenset({"diagonal-noise"})
    return equation(drift, diffusion, [start, 0.5], names=NAMES, noise_dim=2, traits=traits)


def found(scheme: Scheme, of: SDE) -> list[list[int]]:
    """Return the matrix of reach."""
    step = OneStep(scheme, of)
    return reach(step, cloud(of, step.equation)).astype(int).tolist()


def verdict(of: SDE, component: str = "b") -> Verdict:
    """Return what one step of Euler's method says of a claim of order 1 for one component."""
    record = local_strong(EulerMaruyama(), of)
    return judge_strong(strong_orders(record)[list(NAMES).index(component)], 1.0).verdict


def test_a_component_that_no_other_reaches_is_judged_by_its_own_errors() -> None:
    """Euler's method is of order 1 where noise is additive, whatever it is of another component beside it."""
    assert found(EulerMaruyama(), problem()) == NONE
    assert verdict(problem()) is Verdict.VERIFIED
    assert verdict(problem(), "a") is Verdict.REFUTED


@pytest.mark.parametrize(
    "driven",
    [
        problem(lambda t, a: 0.7 * a),
        problem(noise=0.1),
        problem(lambda t, a: a * (t > 0.5)),
        problem(lambda t, a: np.maximum(a - 1.2, 0.0)),
        problem(lambda t, a: a * a, start=0.0),
    ],
    ids=["drift", "noise", "late", "in a region", "flat at the start"],
)
def test_errors_that_reach_a_component_count_for_it(driven: SDE) -> None:
    """Through drift or noise, late, at some states, from where a derivative vanishes: b loses order 1."""
    assert found(EulerMaruyama(), driven) == ON_A
    if driven.start[0]:
        assert verdict(driven) is Verdict.REFUTED


def test_errors_are_carried_on_by_components_between() -> None:
    """In a chain of three the last is reached by all, the first by none but itself."""

    def drift(t: float, x: Array) -> Array:
        return np.stack([-x[0], x[0] - x[1], x[1] - x[2]])

    names = {name: slice(i, i + 1) for i, name in enumerate("abc")}
    one = np.array([0.5, 0.0, 0.0])[:, None, None]
    chain = equation(drift, lambda t, x: x[:, None] * one, [1.0, 1.0, 1.0], names=names)
    assert found(EulerMaruyama(), chain) == [[1, 0, 0], [1, 1, 0], [1, 1, 1]]


def tamed(of: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Return an Euler step whose increments are divided by 1 + h |f|, the norm being that of all components."""
    f = of.drift(0.0, x)
    return x + h * f / (1.0 + h * np.sqrt((f * f).sum(axis=0))) + apply(of.diffusion(0.0, x), noise.dW)


class Remembered(NamedTuple):
    """The components, and the largest of them one step ago."""

    x: Array
    size: Array


class Late(Scheme):
    """Euler's method with a drift that is scaled by the size of the state before."""

    name: ClassVar[str] = "late"
    form: ClassVar[type[SDE]] = SDE

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Remembered:
        return Remembered(state, np.ones((1, state.shape[1])))

    def parts(self, problem: SDE, state: Remembered) -> dict[str, Array]:
        return dict(problem.parts(state.x))

    def step(self, problem: SDE, state: Remembered, t: float, h: float, noise: Increment) -> Step:
        x = state.x + h * (1.0 + h * state.size) * problem.drift(t, state.x)
        new = x + apply(problem.diffusion(t, state.x), noise.dW)
        return Step(Remembered(new, np.abs(state.x).max(axis=0, keepdims=True)))


@pytest.mark.parametrize("scheme", [Formula(tamed), Late()], ids=["at once", "by memory"])
def test_a_scheme_may_couple_what_the_equation_does_not(scheme: Scheme) -> None:
    """By a norm of all components, in this step or as it is remembered."""
    assert found(scheme, problem()) == [[1, 1], [1, 1]]


def test_the_core_is_what_coefficients_depend_on() -> None:
    """The sum of multipliers is a pure output: reached by all, reaching none."""
    step = OneStep(HalfExplicitEuler(), pendulum())
    states = cloud(step.view, step.equation)
    assert core(step.equation, step.names, states).tolist() == [True, True, False]
    assert reach(step, states).tolist() == [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]]


def test_a_weak_dependence_is_seen_beside_a_strong_noise() -> None:
    """Each coefficient has its own size: a drift of 10^-30 depends on x, whatever the diffusion is."""
    step = OneStep(EulerMaruyama(), ou(a=1e-30))
    assert core(step.equation, step.names, 1.0 + cloud(step.view, step.equation)).tolist() == [True]
    assert not violation(EulerMaruyama(), ou(a=1e-30))


def test_where_nothing_depends_on_anything_all_components_count() -> None:
    """Of dx = c dt + S dW no component is a pure output: its contract failed with an empty mean."""
    constant = dataclasses.replace(
        problem(),
        traits=frozenset(),
        drift=lambda t, x: 0.3 + 0.0 * x,
        diffusion=lambda t, x: np.full((2, 2, 1), 0.5),
    )
    step = OneStep(EulerMaruyama(), constant)
    assert core(step.equation, step.names, cloud(step.view, step.equation)).tolist() == [True, True]
    assert violation(EulerMaruyama(), constant) == ""
