"""Reports on stages: the times at which a drift is taken, the sign of an area, a constant that is left out."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from _report import Report, pair_of

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl
from sdaeverify.numerics import largest, newton, update_tolerance

ADDITIVE = frozenset({"additive-noise"})
SOURCE = "Kloeden & Platen 1992, sections 12.2 and 15.4"


@dataclass(frozen=True)
class ForAdditive(Scheme):
    """A scheme for additive noise."""

    mended: bool = True

    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, source=SOURCE),
        Claim(measure="weak", value=2.0, source=SOURCE),
    )

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is not additive, and drifts that cannot be differentiated."""
        if "additive-noise" not in problem.traits:
            return "the noise is not additive"
        return problem.why_not_derivative_of_drift()


@dataclass(frozen=True)
class ImplicitTrapezoidal(ForAdditive):
    """x+ = x + (h/2) [f(t, x) + f(t + h, x+)] + B dW; faulty with the time t + h^2/2 for t + h."""

    name: ClassVar[str] = "stochasticdiffeq-667"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, unit, late = state, np.eye(len(state))[..., None], t + (h if self.mended else 0.5 * h * h)
        known = x + 0.5 * h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)

        def equation(y: Array) -> tuple[Array, Array]:
            value = y - known - 0.5 * h * problem.drift(late, y)
            return value, unit - 0.5 * h * problem.derivative_of_drift(late, y)

        root = newton(equation, known, update_tolerance(largest(x), largest(known)))
        return Step(root.x, failed=~root.converged)


@dataclass(frozen=True)
class OneTime(ForAdditive):
    """x+ = x + (h/2) [f(t, x) + f(t + h, x + h f + B dW)] + B dW; faulty with the time t in both."""

    name: ClassVar[str] = "probnum-252"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, f, kick = state, problem.drift(t, state), problem.diffused(t, state, noise.dW)
        later = problem.drift(t + h if self.mended else t, x + h * f + kick)
        return Step(x + 0.5 * h * (f + later) + kick)


@dataclass(frozen=True)
class TurnedArea(ForAdditive):
    """Roessler's SRA1; faulty with -H for the space-time area H."""

    name: ClassVar[str] = "diffrax-746"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.5, source="Roessler 2010, section 6"),
        Claim(measure="weak", value=2.0, source="measured"),
    )

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        x, f = state, problem.drift(t, state)
        mean = 0.5 * noise.dW + (noise.H if self.mended else -noise.H)
        later = problem.drift(t + 0.75 * h, x + 0.75 * h * f + 1.5 * problem.diffused(t, x, mean))
        return Step(x + h / 3.0 * (f + 2.0 * later) + problem.diffused(t, x, noise.dW))


@dataclass(frozen=True)
class LinearPart(ForAdditive):
    """x+ = x + h phi(h A) f(x) + phi(h A) B dW with A = Df(x), phi(z) = (e^z - 1)/z, one component.

    Faulty with e^{hA} x for x + h phi(h A) f(x), right where f(x) = A x.
    """

    name: ClassVar[str] = "stochrare-26"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, source="Hochbruck & Ostermann 2010, for additive noise"),
        Claim(measure="weak", value=1.0, source="Hochbruck & Ostermann 2010, for additive noise"),
    )

    def refuses(self, problem: SDE) -> str:
        """Refuse several components."""
        return "it takes one component" if problem.dimension != 1 else super().refuses(problem)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, z = state, h * np.broadcast_to(problem.derivative_of_drift(t, state), (1, *state.shape))[0]
        phi = np.where(z == 0.0, 1.0, np.expm1(z) / np.where(z == 0.0, 1.0, z))
        moved = x + h * phi * problem.drift(t, x) if self.mended else np.exp(z) * x
        return Step(moved + phi * problem.diffused(t, x, noise.dW))


REPORTS = (
    Report(
        ImplicitTrapezoidal,
        "https://github.com/SciML/StochasticDiffEq.jl/pull/667",
        "The implicit stage is taken at a time t + theta h^2, a step size too often multiplied.",
        "forced-ou,ou",
        ("f(t)", "depends on t"),
    ),
    Report(
        OneTime,
        "https://github.com/probabilistic-numerics/probnum/issues/252",
        "All stages of a Runge-Kutta step are taken at the time of its start.",
        "forced-ou,ou",
        ("f(t)", "depends on t"),
    ),
    Report(
        TurnedArea,
        "https://github.com/patrick-kidger/diffrax/pull/746",
        "The space-time Levy area has the wrong sign.",
        "forced-ou,angle-pendulum",
        ("f(b1)",),
    ),
    Report(
        LinearPart,
        "https://github.com/cbherbert/stochrare/issues/26",
        "The exact step of a linear drift leaves out its constant part.",
        "ou,forced-ou",
        ("dx = c dt",),
    ),
)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the pairs."""
    return [scheme for report in REPORTS for scheme in pair_of(report)]
