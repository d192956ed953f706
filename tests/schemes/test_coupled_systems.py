"""Steps of constrained mechanics as the solution of all of their equations at once, by another solver.

With a full mass matrix, and force and noise that depend on time and velocities.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import root

from facade import ExplicitProjectionEuler, HalfExplicitEuler, ImplicitEulerGGL, SemiImplicitProjectionEuler
from sdaeverify import Array, Increment, Scheme, Step

EPS = np.finfo(float).eps
T, H, PATHS = 0.3, 0.05, 6
PROJECTED = ExplicitProjectionEuler(), SemiImplicitProjectionEuler(), SemiImplicitProjectionEuler("new")


class Path:
    """One path of a body: its state, the values of its functions there, and the defects of steps from there.

    Unknowns are (r, v) and multipliers; `m` is the number of constraints.
    """

    def __init__(self, body: Any, path: int, dW: Array) -> None:
        self.body, self.n, self.m, self.M = body, len(body.mass), len(body.state.mu), body.mass
        self.r, self.v = body.state.r[:, path], body.state.v[:, path]
        self.kick = body.problem.diffusion(T, self.r[:, None], self.v[:, None])[..., 0] @ dW[:, path]

    def force(self, t: float, r: Array, v: Array) -> Array:
        return self.body.problem.force(t, r[:, None], v[:, None])[:, 0]

    def split(self, z: Array) -> list[Array]:
        return np.split(z, np.cumsum([self.n, self.n, *[self.m] * ((len(z) - 2 * self.n) // self.m - 1)]))

    def kept(self, r: Array, v: Array) -> list[Array]:
        """Return the defects of the constraint and of its derivative."""
        return [self.body.constraint(r[:, None])[:, 0], self.body.jacobian(r) @ v]

    def half_explicit(self, z: Array, C_eta: float) -> list[Array]:
        """Return the defects of (3.10) in (r+, v+, kappa, lambda)."""
        (new_r, new_v, kappa, lam), r, v, M = self.split(z), self.r, self.v, self.M
        a, Dg, speed = self.force(T, r, v), self.body.jacobian(r), np.linalg.norm(v)
        eta = min(1.0, C_eta / (H * max(speed, speed**2, np.linalg.norm(a))))
        moved = M @ (new_r - r - eta * H * v) - Dg.T @ kappa
        return [moved, M @ (new_v - v) - eta * H * a - self.kick - Dg.T @ lam, *self.kept(new_r, new_v)]

    def implicit(self, z: Array) -> list[Array]:
        """Return the defects of the implicit scheme in (r, v, h lambda, nu)."""
        (r, v, lam, nu), M = self.split(z), self.M
        Dg = self.body.jacobian(r)
        moved = M @ (r - self.r - H * v) - H * Dg.T @ nu
        return [moved, M @ (v - self.v) - H * self.force(T + H, r, v) - self.kick - Dg.T @ lam, *self.kept(r, v)]

    def projected(self, z: Array, scheme: Scheme) -> list[Array]:
        """Return the defects of a projection-based step in (r+, v+, eta, l^, l)."""
        (new_r, new_v, eta, first, second), r, v, M = self.split(z), self.r, self.v, self.M
        D, new_D = self.body.jacobian(r), self.body.jacobian(new_r)
        impulse, pushed, leading = H * self.force(T + H, new_r, v) + self.kick, D.T @ first, first
        if scheme == PROJECTED[0]:
            impulse = H * self.force(T, r, v) + self.kick
            leading = D @ np.linalg.solve(M, impulse + pushed) + H * self.body.curvature(v, v)
        elif scheme == PROJECTED[1]:
            leading = D @ np.linalg.solve(M, self.kick + pushed)
        moved, turned = M @ (new_r - r - H * v) - new_D.T @ eta, M @ (new_v - v) - impulse - pushed - new_D.T @ second
        return [moved, turned, *self.kept(new_r, new_v), leading]


Defects = Callable[[Path, Array], list[Array]]
HALF, GGL, PROJECTION = ("kappa", "lambda"), ("lambda", "nu"), ("eta",)
SYSTEMS: dict[str, tuple[Scheme, tuple[str, ...], Defects]] = {
    "half-explicit": (HalfExplicitEuler(truncation="none"), HALF, lambda path, z: path.half_explicit(z, np.inf)),
    "truncated": (HalfExplicitEuler(truncation=0.04), HALF, lambda path, z: path.half_explicit(z, 0.04)),
    **{guess: (ImplicitEulerGGL(guess=guess), GGL, lambda path, z: path.implicit(z)) for guess in ("V0", "V1", "V2")},
    **{each.label: (each, PROJECTION, lambda path, z, each=each: path.projected(z, each)) for each in PROJECTED},
}


def unknowns(step: Step, outputs: tuple[str, ...]) -> Array:
    """Return the unknowns that a step tells, shape (k, P): of l^ and l their sum, which is the new multiplier."""
    told = [step.outputs[name] for name in outputs]
    return np.concatenate([step.state.r, step.state.v, *told, *([step.state.mu] if outputs == PROJECTION else [])])


@pytest.mark.sweep
@pytest.mark.parametrize("name", SYSTEMS)
def test_a_step_solves_the_coupled_system(body: Any, name: str) -> None:
    """Positions, velocities and all multipliers are the solution that Powell's method finds."""
    scheme, outputs, defects = SYSTEMS[name]
    dW = np.sqrt(H) * np.random.default_rng(2).standard_normal((2, PATHS))
    state = scheme.enter(body.problem, body.state, T, H)

    step = scheme.prepare(body.problem, H)(state, T, Increment(dW, None))

    assert not np.any(step.failed)
    assert (name == "truncated") == np.any(step.truncated)
    found, several = unknowns(step, outputs), outputs == PROJECTION
    for p in range(PATHS):
        path = Path(body, p, dW)
        start = np.concatenate([path.r, path.v, np.zeros((3 if several else 2) * path.m)])
        solved = root(lambda z, path=path: np.concatenate(defects(path, z)), start, tol=1e-13).x
        size = np.linalg.norm(body.mass, 2) * (1.0 + np.abs(solved).max())
        if several:
            *rest, first, second = path.split(solved)
            solved = np.concatenate([*rest, first + second])
        else:
            # Rounding of the terms, of size max |M| |v|.
            assert (
                np.abs(np.concatenate(defects(path, found[:, p]))).max()
                <= (64 if outputs == GGL else 16) * EPS * size
            )
        # Powell's method stops where its last two iterates, converging superlinearly, agree in 13 digits.
        assert np.abs(solved - found[:, p]).max() <= (1e-12 if several else 1e-11) * size
