"""Constrained leapfrog and geodesic integrators of mici as splitting steps for constrained Langevin dynamics."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, HolonomicSDAE, HolonomicState, Increment, ParameterError, Scheme, Step, hookimpl
from sdaeverify_bridges.kit import Bridge, Library

LIBRARY = Library.find("mici")
SOURCE = "documentation of mici, ConstrainedLeapfrogIntegrator"
RELATIVE = 1e-9


@dataclass(frozen=True)
class Mici(Bridge):
    """Splitting step: half a step of mici's integrator, friction and noise, half a step of mici's integrator.

    For dr = v dt, M dv = (F(r) - gamma M v) dt + B(r) dW + grad g dmu, the integrator solves the motion with F and
    the constraint alone. With p = M v and mici's projection P(r) onto the cotangent space,

        p <- P(r) { e^{-gamma h} p + s B(r) dW },    s^2 h = (1 - e^{-2 gamma h})/(2 gamma),

    solves the rest in law. mici computes one path at a time, and does not return mu. A path without a root, or
    without a reversible one, keeps its state and is counted as failed.

    Attributes
    ----------
    inner : int
        Number of moves along the manifold in each half; more than one give the geodesic integrator.
    """

    inner: int = 1

    name: ClassVar[str] = "mici"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    library: ClassVar[Library] = LIBRARY
    # The statement of mici on its integrator applies to a symmetric composition with an exact flow.
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=2.0, source=f"{SOURCE}: symmetric and of second order"),
        Claim(measure="drift", value="round-off", source=f"{SOURCE}: preserves the constraints but for rounding"),
    )
    source: ClassVar[str] = f"{LIBRARY}; Reich 1996; Leimkuhler & Matthews 2016"

    def __post_init__(self) -> None:
        if self.inner < 1:
            raise ParameterError(f"inner must be at least 1, got {self.inner!r}")

    def refuses(self, problem: HolonomicSDAE) -> str:
        """Refuse infinite masses, forces other than F(r) - gamma M v, and noise that depends on more than r."""
        if problem.mass is not None and not np.isfinite(problem.mass).all():
            return "a mass is infinite"
        return "" if friction(problem) is not None else "it is no force F(r) - gamma M v with noise B(r) dW"

    def enter(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float) -> HolonomicState:
        """Return the state without mu."""
        return state._replace(mu=state.mu[:0])

    def prepare(self, problem: HolonomicSDAE, h: float) -> Callable[..., Step]:
        """Return the step for one problem and step size."""
        from ._mici_step import half_step  # noqa: PLC0415 - it may be missing

        gamma, half = friction(problem) or 0.0, half_step(problem, 0.5 * h, self.inner)
        decay, s = np.exp(-gamma * h), np.sqrt(-np.expm1(-2.0 * gamma * h) / (2.0 * gamma * h)) if gamma else 1.0

        def stepper(state: HolonomicState, t: float, noise: Increment) -> Step:
            r, v, found = half(state.r, state.v)
            impulse = problem.inverse_mass(s * problem.diffused(t, r, 0.0 * v, noise.dW))
            r, v, found_too = half(r, decay * v + impulse)
            failed = ~(found & found_too)
            r, v = (np.where(failed, *pair) for pair in ((state.r, r), (state.v, v)))
            return Step(HolonomicState(r, v, state.mu), failed)

        return stepper


def friction(problem: HolonomicSDAE) -> float | None:
    """Return gamma of a force F(r) - gamma M v with noise that depends on r alone, or None.

    The form is tested at a few states.
    """
    n, T = problem.dimension, problem.horizon
    r, v, _ = problem.initial(4)
    r, v = r + 0.1 * np.sin(np.arange(4.0 * n).reshape(n, 4)), v + np.cos(np.arange(4.0 * n).reshape(n, 4))

    def accelerations(t: float, v: Array) -> tuple[Array, Array]:
        a, B = problem.force(t, r, v), problem.diffusion(t, r, v)
        return problem.inverse_mass(np.broadcast_to(a, r.shape)), np.broadcast_to(B, (*B.shape[:2], 4))

    (rest, B), (moving, B_moving), (later, B_later) = (
        accelerations(t, speed) for t, speed in ((0.0, 0.0 * v), (0.0, v), (T, v))
    )
    gamma = float(((rest - moving) * v).sum() / (v * v).sum())
    pairs = ((rest - moving, gamma * v), (later, moving), (B_moving, B), (B_later, B))
    return gamma if all(np.allclose(*pair, rtol=RELATIVE, atol=RELATIVE) for pair in pairs) else None


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the leapfrog integrator and the geodesic one."""
    LIBRARY.require()
    return [Mici(), Mici(inner=3)]
