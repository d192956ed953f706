"""Schemes that give some components of the solution: SHAKE and RATTLE codes return r and v, and no multiplier."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest

from facade import departure, local_strong, local_weak, match, sphere_langevin, strong_orders, weak_order
from sdaeverify import (
    Angle,
    Array,
    Chart,
    Claim,
    HolonomicSDAE,
    Increment,
    InvariantMean,
    Line,
    Scheme,
    Step,
    verify,
)
from sdaeverify.numerics import norm
from sdaeverify.probing import OneStep


class Phase(NamedTuple):
    r: Array
    v: Array


@dataclass(frozen=True)
class Rattle(Scheme):
    """Geodesic BAOAB of Leimkuhler & Matthews (2016) on the unit sphere with unit mass and friction 1.

    A moves along great circles, B and O project onto the tangent plane. `flaw` plants a mistake: ``noise`` has the
    variance h in O, in place of (1 - exp(-2 h))/2; ``kick`` has the whole kick first; ``friction`` doubles it.
    """

    flaw: str = ""

    name: ClassVar[str] = "rattle"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    gives: ClassVar[tuple[str, ...]] = ("r", "v")
    claims: ClassVar[tuple[Claim, ...]] = tuple(
        Claim(measure=measure, value=value, source="Leimkuhler & Matthews 2016")
        for measure, value in {"strong": 1.0, "weak": 2.0, "invariant": 2.0}.items()
    )

    def refuses(self, problem: HolonomicSDAE) -> str:
        r = np.eye(problem.dimension) + 0.5
        return "only for the unit sphere" if np.abs(problem.constraint(r / norm(r))).max() > 1e-12 else ""

    def enter(self, problem: HolonomicSDAE, state: Any, t: float, h: float) -> Phase:
        return Phase(state.r, state.v)

    def step(self, problem: HolonomicSDAE, state: Phase, t: float, h: float, noise: Increment) -> Step:
        variance = h if self.flaw == "noise" else -0.5 * np.expm1(-2.0 * h)
        decay = np.exp(-2.0 * h if self.flaw == "friction" else -h)
        first, last = (h, 0.0) if self.flaw == "kick" else (0.5 * h, 0.5 * h)
        r, v = move(*kick(problem, *state, first), 0.5 * h)
        v = decay * v + np.sqrt(variance / h) * tangent(r, problem.diffused(t, r, v, noise.dW))
        return Step(Phase(*kick(problem, *move(r, v, 0.5 * h), last)))


def tangent(r: Array, y: Array) -> Array:
    """Return the part of y in the tangent plane at r."""
    return y - r * (r * y).sum(axis=0)


def kick(problem: HolonomicSDAE, r: Array, v: Array, h: float) -> tuple[Array, Array]:
    """Return r and v after the force without friction has acted."""
    return r, v + h * tangent(r, problem.force(0.0, r, 0.0 * v))


def move(r: Array, v: Array, h: float) -> tuple[Array, Array]:
    """Return r and v after a motion along a great circle."""
    speed = norm(v)
    ahead = v / np.where(speed > 0.0, speed, 1.0)
    c, s = np.cos(h * speed), np.sin(h * speed)
    return c * r + s * ahead, tangent(c * r + s * ahead, speed * (c * ahead - s * r))


class Remembered(NamedTuple):
    force: Array
    r: Array
    v: Array


@dataclass(frozen=True)
class Remembering(Rattle):
    """The same with the force of the last step beside r and v, as molecular dynamics codes keep it."""

    name: ClassVar[str] = "remembering-rattle"

    def enter(self, problem: HolonomicSDAE, state: Any, t: float, h: float) -> Remembered:
        return Remembered(problem.force(t, state.r, 0.0 * state.v) + 0.0 * state.r, state.r, state.v)

    def parts(self, problem: HolonomicSDAE, state: Remembered) -> dict[str, Array]:
        return {"r": state.r, "v": state.v}

    def step(self, problem: HolonomicSDAE, state: Remembered, t: float, h: float, noise: Increment) -> Step:
        made = super().step(problem, Phase(state.r, state.v), t, h, noise).state
        return Step(self.enter(problem, made, t, h))


@dataclass(frozen=True)
class Undeclared(Remembering):
    """A scheme without multiplier that does not say so."""

    name: ClassVar[str] = "undeclared"
    gives: ClassVar[tuple[str, ...]] = ()


@dataclass(frozen=True)
class Mistyped(Rattle):
    """A scheme that misspells a component."""

    name: ClassVar[str] = "mistyped"
    gives: ClassVar[tuple[str, ...]] = ("r", "vv")


def weak(scheme: Scheme) -> float:
    """Return the local weak order on the sphere."""
    return weak_order(local_weak(scheme, scheme.view_of(SPHERE))).order


SPHERE = sphere_langevin()


@pytest.mark.parametrize("scheme", [Rattle(), Remembering()])
def test_weak_order_of_positions_and_velocities_is_found_without_multiplier(scheme: Scheme) -> None:
    """Geodesic BAOAB has the weak order 2 in one step, with further memory as well."""
    assert weak(scheme) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("flaw", ["noise", "kick"])
def test_weak_order_of_a_wrong_splitting_is_1(flaw: str) -> None:
    """A wrong variance of the noise, and an unsymmetric splitting, have the weak order 1."""
    assert weak(Rattle(flaw)) == pytest.approx(1.0, abs=0.1)


def test_a_wrong_friction_leaves_the_equation() -> None:
    """Steps with twice the friction follow another equation of r and v, and right ones do not."""
    assert departure(Rattle(), Rattle().view_of(SPHERE)) == ""
    assert "wrong equation" in departure(Rattle("friction"), Rattle("friction").view_of(SPHERE))


def test_strong_orders_are_of_the_given_components() -> None:
    """One step has a strong order of r and of v, and none of mu."""
    view = Rattle().view_of(SPHERE)
    orders = [found.order for found in strong_orders(local_strong(Rattle(), view))]
    assert orders == pytest.approx([1.0, 1.0, 1.0], abs=0.15)
    assert list(view.ito().names) == ["r", "v"]


def test_the_multiplier_stays_for_schemes_that_give_it() -> None:
    """The problem itself, and its view for other schemes, keep mu as a component."""
    assert list(SPHERE.ito().names) == ["r", "v", "mu"]
    assert SPHERE.giving(()) is SPHERE
    assert SPHERE.giving(("r",)) is SPHERE
    assert [*SPHERE.parts(SPHERE.initial(1))] == ["r", "v", "mu"]


def test_a_scheme_that_does_not_say_what_it_gives_is_told_how() -> None:
    """Memory beside r and v raises nothing, and the reason names the attribute."""
    scheme = Undeclared()
    assert departure(scheme, scheme.view_of(SPHERE)) == ""
    reason = OneStep(scheme, SPHERE).untold(scheme.start(SPHERE, 1, 0.5))
    assert reason == "the state of the scheme has no mu; if that is intended, declare gives = ('r', 'v')"


def test_a_misspelt_component_is_an_error_with_the_name_that_may_be_meant() -> None:
    """A component that the problem lacks is named, with those that it has."""
    found = match(Mistyped(), SPHERE)
    assert found.failed
    assert found.reason == "gives vv, expected components of a HolonomicSDAE: r, v, mu; did you mean v?"


def circle() -> HolonomicSDAE:
    """Return a heavy point on the unit circle, its invariant law known."""
    kT = 0.5
    theta = 2.0 * np.pi * np.arange(128) / 128
    weights = np.exp(-np.sin(theta) / kT)
    height = float(weights @ np.sin(theta) / weights.sum())

    def embed(z: Array) -> Array:
        c, s = np.cos(z[0]), np.sin(z[0])
        return np.stack([c, s, -z[1] * s, z[1] * c, 0.0 * z[0]])

    return HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.0], [-1.0]]) - v,
        diffusion=lambda t, r, v: np.eye(2)[..., None],
        constraint=lambda r: 0.5 * (r * r).sum(axis=0, keepdims=True) - 0.5,
        position=[1.0, 0.0],
        velocity=[0.0, 0.5],
        horizon=0.5,
        noise_dim=2,
        traits=frozenset({"additive-noise"}),
        observables={"r_2": lambda t, s: s["r"][1], "|v|^2": lambda t, s: (s["v"] ** 2).sum(axis=0)},
        truths=(
            InvariantMean(observable="r_2", value=height, source="quadrature"),
            InvariantMean(observable="|v|^2", value=kT, source="quadrature"),
        ),
        chart=Chart(
            axes=(Angle(), Line(0.0, np.sqrt(kT))),
            embed=embed,
            read=lambda x: np.stack([np.arctan2(x[1], x[0]), x[0] * x[3] - x[1] * x[2]]),
        ),
        relaxation_time=4.0,
        source="made up",
    )


@pytest.mark.long
def test_weak_and_invariant_orders_are_verified_by_a_chart_without_multiplier() -> None:
    """Weak and invariant order 2 of geodesic BAOAB are verified; those of its wrong twins are refuted."""
    found = {}
    for scheme in (Rattle(), Rattle("kick"), Rattle("noise")):
        result = verify([scheme], [circle], ["weak", "invariant"], seed=1)
        found[scheme.flaw] = set(result.verdicts.verdict)
    assert found[""] == {"verified"}
    assert "refuted" in found["noise"]
    assert "refuted" in found["kick"]


@pytest.mark.long
@pytest.mark.parametrize(("flaw", "verdict"), [("", "verified"), ("kick", "refuted"), ("noise", "refuted")])
def test_weak_order_on_the_registered_sphere_is_verified(flaw: str, verdict: str) -> None:
    """The problem declares controls of weak order 2: it is verified there, and refuted of the wrong twins."""
    result = verify([Rattle(flaw)], ["sphere-langevin"], ["weak"], paths=512, seed=1)
    assert set(result.verdicts.verdict) == {verdict}
