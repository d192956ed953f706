"""Stein identities as observables of ``invariant``: a law of which no mean is known, and a scheme of lower order."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from sdaeverify import SDE, Chart, Claim, InvariantMean, Line, MomentEquation, ProblemError, Scheme, Step, verify

OBSERVABLES = {"x": lambda t, s: s["x"][0], "x^2": lambda t, s: s["x"][0] ** 2}
VIRIAL = MomentEquation(observable="x^2", source="virial theorem")


def rippled() -> SDE:
    """Return dx = -(x + sin 2x / 2) dt + dW, whose invariant means are in no table."""
    return SDE(
        drift=lambda t, x: -x - 0.5 * np.sin(2.0 * x), diffusion=lambda t, x: np.ones((1, 1, 1)), start=[0.5],
        noise_dim=1, horizon=1.0, source="made up", traits=frozenset({"additive-noise", "overdamped-gradient"}),
        observables=OBSERVABLES, truths=(VIRIAL,), relaxation_time=1.0,
        chart=Chart(axes=(Line(0.0, 0.6),), embed=lambda z: z, read=lambda x: x),
    )  # fmt: skip


def rippled_chains() -> SDE:
    """Return the same without a chart, so that chains decide."""
    return replace(rippled(), chart=None)


@dataclass(frozen=True)
class Trapezoidal(Scheme):
    """Heun's scheme for additive noise, or Euler-Maruyama, whose stationary means are of order 1."""

    euler: bool = False

    name: ClassVar[str] = "trapezoidal"
    form: ClassVar[type] = SDE
    claims: ClassVar = (Claim(measure="invariant", value=2.0, source="Laurent & Vilmart 2020"),)

    def step(self, problem, state, t, h, noise):
        pushed = problem.diffused(t, state, noise.dW)
        f = problem.drift(t, state)
        mean = f if self.euler else 0.5 * (f + problem.drift(t + h, state + h * f + pushed))
        return Step(state + h * mean + pushed)


RIGHT, WRONG = "trapezoidal", "trapezoidal[euler=true]"


@pytest.mark.parametrize(
    ("problem", "right"),
    [(rippled, {"verified"}), pytest.param(rippled_chains, {"verified", "inconclusive"}, marks=pytest.mark.slow)],
)
def test_a_law_without_known_means(problem, right):
    """By the identity alone a scheme of order 2 is verified, or open by chains, and one of order 1 is refuted."""
    rows = verify([Trapezoidal(), Trapezoidal(euler=True)], [problem], "invariant").verdicts

    assert {*rows.quantity} == {"L x^2"}
    found = dict(zip(rows.scheme, rows.verdict, strict=True))
    assert found[WRONG] == "refuted"
    assert found[RIGHT] in right


def test_the_generator():
    """L x^2 = 2 x f + 1, by complex steps."""
    problem = rippled()
    x = np.array([[0.3, -1.2, 2.0]])
    (mean,) = problem.with_moment_equations.truths
    assert mean == InvariantMean(observable="L x^2", value=0.0, source="virial theorem")
    applied = problem.with_moment_equations.observe("L x^2", 0.0, {"x": x})
    assert applied == pytest.approx((2.0 * x * problem.drift(0.0, x) + 1.0)[0], rel=1e-8)
    assert problem.with_moment_equations is problem.with_moment_equations


def test_shipped_identities():
    """Langevin dynamics has the virial theorem, as E p^2 = -E q F(q) + gamma E q p."""
    from sdaeverify_problems.langevin.harmonic_langevin import harmonic_langevin  # noqa: PLC0415

    problem = harmonic_langevin()
    augmented = problem.with_moment_equations
    q, p = np.array([[0.3, -1.0]]), np.array([[1.2, 0.4]])
    wanted = p * p + q * (problem.force(q) - problem.friction * p)
    assert augmented.observe("L q p", 0.0, {"q": q, "p": p}) == pytest.approx(wanted[0], rel=1e-8)


def test_an_unknown_observable():
    """A moment equation is about one of the observables, and a problem without any is refused with what to attach."""
    with pytest.raises(ProblemError, match="a truth is about observable 'y'"):
        replace(rippled(), truths=(MomentEquation(observable="y", source="none"),))

    def unknown() -> SDE:
        return replace(rippled(), truths=())

    result = verify([Trapezoidal()], [unknown], "invariant")
    assert "attach an InvariantMean or a MomentEquation" in result.not_applicable.reason.iloc[0]
