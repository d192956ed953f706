"""Equations and increments in the layout of torchsde, with paths first."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
import torch
import torchsde

from sdaeverify import SDE, Array
from sdaeverify.numerics import antisymmetric
from sdaeverify_bridges.kit import Coefficients, Compiled, TorchFunctions

from ._reversible import split_memory


def noise_type(problem: SDE) -> str:
    """Return the noise type of a problem in the terms of torchsde."""
    kinds = ("additive-noise", "scalar-noise", "diagonal-noise")
    return next((kind.removesuffix("-noise") for kind in kinds if kind in problem.traits), "general")


class Equation:
    """Drift and diffusion of a problem on tensors of shape (P, d).

    Parameters
    ----------
    problem : SDE
    calculus : str
        ``ito`` or ``stratonovich``.
    """

    def __init__(self, problem: SDE, calculus: str) -> None:
        self.sde_type, self.noise_type = calculus, noise_type(problem)
        self.coefficients = Coefficients(problem, TorchFunctions(torch), calculus == "stratonovich")

    def f(self, t: torch.Tensor, y: torch.Tensor) -> torch.Tensor:
        """Return the drift, shape (P, d)."""
        return self.coefficients.drift(t, y.T).T

    def g(self, t: torch.Tensor, y: torch.Tensor) -> torch.Tensor:
        """Return the diffusion, shape (P, d, l), or its diagonal, shape (P, d)."""
        B = self.coefficients.diffusion(t, y.T)
        return torch.einsum("jjp->pj", B) if self.noise_type == "diagonal" else torch.moveaxis(B, -1, 0)


class KnownStep(torchsde.BaseBrownian):
    """Brownian motion with a given increment over one step, regardless of the requested times.

    Parameters
    ----------
    W : Tensor, shape (P, l)
    U : Tensor, shape (P, l), or None
        Time integral of the motion; None if not given.
    A : Tensor, shape (P, l, l), or None
        Levy areas; None if not given.
    """

    def __init__(self, W: torch.Tensor, U: torch.Tensor | None = None, A: torch.Tensor | None = None) -> None:
        self.W, self.U, self.A = W, U, A

    def __call__(self, ta: Any, tb: Any = None, return_U: bool = False, return_A: bool = False) -> Any:
        """Return W(tb) - W(ta) over the step and, if requested, U or A."""
        asked = [part for part, wanted in ((self.U, return_U), (self.A, return_A)) if wanted]
        return (self.W, *asked) if asked else self.W

    def __repr__(self) -> str:
        return "KnownStep()"

    @property
    def dtype(self) -> torch.dtype:
        """Double precision."""
        return self.W.dtype

    @property
    def device(self) -> torch.device:
        """Device of the tensors."""
        return self.W.device

    @property
    def shape(self) -> torch.Size:
        """Numbers of paths and of Brownian motions."""
        return self.W.shape

    @property
    def levy_area_approximation(self) -> str:
        """Name of the information beyond W."""
        if self.A is not None:
            # The name that lets a solver request areas, although these are not an approximation of that kind.
            return "foster"
        return "none" if self.U is None else "space-time"


def sde_step(problem: SDE, calculus: str, method: str, options: dict[str, Any]) -> Compiled:
    """Return the step of a method of ``torchsde.sdeint``."""
    equation = Equation(problem, calculus)

    def path_of(h: float, dW: Array, more: Array | None) -> KnownStep:
        if more is None:
            return KnownStep(first(dW))
        if method == "log_ode":
            return KnownStep(first(dW), A=first(antisymmetric(more, len(dW))))
        return KnownStep(first(dW), first(h * (more + 0.5 * dW)))

    def step(x: Array, t: float, h: float, dW: Array, more: Array | None = None) -> Array:
        path = path_of(h, dW, more)
        ts = torch.tensor([t, t + h], dtype=torch.float64)
        with torch.no_grad(), one_thread():
            solved = partial(torchsde.sdeint, equation, ts=ts, bm=path, method=method, dt=h, options=options)
            if method == "reversible_heun":
                return reversible(problem, solved, x)
            return last(solved(first(x))[-1])

    return step


@contextmanager
def one_thread() -> Iterator[None]:
    """Restrict PyTorch to one thread, because workers share the cores.

    PyTorch is imported after the general limit of threads is set.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


def reversible(problem: SDE, solved: Callable[..., Any], memory: Array) -> Array:
    """Make a step of the reversible Heun method, whose memory is an argument and a result of ``sdeint``."""
    x, z, F, B = split_memory(problem, memory)
    is_diagonal = noise_type(problem) == "diagonal"
    B = np.einsum("jjp->jp", B) if is_diagonal else B
    ys, (F_1, B_1, z_1) = solved(first(x), extra=True, extra_solver_state=(first(F), first(B), first(z)))
    B_1 = torch.diag_embed(B_1) if is_diagonal else B_1
    return np.concatenate([last(part) for part in (ys[-1], z_1, F_1, B_1.flatten(1))])


def first(x: Array) -> torch.Tensor:
    """Return a copy with the paths first, (..., P) -> (P, ...)."""
    return torch.tensor(np.moveaxis(x, -1, 0), dtype=torch.float64)


def last(y: torch.Tensor) -> Array:
    """Return an array with the paths last, (P, k) -> (k, P)."""
    return np.ascontiguousarray(y.numpy().T)
