"""Reports on constrained mechanics: masses, and velocities that a projection forgets."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from _report import Report, pair_of

from sdaeverify import (
    Array,
    Claim,
    ConstraintJacobian,
    HolonomicSDAE,
    HolonomicState,
    Increment,
    Mask,
    Scheme,
    Step,
    hookimpl,
)
from sdaeverify.numerics import newton, norm, update_tolerance

EULER = (
    Claim(measure="strong", value=0.5, source="Lindner & Stroot 2017, section 3"),
    Claim(measure="weak", value=1.0, source="Lindner & Stroot 2017, section 3"),
    Claim(measure="drift", value="round-off", source="Lindner & Stroot 2017, (3.10)"),
)


def onto(problem: HolonomicSDAE, y: Array, old: ConstraintJacobian) -> tuple[Array, Mask]:
    """Return r = y + M^{-1} grad g(r_0) kappa with g(r) = 0, and where Newton's method converged."""

    def equation(kappa: Array) -> tuple[Array, object]:
        r = y + problem.push(old, kappa)
        return problem.constraint(r), problem.linearised(r).gram(old)

    none = np.zeros((problem.constraints, y.shape[1]))
    tolerance = update_tolerance(norm(y)) / old.size()
    root = newton(equation, none, tolerance, solver=lambda A, b: A.solve(b))
    return y + problem.push(old, root.x), root.converged


@dataclass(frozen=True)
class HalfExplicit(Scheme):
    """r+ on the constraint near r + h v, v+ tangential near v + M^{-1} (h a + B dw)."""

    mended: bool = True

    form: ClassVar[type] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def impulse(self, problem: HolonomicSDAE, t: float, state: HolonomicState, h: float, dW: Array) -> Array:
        """Return the change of the velocity without the constraint."""
        r, v, _ = state
        return problem.inverse_mass(h * problem.force(t, r, v) + problem.diffused(t, r, v, dW))

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        old = problem.linearised(r)
        new, found = onto(problem, r + h * v, old)
        x = v + self.impulse(problem, t, state, h, noise.dW)
        J = problem.linearised(new)
        lam = -J.gram(old).solve(J.times(x))
        end = HolonomicState(new, x + problem.push(old, lam), mu + lam)
        kept = (np.where(found, e, s) for e, s in zip(end, state, strict=True))
        return Step(HolonomicState(*kept), ~found)


@dataclass(frozen=True)
class ForceForAcceleration(HalfExplicit):
    """Faulty with the force in the place of the acceleration M^{-1} a."""

    name: ClassVar[str] = "hoomd-2318"

    def impulse(self, problem: HolonomicSDAE, t: float, state: HolonomicState, h: float, dW: Array) -> Array:
        """Return the change of the velocity without the constraint."""
        if self.mended:
            return super().impulse(problem, t, state, h, dW)
        r, v, _ = state
        return h * problem.force(t, r, v) + problem.inverse_mass(problem.diffused(t, r, v, dW))


@dataclass(frozen=True)
class NoiseWithoutMass(HalfExplicit):
    """Faulty with the noise and the force both not divided by the mass."""

    name: ClassVar[str] = "jax-md-145"

    def impulse(self, problem: HolonomicSDAE, t: float, state: HolonomicState, h: float, dW: Array) -> Array:
        """Return the change of the velocity without the constraint."""
        if self.mended:
            return super().impulse(problem, t, state, h, dW)
        r, v, _ = state
        return h * problem.force(t, r, v) + problem.diffused(t, r, v, dW)


@dataclass(frozen=True)
class NoiseDiscarded(HalfExplicit):
    """Faulty with a velocity that is made of the difference of positions: the noise of the step is lost."""

    name: ClassVar[str] = "mlx-atomistic-20"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        if self.mended:
            return super().step(problem, state, t, h, noise)
        r, v, mu = state
        # Positions feel the noise of this step, velocities only what positions have kept of it.
        moved = v + h * problem.inverse_mass(problem.force(t, r, v))
        kick = problem.inverse_mass(problem.diffused(t, r, v, noise.dW))
        new, found = onto(problem, r + h * (moved + kick), problem.linearised(r))
        v_new, lam = problem.tangent(problem.linearised(new), moved)
        end = HolonomicState(new, v_new, mu + lam)
        kept = (np.where(found, e, s) for e, s in zip(end, state, strict=True))
        return Step(HolonomicState(*kept), ~found)


PENDULA = "damped-pendulum,driven-double-pendulum"
REPORTS = (
    Report(
        ForceForAcceleration,
        "https://github.com/glotzerlab/hoomd-blue/pull/2318",
        "A constrained step writes the force where the acceleration belongs.",
        PENDULA,
        ("mass", "M dv"),
    ),
    Report(
        NoiseWithoutMass,
        "https://github.com/jax-md/jax-md/issues/145",
        "The inertial terms do not take the masses into account.",
        PENDULA,
        ("mass", "M dv"),
    ),
    Report(
        NoiseDiscarded,
        "https://github.com/appautomaton/mlx-atomistic/pull/20",
        "The thermal noise of a step is discarded when the final velocity is made.",
        PENDULA,
        ("noise", "dW", "dw"),
    ),
)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the pairs."""
    return [scheme for report in REPORTS for scheme in pair_of(report)]
