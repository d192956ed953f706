"""OpenMM's LangevinMiddleIntegrator as a sealed solver: OpenMM draws its own random numbers.

Each path is a particle of mass 1 on the first axis, in the unit system of OpenMM (nm, ps, dalton, kJ/mol), in which
dq = p dt, dp = (F(q) - gamma p) dt + sigma dW is Langevin dynamics at R T = sigma^2/(2 gamma). The force is a
`CustomExternalForce`, whose energy is an expression; the platform is Reference, in double precision.

One step of LFMiddle, as OpenMM's documentation cites it (Zhang, Liu et al. 2019), is with c = e^{-gamma h}

    v <- v + h F(q),   q <- q + (h/2) v,   v <- c v + (kT (1 - c^2))^(1/2) N,   q <- q + (h/2) v.

It has the positions of BAOAB, and its velocities are half a step off: p = v + (h/2) F(q) at the positions it stands
beside is that of BAOAB. A run begins with v = p - (h/2) F(q), so that positions are those of BAOAB from the begin.
For F = -omega^2 q the stationary law is normal, and by the invariance of its covariance

    E q^2 = kT/omega^2,   E v^2 = kT,   E q v = h kT/2,   E q p = 0,   E p^2 = kT (1 - h^2 omega^2/4).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from sdaeverify import Array, Claim, Langevin, hookimpl
from sdaeverify_bridges.kit import Library, why_not_temperature

from .contract import Sealed

LIBRARY = Library.find("openmm")
# Energies of one coordinate x, and the forces that they have.
ENERGIES: dict[str, Callable[[Array], Array]] = {
    "x^2/2": lambda x: -x,
    "x^4/4": lambda x: -(x**3),
    "-cos(x)": lambda x: -np.sin(x),
    "log(cosh(2*x))": lambda x: -2.0 * np.tanh(2.0 * x),
}
POINTS = np.linspace(-2.0, 2.0, 33)
PAGE = "https://docs.openmm.org/latest/api-python/generated/openmm.openmm.LangevinMiddleIntegrator.html"
CONFIGURATIONS = f"{PAGE}: 'more accurate configurational sampling', positions of BAOAB (Leimkuhler & Matthews 2013)"
VELOCITIES = f"{PAGE}: half step velocities 'provide a much more accurate sampling of the thermal ensemble'"
ON_STEP = "a user's expectation of the velocity at the time of the positions; OpenMM makes no such claim"


@dataclass(frozen=True)
class OpenMM(Sealed):
    """LangevinMiddleIntegrator.

    Attributes
    ----------
    on_step : bool
        Whether the velocities are p = v + (h/2) F(q), at the time of the positions; those that OpenMM returns if not.
    """

    on_step: bool = False

    name: ClassVar[str] = "openmm-langevin-middle"
    form: ClassVar[type[Langevin]] = Langevin
    steps: ClassVar[tuple[int, ...]] = (1, 2, 4)
    # What a run of everything contains shall not depend on which other libraries are installed.
    on_request: ClassVar[bool] = True
    source: ClassVar[str] = f"{LIBRARY}; Eastman et al. 2024"

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Accurate configurations and, of the velocities that are returned, an accurate temperature."""
        configurations = (
            _unbiased("q^2", 0.01, CONFIGURATIONS),
            _unbiased("cos q", 0.01, CONFIGURATIONS),
            Claim(measure="weak", value=2.0, margin=0.45, quantities=("q", "q^2"), source=CONFIGURATIONS),
        )
        return (*configurations, _unbiased("p^2", 0.02, ON_STEP if self.on_step else VELOCITIES))

    @property
    def claimant(self) -> str:
        """The library: the claims are those of its documentation."""
        return LIBRARY.name

    def refuses(self, problem: Langevin) -> str:
        """Refuse several degrees of freedom, dynamics without temperature, and forces without an expression."""
        if problem.noise_dim > 1:
            return "it has one degree of freedom, the problem has more"
        return why_not_temperature(problem) or energy_of(problem)[1]

    def run(self, problem: Langevin, h: float, T: float, paths: int, seed: int) -> Array:
        """Make the steps in OpenMM."""
        q, p = (np.repeat(row, paths) for row in problem.initial(1))
        context = context_of(problem, h, paths, seed)
        context.setPositions(along(q))
        context.setVelocities(along(p - 0.5 * h * self._force(problem, q)))
        context.getIntegrator().step(round(T / h))
        state = context.getState(positions=True, velocities=True)
        q, v = (found._value[:, 0] for found in (state.getPositions(True), state.getVelocities(True)))
        return np.asarray([q, v + 0.5 * h * self._force(problem, q) if self.on_step else v])

    def _force(self, problem: Langevin, q: Array) -> Array:
        return np.asarray(np.broadcast_to(problem.force(q[None]), (1, len(q)))[0])


def _unbiased(observable: str, bound: float, source: str) -> Claim:
    return Claim(measure="invariant", value="unbiased", bound=bound, quantities=(observable,), source=source)


def energy_of(problem: Langevin) -> tuple[str, str]:
    """Return the energy of a problem's force as an expression, and why there is none; one of them is empty."""
    force = np.broadcast_to(problem.force(POINTS[None]), (1, len(POINTS)))[0]
    basis = np.stack([each(POINTS) for each in ENERGIES.values()], axis=1)
    # The terms are linearly independent: a fit without residual is the force.
    weights, *_ = np.linalg.lstsq(basis, force, rcond=None)
    if not np.allclose(basis @ weights, force, rtol=0.0, atol=1e-9 * np.abs(force).max()):
        return "", f"its force has no potential among combinations of {', '.join(ENERGIES)}"
    weights[np.abs(weights) < 1e-9 * np.abs(weights).max()] = 0.0
    terms = zip(weights.tolist(), ENERGIES, strict=True)
    return "+".join(f"({weight!r})*({energy})" for weight, energy in terms if weight), ""


def context_of(problem: Langevin, h: float, paths: int, seed: int) -> Any:
    """Return OpenMM's context of one particle of mass 1 a path, with the integrator.

    Parameters
    ----------
    problem : Langevin
        With one degree of freedom.
    h : float
        Step size in ps.
    paths : int
        Number of particles.
    seed : int
        Of the integrator's random numbers.
    """
    import openmm  # noqa: PLC0415 - it may be missing, and takes a while

    system, force = openmm.System(), openmm.CustomExternalForce(energy_of(problem)[0])
    for particle in range(paths):
        system.addParticle(1.0)
        force.addParticle(particle, [])
    system.addForce(force)
    # 1 kJ/(mol dalton) is 1 nm^2/ps^2.
    gas = openmm.unit.MOLAR_GAS_CONSTANT_R.value_in_unit(openmm.unit.kilojoule_per_mole / openmm.unit.kelvin)
    temperature = problem.strength**2 / (2.0 * problem.friction) / gas
    integrator = openmm.LangevinMiddleIntegrator(temperature, problem.friction, h)
    integrator.setRandomNumberSeed(seed)
    return openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))


def along(values: Array) -> Array:
    """Return numbers of shape (P,) as vectors along the first axis, shape (P, 3)."""
    vectors = np.zeros((len(values), 3))
    vectors[:, 0] = values
    return vectors


@hookimpl
def sdaeverify_sealed() -> list[Sealed]:
    """Register the integrator with the velocities it returns; the other kind is named."""
    LIBRARY.require()
    return [OpenMM()]
