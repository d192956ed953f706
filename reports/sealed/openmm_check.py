"""Moments of OpenMM's LangevinMiddleIntegrator in a harmonic well, with OpenMM and NumPy alone.

`pip install openmm && python reports/sealed/openmm_check.py` prints them beside what the invariance of the covariance
under one step of LFMiddle gives, for mass 1 and dq = p dt, dp = (-omega^2 q - gamma p) dt + sigma dW.
"""

import numpy as np
import openmm

OMEGA, GAMMA, SIGMA, TIME, PARTICLES, RUNS = 1.5, 1.0, 0.8, 32.0, 2000, 20
# Temperature and gas constant in OpenMM's units.
KT = SIGMA**2 / (2.0 * GAMMA)
GAS = openmm.unit.MOLAR_GAS_CONSTANT_R.value_in_unit(openmm.unit.kilojoule_per_mole / openmm.unit.kelvin)


def state(h: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities of many particles at the end of a run."""
    system, force = openmm.System(), openmm.CustomExternalForce(f"0.5*{OMEGA**2}*x^2")
    for particle in range(PARTICLES):
        system.addParticle(1.0)
        force.addParticle(particle, [])
    system.addForce(force)
    integrator = openmm.LangevinMiddleIntegrator(KT / GAS, GAMMA, h)
    integrator.setRandomNumberSeed(seed)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(np.zeros((PARTICLES, 3)))
    context.setVelocities(np.zeros((PARTICLES, 3)))
    integrator.step(round(TIME / h))
    found = context.getState(positions=True, velocities=True)
    q, v = (part.value_in_unit(part.unit) for part in (found.getPositions(True), found.getVelocities(True)))
    return q[:, 0], v[:, 0]


def main() -> None:
    """Print each moment with its standard error over the runs, and what theory gives."""
    print(f"OpenMM {openmm.__version__}, kT = {KT:g}, {RUNS} runs of {PARTICLES} particles")
    print("h      moment  found                theory")
    for h in (0.5, 0.25, 0.125):
        moments = []
        for seed in range(1, RUNS + 1):
            q, v = state(h, seed)
            p = v - 0.5 * h * OMEGA**2 * q
            moments.append([np.mean(each) for each in (q * q, v * v, q * v, p * p, q * p)])
        mean, se = np.mean(moments, axis=0), np.std(moments, axis=0, ddof=1) / RUNS**0.5
        theory = (KT / OMEGA**2, KT, 0.5 * h * KT, KT * (1.0 - 0.25 * (h * OMEGA) ** 2), 0.0)
        for name, found, error, known in zip(("q q", "v v", "q v", "p p", "q p"), mean, se, theory, strict=True):
            print(f"{h:<6g} {name:7} {found:8.4f} +- {error:.4f}   {known:8.4f}")


if __name__ == "__main__":
    main()
