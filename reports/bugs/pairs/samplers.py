"""Reports on samplers: the acceptance of Langevin proposals, and preconditioned noise."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from _report import Report, pair_of

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl

BALANCE = "Roberts & Tweedie 1996, section 1.4: detailed balance"
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


def log_density_ratio(problem: SDE, t: float, x: Array, y: Array) -> Array:
    """Return log rho(y) - log rho(x) = (2/sigma^2) int_x^y f, shape (1, P)."""
    middle, half = 0.5 * (x + y), 0.5 * (y - x)
    integral = sum(w * problem.drift(t, middle + z * half) for z, w in zip(NODES, WEIGHTS, strict=True)) * half
    return np.asarray(2.0 * integral / problem.diffusion(t, x)[:, 0] ** 2)


@dataclass(frozen=True)
class Sampler(Scheme):
    """A sampler of exp(-2 V/sigma^2) from dx = -V' dt + sigma dW, x in R."""

    mended: bool = True

    form: ClassVar[type] = SDE

    def refuses(self, problem: SDE) -> str:
        """Refuse what has no invariant density that is known from the drift at one time."""
        if problem.dimension != 1 or problem.noise_dim != 1 or "additive-noise" not in problem.traits:
            return "it takes one component with additive noise"
        x = problem.initial(1)
        if not np.any(problem.diffusion(0.0, x)):
            return "without noise there is no invariant density"
        moves = np.any(problem.drift(0.0, x) != problem.drift(problem.horizon, x))
        return "the drift depends on time" if moves else ""


@dataclass(frozen=True)
class Adjusted(Sampler):
    """A step y = x + h f(x) + sigma dW is accepted with probability min(1, exp(a)), else x stays."""

    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    discontinuous_in_noise: ClassVar[bool] = True
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="invariant", value="unbiased", bound=0.012, quantities=("x^2",), source=BALANCE),
        Claim(measure="invariant", value="unbiased", bound=0.005, quantities=("cos x",), source=BALANCE),
    )

    def log_ratio(self, problem: SDE, t: float, h: float, x: Array, y: Array) -> Array:
        """Return a, shape (1, P)."""
        raise NotImplementedError

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = state
        y = x + h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)
        accepted = np.log(noise.uniform(h)) < self.log_ratio(problem, t, h, x, y)
        return Step(np.where(accepted, y, x))


def proposals(problem: SDE, t: float, h: float, x: Array, y: Array, drifts: tuple[Array, Array]) -> Array:
    """Return log q(y, x) - log q(x, y), shape (1, P), where the drifts at x and at y are as given."""
    variance = problem.diffusion(t, x)[:, 0] ** 2
    forth, back = (y - x - h * drifts[0]) ** 2, (x - y - h * drifts[1]) ** 2
    return (forth - back) / (2.0 * h * variance)


@dataclass(frozen=True)
class SwappedGradients(Adjusted):
    """Faulty with the drift at y in the density of the proposal from x, and the other way round."""

    name: ClassVar[str] = "advancedmh-95"

    def log_ratio(self, problem: SDE, t: float, h: float, x: Array, y: Array) -> Array:
        """Return a, shape (1, P)."""
        f, g = problem.drift(t, x), problem.drift(t, y)
        drifts = (f, g) if self.mended else (g, f)
        return log_density_ratio(problem, t, x, y) + proposals(problem, t, h, x, y, drifts)


@dataclass(frozen=True)
class OtherProposal(Adjusted):
    """Faulty with the densities of proposals of twice the drift and twice the deviation."""

    name: ClassVar[str] = "bat-532"

    def log_ratio(self, problem: SDE, t: float, h: float, x: Array, y: Array) -> Array:
        """Return a, shape (1, P)."""
        f, g, part = problem.drift(t, x), problem.drift(t, y), 1.0
        if not self.mended:
            f, g, part = 2.0 * f, 2.0 * g, 0.25
        return log_density_ratio(problem, t, x, y) + part * proposals(problem, t, h, x, y, (f, g))


@dataclass(frozen=True)
class AlwaysAccepted(Adjusted):
    """Faulty with a = 0: a new value is subtracted from itself."""

    name: ClassVar[str] = "walnuts-27"

    def log_ratio(self, problem: SDE, t: float, h: float, x: Array, y: Array) -> Array:
        """Return a, shape (1, P)."""
        if not self.mended:
            return 0.0 * x
        return log_density_ratio(problem, t, x, y) + proposals(
            problem, t, h, x, y, (problem.drift(t, x), problem.drift(t, y))
        )


@dataclass(frozen=True)
class Unadjusted(Adjusted):
    """Faulty with every proposal taken: unadjusted Langevin dynamics."""

    name: ClassVar[str] = "caustics-388"

    def log_ratio(self, problem: SDE, t: float, h: float, x: Array, y: Array) -> Array:
        """Return a, shape (1, P)."""
        drifts = problem.drift(t, x), problem.drift(t, y)
        return log_density_ratio(problem, t, x, y) + proposals(problem, t, h, x, y, drifts)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        if self.mended:
            return super().step(problem, state, t, h, noise)
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class Preconditioned(Sampler):
    """x+ = x + h G f + sqrt(G) sigma dW with G = 2, of the same invariant law; faulty without sqrt(G)."""

    name: ClassVar[str] = "tfp-50"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="invariant", value=1.0, when=frozenset({"linear-growth"}), source="Talay 1990"),
    )

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        root = np.sqrt(2.0) if self.mended else 1.0
        return Step(state + 2.0 * h * problem.drift(t, state) + root * problem.diffused(t, state, noise.dW))


REPORTS = (
    Report(
        SwappedGradients,
        "https://github.com/TuringLang/AdvancedMH.jl/issues/95",
        "The densities of the proposals forth and back are taken with each other's gradient.",
        "ou,double-well",
        ("accept", "preconditioner"),
    ),
    Report(
        OtherProposal,
        "https://github.com/bat/BAT.jl/issues/532",
        "The acceptance uses the density of another proposal than the one that was drawn.",
        "ou,double-well",
        ("accept", "preconditioner"),
    ),
    Report(
        AlwaysAccepted,
        "https://github.com/bob-carpenter/walnuts/issues/27",
        "The new log density is subtracted from itself, so that every proposal is accepted.",
        "ou,double-well",
        ("accept", "preconditioner"),
    ),
    Report(
        Unadjusted,
        "https://github.com/Ciela-Institute/caustics/pull/388",
        "A sampler that is called Metropolis-adjusted takes every proposal.",
        "ou,double-well",
        ("accept", "preconditioner"),
    ),
    Report(
        Preconditioned,
        "https://github.com/tensorflow/probability/issues/50",
        "The noise lacks the root of the preconditioner.",
        "ou",
        ("accept", "preconditioner"),
    ),
)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the pairs."""
    return [scheme for report in REPORTS for scheme in pair_of(report)]
