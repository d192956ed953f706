"""Notes and norms of the experiments on fibres."""

import numpy as np

from sdaeverify import Array, Parts, Problem
from sdaeverify_lab.papers import Note

A, B, B_SEMI = "implicit-euler-ggl", "explicit-projection-euler", "semi-implicit-projection-euler"
NAMES = {A: "(A)", B: "(B)", B_SEMI: "(B')"}


def fibre_label(**parameters: object) -> str:
    """Return the label of a clamped fibre."""
    return f"fibre-clamped[{','.join(f'{name}={value}' for name, value in parameters.items())}]"


def positions(problem: Problem, t: float, parts: Parts) -> Array:
    """Return r, shape (n, P)."""
    return parts["r"]


def velocities(problem: Problem, t: float, parts: Parts) -> Array:
    """Return v, shape (n, P)."""
    return parts["v"]


FINAL = (Note("r", positions), Note("v", velocities))


def edges(r: Array, d: int = 2) -> Array:
    """Return r_i - r_{i-1} of a clamped fibre, vertical at the origin, shape (N, d, P)."""
    points = r.reshape(-1, d, *r.shape[1:])
    ds = spacing(len(points))
    root = np.zeros_like(points[:1])
    root[:, 1] = -0.5 * ds
    return np.diff(np.concatenate([root, points]), axis=0)


def differences(v: Array, d: int = 2) -> Array:
    """Return v_i - v_{i-1} of a clamped fibre, shape (N, d, P)."""
    points = v.reshape(-1, d, *v.shape[1:])
    return np.diff(np.concatenate([np.zeros_like(points[:1]), points]), axis=0)


def spacing(N: int) -> float:
    """Return ds of a clamped fibre of N points."""
    return 1.0 / (N + 1)


def norm(z: Array, N: int) -> Array:
    """Return (sum_i |z_i|^2 ds)^{1/2}, shape (P,)."""
    return np.sqrt(spacing(N) * (z * z).sum(axis=0))
