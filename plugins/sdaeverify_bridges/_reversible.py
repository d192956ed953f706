"""The memory of the reversible Heun method: x, the second state z, and drift and diffusion at z."""

import numpy as np

from sdaeverify import SDE, Array
from sdaeverify_bridges.kit import Coefficients


def begin_memory(problem: SDE, x: Array, t: float) -> Array:
    """Return the initial memory x, z = x, F(t, z) and the rows of B(t, z), shape (3 d + d l, P)."""
    equation = Coefficients(problem, np, stratonovich=True)
    B = equation.diffusion(t, x)
    return np.concatenate([x, x, equation.drift(t, x), B.reshape(-1, x.shape[-1])])


def split_memory(problem: SDE, memory: Array) -> tuple[Array, Array, Array, Array]:
    """Split a memory into x, z and F, shape (d, ...), and B, shape (d, l, ...), with any trailing axes."""
    d, l = problem.dimension, problem.noise_dim
    x, z, F = (memory[begin : begin + d] for begin in (0, d, 2 * d))
    return x, z, F, memory[3 * d :].reshape(d, l, *memory.shape[1:])
