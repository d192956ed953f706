"""Reports on thermostats: friction and noise of Langevin dynamics."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from _report import Report, pair_of

from sdaeverify import Array, Claim, Increment, Langevin, Scheme, Step, hookimpl

SECOND = tuple(
    Claim(measure=measure, value=2.0, source="Leimkuhler & Matthews 2013") for measure in ("weak", "invariant")
)
FIRST = (
    Claim(measure="strong", value=1.0, source="Kloeden & Platen 1992, section 10.2: additive noise"),
    Claim(measure="weak", value=1.0, source="Kloeden & Platen 1992, section 14.1"),
)


@dataclass(frozen=True)
class Thermostat(Scheme):
    """A scheme for Langevin dynamics."""

    mended: bool = True

    form: ClassVar[type] = Langevin


def ornstein_uhlenbeck(problem: Langevin, p: Array, h: float, gamma: float, dW: Array) -> Array:
    """Return the momentum after friction gamma and noise during h, with a variable dW of variance h.

    The invariant variance is sigma^2/(2 gamma_0) with the problem's friction gamma_0.
    """
    part = -np.expm1(-2.0 * gamma * h) / (2.0 * problem.friction) if gamma > 0.0 else h
    return np.asarray(np.exp(-gamma * h) * p + problem.strength * np.sqrt(part / h) * dW)


@dataclass(frozen=True)
class Substeps(Thermostat):
    """B (A O A)^2 B with half a step of A O A each; faulty with the friction of a whole step in both O."""

    name: ClassVar[str] = "openmm-3790"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        n, gamma = problem.noise_dim, problem.friction * (1.0 if self.mended else 2.0)
        q, p = state[:n], state[n:]
        p = p + 0.5 * h * problem.force(q)
        for sign in (1.0, -1.0):
            # Two independent variables of variance h/2.
            dW = 0.5 * noise.dW + sign * np.sqrt(3.0) * noise.H
            q = q + 0.25 * h * p
            p = ornstein_uhlenbeck(problem, p, 0.5 * h, gamma, dW)
            q = q + 0.25 * h * p
        return Step(np.concatenate([q, p + 0.5 * h * problem.force(q)]))


@dataclass(frozen=True)
class FrictionInNoise(Thermostat):
    """p+ = p + h (F - gamma p) + sqrt(2 gamma kT) dW, q+ = q + h p+; faulty with sqrt(2 kT/gamma)."""

    name: ClassVar[str] = "lammps-2948"
    claims: ClassVar[tuple[Claim, ...]] = FIRST

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n, gamma = problem.noise_dim, problem.friction
        q, p = state[:n], state[n:]
        kT = problem.strength**2 / (2.0 * gamma) if gamma else 0.0
        sigma = problem.strength if self.mended or not gamma else np.sqrt(2.0 * kT / gamma)
        p = p + h * (problem.force(q) - gamma * p) + sigma * noise.dW
        return Step(np.concatenate([q + h * p, p]))


@dataclass(frozen=True)
class VarianceForDeviation(Thermostat):
    """B A O A B; faulty with the variance of the Ornstein-Uhlenbeck step for its standard deviation."""

    name: ClassVar[str] = "abides-10"
    claims: ClassVar[tuple[Claim, ...]] = SECOND

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n, gamma = problem.noise_dim, problem.friction
        q, p = state[:n], state[n:] + 0.5 * h * problem.force(state[:n])
        variance = problem.strength**2 * (-np.expm1(-2.0 * gamma * h) / (2.0 * gamma) if gamma else h)
        size = np.sqrt(variance) if self.mended else variance
        new = np.exp(-gamma * h) * p + size * noise.dW / np.sqrt(h)
        q = q + 0.5 * h * (p + new)
        return Step(np.concatenate([q, new + 0.5 * h * problem.force(q)]))


@dataclass(frozen=True)
class FrictionWithoutStep(Thermostat):
    """p+ = p + h (F - gamma p) + sigma dW, q+ = q + h p+; faulty with -gamma p for -h gamma p."""

    name: ClassVar[str] = "pybnn-4"
    claims: ClassVar[tuple[Claim, ...]] = FIRST

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n = problem.noise_dim
        q, p = state[:n], state[n:]
        friction = problem.friction * p * (h if self.mended else 1.0)
        p = p + h * problem.force(q) - friction + problem.strength * noise.dW
        return Step(np.concatenate([q + h * p, p]))


@dataclass(frozen=True)
class NoNoise(Thermostat):
    """p+ = p + h (F - gamma p) + sigma dW, q+ = q + h p+; faulty without the noise."""

    name: ClassVar[str] = "sghmc-2"
    claims: ClassVar[tuple[Claim, ...]] = FIRST

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n = problem.noise_dim
        q, p = state[:n], state[n:]
        kick = problem.strength * noise.dW if self.mended else 0.0
        p = p + h * (problem.force(q) - problem.friction * p) + kick
        return Step(np.concatenate([q + h * p, p]))


BOTH = "harmonic-langevin,angle-pendulum"
REPORTS = (
    Report(
        Substeps,
        "https://github.com/openmm/openmm/issues/3790",
        "Each substep has the friction of a whole step.",
        BOTH,
        ("gamma p",),
    ),
    Report(
        FrictionInNoise,
        "https://github.com/lammps/lammps/issues/2948",
        "The noise is divided by the root of the friction where it is multiplied by it.",
        "harmonic-langevin",
        ("sigma dW",),
    ),
    Report(
        VarianceForDeviation,
        "https://github.com/jpmorganchase/abides-jpmc-public/issues/10",
        "The variance of an exact Ornstein-Uhlenbeck step is taken for its standard deviation.",
        BOTH,
        ("sigma dW",),
    ),
    Report(
        FrictionWithoutStep,
        "https://github.com/automl/pybnn/issues/4",
        "The friction is not multiplied by the step size.",
        BOTH,
        ("gamma p",),
    ),
    Report(
        NoNoise,
        "https://github.com/TurboFreeze/sghmc/issues/2",
        "Friction without the noise that belongs to it.",
        BOTH,
        ("sigma dW",),
    ),
)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the pairs."""
    return [scheme for report in REPORTS for scheme in pair_of(report)]
