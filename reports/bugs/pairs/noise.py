"""Reports on the size and the place of the noise in an Euler step."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from _report import Report, pair_of

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl
from sdaeverify.numerics import apply

SOURCE = "Kloeden & Platen 1992, sections 10.2 and 14.1"
EULER = (Claim(measure="strong", value=0.5, source=SOURCE), Claim(measure="weak", value=1.0, source=SOURCE))


@dataclass(frozen=True)
class Scaled(Scheme):
    """x+ = x + h f + B dW; faulty with a factor that the increment has already."""

    mended: bool = True

    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = EULER
    power: ClassVar[float]

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        factor = 1.0 if self.mended else h**self.power
        return Step(state + h * problem.drift(t, state) + factor * problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class UnscaledCIR(Scaled):
    """The noise is a standard normal variable, whatever the step size."""

    name: ClassVar[str] = "mastering-7"
    power: ClassVar[float] = -0.5


@dataclass(frozen=True)
class EdwardSGLD(Scaled):
    """The noise has the standard deviation h."""

    name: ClassVar[str] = "edward-722"
    power: ClassVar[float] = 0.5
    claims: ClassVar[tuple[Claim, ...]] = (
        *EULER,
        Claim(
            measure="invariant", value=1.0, when=frozenset({"linear-growth", "unconstrained"}), source="Talay 1990"
        ),
    )


@dataclass(frozen=True)
class NoiseTwice(Scheme):
    """x+ = x + h f + B dW; faulty with another normal variable as a factor of B."""

    mended: bool = True

    name: ClassVar[str] = "iap-17"
    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        dW = noise.dW if self.mended else np.sqrt(12.0 / h) * noise.H * noise.dW
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, dW))


@dataclass(frozen=True)
class SummedNoise(Scheme):
    """x+ = x + h f + sum_j B_j dW_j; faulty with the sum of all B_j for each of them."""

    mended: bool = True

    name: ClassVar[str] = "brian2-330"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        B = problem.diffusion(t, state)
        kick = apply(B, noise.dW) if self.mended else B.sum(axis=1) * noise.dW.sum(axis=0)
        return Step(state + h * problem.drift(t, state) + kick)


@dataclass(frozen=True)
class ForgottenState(Scheme):
    """x+ = x + h f + B dW; faulty with 0 for x where there is no drift."""

    mended: bool = True

    name: ClassVar[str] = "brian2-686"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        f = problem.drift(t, state)
        x = state if self.mended or np.any(f) else 0.0 * state
        return Step(x + h * f + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class ConvertedTwice(Scheme):
    """x+ = x + h f + B dW; faulty with the drift f - (1/2) sum_j DB_j B_j of the logarithm."""

    mended: bool = True

    name: ClassVar[str] = "diffeqfinancial-27"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def refuses(self, problem: SDE) -> str:
        """Refuse diffusions whose derivative cannot be had."""
        return problem.why_not_derivative_of_diffusion()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, f = state, problem.drift(t, state)
        if not self.mended:
            B = problem.diffusion(t, x)
            f = f - 0.5 * sum(
                problem.derivative_of_diffusion(t, x, np.broadcast_to(B[:, j], x.shape))[:, j]
                for j in range(problem.noise_dim)
            )
        return Step(x + h * f + problem.diffused(t, x, noise.dW))


REPORTS = (
    Report(
        UnscaledCIR,
        "https://github.com/jamesmawm/Mastering-Python-for-Finance-source-codes/issues/7",
        "The noise of a step has variance 1 whatever the step size.",
        "gbm,ou",
        ("dx = S dW",),
    ),
    Report(
        EdwardSGLD,
        "https://github.com/blei-lab/edward/issues/722",
        "The standard deviation of the noise is the step size where its root is meant.",
        "ou,gbm",
        ("dx = S dW",),
    ),
    Report(
        NoiseTwice,
        "https://github.com/eje24/iap-diffusion-labs/issues/17",
        "The diffusion coefficient is multiplied by a random number of its own.",
        "ou,hyperbolic",
        ("dx = S dW",),
    ),
    Report(
        SummedNoise,
        "https://github.com/brian-team/brian2/issues/330",
        "Each noise is multiplied by the sum of the coefficients of all noises.",
        "noncommuting,gbm",
        ("2 Brownian motions",),
    ),
    Report(
        ForgottenState,
        "https://github.com/brian-team/brian2/issues/686",
        "Without a drift the increment replaces the state.",
        "gbm,ou",
        ("dx = 0", "dx = S dW"),
    ),
    Report(
        ConvertedTwice,
        "https://github.com/SciML/DiffEqFinancial.jl/issues/27",
        "The drift of the logarithm is taken for that of the process.",
        "gbm,hyperbolic",
        ("Ito/Stratonovich",),
    ),
)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the pairs."""
    return [scheme for report in REPORTS for scheme in pair_of(report)]
