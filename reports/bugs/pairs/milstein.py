"""Reports on Milstein's term and on the calculus that it belongs to."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from _report import Report, pair_of

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl
from sdaeverify.numerics import apply

SOURCE = "Kloeden & Platen 1992, sections 10.3 and 11.1"
ONE = (Claim(measure="strong", value=1.0, source=SOURCE), Claim(measure="weak", value=1.0, source=SOURCE))


def turned(problem: SDE, t: float, x: Array, B: Array) -> list[Array]:
    """Return DB B_j for each j, shape (d, l, P): its column k is DB_k B_j."""
    return [
        problem.derivative_of_diffusion(t, x, np.broadcast_to(B[:, j], x.shape)) for j in range(problem.noise_dim)
    ]


def ito_correction(problem: SDE, t: float, x: Array, B: Array) -> Array:
    """Return (1/2) sum_j DB_j B_j, shape (d, P)."""
    columns = turned(problem, t, x, B)
    return np.asarray(0.5 * sum(columns[j][:, j] for j in range(problem.noise_dim)))


@dataclass(frozen=True)
class Differentiable(Scheme):
    """A scheme with Milstein's term."""

    mended: bool = True

    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = ONE

    def refuses(self, problem: SDE) -> str:
        """Refuse diffusions whose derivative cannot be had."""
        return problem.why_not_derivative_of_diffusion()


@dataclass(frozen=True)
class DerivativeFree(Differentiable):
    """x+ = x + h F + B dW + (B(u) - B(w)) dW^2/(4 s), u and w = x +- s B, s = sqrt(h); faulty with u = x + h F + s B.

    F is the Stratonovich drift. dW^2 has a mean, so that what F adds to u does not average out. Nor does the second
    derivative of B in a one-sided difference, which the report keeps.
    """

    name: ClassVar[str] = "stochasticdiffeq-19"

    def refuses(self, problem: SDE) -> str:
        """Refuse more than one Brownian motion."""
        if "scalar-noise" not in problem.traits:
            return "it takes one Brownian motion"
        return problem.why_not_derivative_of_diffusion()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, s = state, np.sqrt(h)
        B = problem.diffusion(t, x)
        F = problem.drift(t, x) - ito_correction(problem, t, x, B)
        if self.mended:
            up, down = (problem.diffusion(t, x + sign * s * B[:, 0])[:, 0] for sign in (1.0, -1.0))
            change = 0.5 * (up - down)
        else:
            change = problem.diffusion(t, x + h * F + s * B[:, 0])[:, 0] - B[:, 0]
        return Step(x + h * F + apply(B, noise.dW) + change * noise.dW**2 / (2.0 * s))


@dataclass(frozen=True)
class WithAreas(Differentiable):
    """x+ = x + h f + B dW + sum_jk DB_k B_j I_jk; faulty with I_kj for I_jk."""

    name: ClassVar[str] = "ordinarydiffeq-3214"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "A"})

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, B, double = state, problem.diffusion(t, state), noise.double_integrals(h)
        double = double if self.mended else double.swapaxes(0, 1)
        new = x + h * problem.drift(t, x) + apply(B, noise.dW)
        for j, column in enumerate(turned(problem, t, x, B)):
            new = new + np.einsum("dkp,kp->dp", np.broadcast_to(column, (*B.shape[:2], x.shape[1])), double[j])
        return Step(new)


@dataclass(frozen=True)
class OwnSquares(Differentiable):
    """The same; faulty with squares alone, as for diagonal noise: I_jk = 0 where j is not k."""

    name: ClassVar[str] = "sdetools-2"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "A"})

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, B, double = state, problem.diffusion(t, state), noise.double_integrals(h)
        double = double if self.mended else double * np.eye(problem.noise_dim)[..., None]
        new = x + h * problem.drift(t, x) + apply(B, noise.dW)
        for j, column in enumerate(turned(problem, t, x, B)):
            new = new + np.einsum("dkp,kp->dp", np.broadcast_to(column, (*B.shape[:2], x.shape[1])), double[j])
        return Step(new)


@dataclass(frozen=True)
class Commutative(Differentiable):
    """x+ = x + h f + B dW + (1/2) sum_jk DB_k B_j (dW_j dW_k - h delta_jk); faulty with DB_j B_j for all k."""

    name: ClassVar[str] = "qutip-1283"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, when=frozenset({"commutative-noise"}), source=SOURCE),
        Claim(measure="weak", value=1.0, when=frozenset({"commutative-noise"}), source=SOURCE),
    )

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, B, dW = state, problem.diffusion(t, state), noise.dW
        new = x + h * problem.drift(t, x) + apply(B, dW)
        for j, column in enumerate(turned(problem, t, x, B)):
            for k in range(problem.noise_dim):
                picked = column[:, k if self.mended else j]
                new = new + 0.5 * picked * (dW[j] * dW[k] - (h if j == k else 0.0))
        return Step(new)


@dataclass(frozen=True)
class HeunForIto(Differentiable):
    """Heun's scheme with the Stratonovich drift; faulty with Ito's drift."""

    name: ClassVar[str] = "torchsde-4"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source=SOURCE),
        Claim(measure="strong", value=1.0, when=frozenset({"commutative-noise"}), source=SOURCE),
        Claim(measure="weak", value=1.0, source=SOURCE),
    )

    def _at(self, problem: SDE, t: float, x: Array) -> tuple[Array, Array]:
        B = problem.diffusion(t, x)
        converted = ito_correction(problem, t, x, B) if self.mended else 0.0
        return problem.drift(t, x) - converted, B

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = state
        F, B = self._at(problem, t, x)
        kick = apply(B, noise.dW)
        G, C = self._at(problem, t + h, x + h * F + kick)
        return Step(x + 0.5 * (h * (F + G) + kick + apply(C, noise.dW)))


@dataclass(frozen=True)
class KloedenPlaten(Differentiable):
    """x+ = x + h f + g_1 B + g_2 B(u), u = x + h f + sqrt(h) B, g_2 = (dW^2 - h)/(2 sqrt h), g_1 = dW - g_2.

    Faulty with g_1 = -dW + g_2 + I_10/h, whose sum with g_2 is not dW.
    """

    name: ClassVar[str] = "brainpy-841"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})

    def refuses(self, problem: SDE) -> str:
        """Refuse more than one Brownian motion."""
        return "" if "scalar-noise" in problem.traits else "it takes one Brownian motion"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, s, dW = state, np.sqrt(h), noise.dW
        f, B = problem.drift(t, x), problem.diffusion(t, x)[:, 0]
        second = (dW * dW - h) / (2.0 * s)
        first = dW - second if self.mended else second - dW + noise.time_integral(h) / h
        later = problem.diffusion(t, x + h * f + s * B)[:, 0]
        return Step(x + h * f + first * B + second * later)


REPORTS = (
    Report(
        DerivativeFree,
        "https://github.com/SciML/StochasticDiffEq.jl/issues/19",
        "The supporting value of the Stratonovich form has the drift in it, whose part does not average out.",
        "gbm,hyperbolic",
        ("b1", "mean ~"),
    ),
    Report(
        WithAreas,
        "https://github.com/SciML/OrdinaryDiffEq.jl/pull/3214",
        "The double integrals are transposed, so that Levy areas have the wrong sign.",
        "levy-area",
        ("b1",),
    ),
    Report(
        OwnSquares,
        "https://github.com/horchler/SDETools/issues/2",
        "For general noise Milstein's term has the squares alone, as for diagonal noise.",
        "levy-area",
        ("b1",),
    ),
    Report(
        Commutative,
        "https://github.com/qutip/qutip/pull/1283",
        "An index in Milstein's double sum is the wrong one, with several noises.",
        "gbm,hyperbolic-pair",
        ("b1",),
    ),
    Report(
        HeunForIto,
        "https://github.com/google-research/torchsde/pull/4",
        "A scheme for Stratonovich's integral is given the drift of Ito's equation.",
        "gbm,noncommuting",
        ("Ito/Stratonovich",),
    ),
    Report(
        KloedenPlaten,
        "https://github.com/brainpy/BrainPy/pull/841",
        "The weights of the diffusion do not add up to the increment.",
        "hyperbolic,linear-test",
        ("dx = S dW",),
    ),
)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the pairs."""
    return [scheme for report in REPORTS for scheme in pair_of(report)]
