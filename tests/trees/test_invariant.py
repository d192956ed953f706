"""Conditions of the invariant measure of overdamped dynamics: orders found, and where the conditions come from."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import grow, stationary_conditions
from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, UsageError, verify
from sdaeverify_orders import orders
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import HeunAdditive

CLASS = "overdamped-gradient"
SECOND: tuple[Claim, ...] = (Claim(measure="invariant", value=2.0, source="by its conditions"),)


@dataclass(frozen=True)
class TwoStages(Scheme):
    """x+ = x + h [(1 - w) f(x) + w f(x + a h f(x) + d B dW)] + B dW, with A = w a, B = w d and C = w d^2.

    Of weak order 1 unless A = B = C = 1/2; the invariant measure asks for A - 2 B = C - 2 B = -1/2 only.

    Attributes
    ----------
    w, a, d : float
    """

    w: float = 2.0 / 3.0
    a: float = 1.0 / 4.0
    d: float = 1.0 / 2.0

    name: ClassVar[str] = "two-stages"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=1.0, source="by its conditions"), *SECOND)

    def refuses(self, problem: SDE) -> str:
        """Refuse what is no overdamped dynamics."""
        return "" if CLASS in problem.traits else f"the trait {CLASS} is not stated"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        f, kick = problem.drift(t, state), problem.diffused(t, state, noise.dW)
        later = problem.drift(t, state + self.a * h * f + self.d * kick)
        return Step(state + h * ((1.0 - self.w) * f + self.w * later) + kick)


class AmbitiousEuler(EulerMaruyama):
    """Euler-Maruyama that claims the order 2."""

    name: ClassVar[str] = "ambitious-euler"
    claims: ClassVar[tuple[Claim, ...]] = SECOND


class HalfSpeed(HeunAdditive):
    """Heun's scheme for half of a step: the same law in the long run, reached in twice the time."""

    name: ClassVar[str] = "half-speed"
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make half a step."""
        return super().step(problem, state, t, 0.5 * h, noise._replace(dW=np.sqrt(0.5) * noise.dW))


class Louder(HeunAdditive):
    """Heun's scheme with noise that is too strong by one per cent."""

    name: ClassVar[str] = "louder"
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make a step with other noise."""
        return super().step(problem, state, t, h, noise._replace(dW=1.01 * noise.dW))


# Wrong by 2 per cent in one coefficient.
OFF = [TwoStages(w=0.68), TwoStages(a=0.255), TwoStages(d=0.51)]


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("scheme", "order", "verdict"),
    [
        ("heun-additive", 2.0, "verified"),
        ("sra1", 2.0, "verified"),
        ("platen-weak-2", 2.0, "verified"),
        ("stochastic-theta", 2.0, "out_of_scope"),
        ("stochastic-theta[theta=1]", 1.0, "out_of_scope"),
        ("euler-maruyama", 1.0, "verified"),
        (TwoStages(), 2.0, "verified"),
        (HalfSpeed(), 2.0, "verified"),
        (AmbitiousEuler(), 1.0, "refuted"),
        (Louder(), 0.0, "refuted"),
        *((scheme, 1.0, "refuted") for scheme in OFF),
    ],
)
def test_orders_of_the_invariant_measure(scheme, order, verdict):
    """The orders found are those of the literature; claims about the invariant measure are verified or refuted."""
    (row,) = orders(scheme, CLASS, 2).rows

    assert (row.measure, row.order, row.verdict) == ("invariant", order, verdict)


@pytest.mark.long
@pytest.mark.parametrize("motions", [1, 2, 3])
def test_a_scheme_of_weak_order_one_has_the_invariant_measure_to_order_two(motions):
    """A new scheme holds all conditions of the invariant measure, and not those of weak order 2."""
    scheme = TwoStages()
    (row,) = orders(scheme, CLASS, motions).rows

    assert (row.verdict, row.held) == ("verified", row.of)
    assert row.premise.startswith("drift -grad V, noise sigma dW, both equation and scheme ergodic")
    assert "the trait overdamped-gradient is not stated" in orders(scheme, "additive", motions).premises["additive"]


@pytest.mark.long
def test_a_failing_condition_names_its_combination_of_trees():
    """For Euler's method A = B = C = 0, for the noise that is too strong its variance is off."""
    (euler,) = orders(AmbitiousEuler(), CLASS, 2).rows
    (louder,) = orders(Louder(), CLASS, 2).rows
    (changed,) = orders(TwoStages(a=0.0), CLASS, 2).rows

    assert (euler.first.name, euler.first.texts) == ("f(f) - 2 b1 . f(b1)", ("0", "-1/2"))
    assert (louder.first.name, louder.first.texts) == ("b1 . b1", ("1.02", "1"))
    assert (changed.first.name, changed.first.texts) == ("f(f) - 2 b1 . f(b1)", ("-2/3", "-1/2"))


def test_a_combination_has_no_problem_of_its_own():
    """The closure of its trees is no equation with a potential."""
    report = orders(AmbitiousEuler(), CLASS, 2)

    with pytest.raises(UsageError, match="run matrix -m invariant -p double-well"):
        report.to_problem(report.failing[0])


def test_integration_by_parts_leaves_the_conditions_of_laurent_and_vilmart():
    """Of deterministic drift weights and increments with exact moments, A - 2 B and C - 2 B remain."""
    named = {str(next(iter(each))[0]): each for each in stationary_conditions(grow(1, 4), 1, 4) if each}
    combination = {" . ".join(map(str, forest)): str(c) for forest, c in named["f(b1,b1)"].items()}

    assert combination == {"f(b1,b1)": "1", "b1 . f(b1)": "-2", "b1 . b1 . f": "1", "b1 . b1 . b1 . b1": "-1/6"}


def lost(scheme, drift, potential, h):
    """Return int (E u(x+) - u(x)) exp(-V) dx for two u, with sigma^2 = 2."""
    x, z = np.linspace(-7.0, 7.0, 1401), np.polynomial.hermite_e.hermegauss(40)
    problem = SDE(
        drift=drift,
        diffusion=lambda t, x: np.full((1, 1, 1), 2.0**0.5),
        start=[0.3],
        noise_dim=1,
        horizon=1.0,
        source="a potential",
        traits=frozenset({CLASS}),
    )
    dW = np.sqrt(h) * np.tile(z[0], len(x))[None]
    before, noise = np.repeat(x, len(z[0]))[None], Increment(dW=dW, H=0.0 * dW)
    moved = scheme.step(problem, before, 0.0, h, noise).state.reshape(len(x), -1)
    density = np.exp(-potential(x))
    return [float(((u(moved) @ (z[1] / z[1].sum()) - u(x)) @ density) / density.sum()) for u in (np.cos, np.tanh)]


POTENTIALS = {
    "quadratic": (lambda t, x: 0.2 - x, lambda x: 0.5 * x * x - 0.2 * x),
    "quartic": (lambda t, x: x - x**3 + 0.2, lambda x: x**4 / 4 - x * x / 2 - 0.2 * x),
}


@pytest.mark.parametrize("name", POTENTIALS)
@pytest.mark.parametrize(
    ("scheme", "power"), [(TwoStages(), 3.0), (HeunAdditive(), 3.0), (AmbitiousEuler(), 2.0), (TwoStages(w=1.0), 2.0)]
)
def test_one_step_takes_from_the_invariant_law_what_the_conditions_say(scheme, power, name):
    """In two potentials, by quadrature: h^3 where the conditions of order 2 hold, and h^2 where they do not."""
    coarse, fine = (np.array(lost(scheme, *POTENTIALS[name], h)) for h in (2.0**-10, 2.0**-11))
    np.testing.assert_allclose(np.log2(np.abs(coarse / fine)), power, atol=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("problem", ["double-well", "ou"])
def test_the_engine_finds_the_same_order(problem):
    """The stationary law of the transition operator: order 2 for the new scheme, and not for a changed one."""
    right = verify(TwoStages(), problem, "invariant").verdicts
    wrong = verify(TwoStages(a=0.0), problem, "invariant").verdicts

    assert "verified" in set(right.verdict)
    assert "refuted" not in set(right.verdict)
    assert "refuted" in set(wrong.verdict)
