"""An equation and its noise as torchsde wants them: paths first, and a Brownian object that knows one step."""

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import torch
import torchsde

from sdaeverify import SDE, Array, Increment

OPTIONS = MappingProxyType({"milstein": MappingProxyType({"grad_free": True})})


def solved(problem: SDE, method: str, x: Array, step: tuple[float, float], noise: Increment) -> Array:
    """Return x one step later, shape (d, P), for a step (t, h)."""
    t, h = step
    bm = OneStep(noise, h)
    # Double precision throughout: h may not be rounded to a float of 32 bits.
    ts = torch.tensor([t, t + h], dtype=torch.float64)
    # A copy: torchsde writes into its options where noise is additive.
    options = dict(OPTIONS.get(method, {}))
    with torch.no_grad():
        path = torchsde.sdeint(Equation(problem), tensor(x), ts, bm=bm, method=method, dt=h, options=options)
    return np.ascontiguousarray(path[-1].numpy().T)


def tensor(x: Array) -> torch.Tensor:
    """Return a copy with the paths first: (d, P) -> (P, d), (d, l, P) -> (P, d, l)."""
    return torch.tensor(np.moveaxis(x, -1, 0), dtype=torch.float64)


def noise_type(problem: SDE) -> str:
    """Return the kind of noise in torchsde's words."""
    kinds = ("additive-noise", "scalar-noise", "diagonal-noise")
    return next((kind.removesuffix("-noise") for kind in kinds if kind in problem.traits), "general")


class Equation:
    """Drift and diffusion of a problem on tensors of shape (P, d)."""

    sde_type = "ito"

    def __init__(self, problem: SDE) -> None:
        self.problem = problem
        self.noise_type = noise_type(problem)

    def f(self, t: torch.Tensor, y: torch.Tensor) -> torch.Tensor:
        """Return the drift, shape (P, d)."""
        x = y.numpy().T
        return tensor(np.broadcast_to(self.problem.drift(float(t), x), x.shape))

    def g(self, t: torch.Tensor, y: torch.Tensor) -> torch.Tensor:
        """Return the diffusion, shape (P, d, l), or its diagonal, shape (P, d)."""
        x = y.numpy().T
        B = self.problem.diffusion(float(t), x)
        B = np.broadcast_to(B, (*B.shape[:2], x.shape[1]))
        return tensor(np.einsum("jjp->jp", B) if self.noise_type == "diagonal" else B)


@dataclass(frozen=True, eq=False, repr=False)
class Path:
    """The numbers of one step."""

    W: torch.Tensor
    U: torch.Tensor | None


class OneStep(torchsde.BaseBrownian):
    """Brownian motion that is known over one step: W, and U, its time integral.

    Parameters
    ----------
    noise : Increment
    h : float
        Length of the step.
    """

    def __init__(self, noise: Increment, h: float) -> None:
        self.path = Path(tensor(noise.dW), None if noise.H is None else tensor(noise.time_integral(h)))

    def __call__(self, ta, tb=None, return_U=False, return_A=False):
        """Return W(tb) - W(ta) and, if asked for, U, for the one step there is."""
        return (self.path.W, self.path.U) if return_U else self.path.W

    def __repr__(self) -> str:
        return "OneStep()"

    @property
    def dtype(self) -> torch.dtype:
        """Double precision."""
        return self.path.W.dtype

    @property
    def device(self) -> torch.device:
        """Where the numbers are."""
        return self.path.W.device

    @property
    def shape(self) -> torch.Size:
        """Paths and Brownian motions."""
        return self.path.W.shape

    @property
    def levy_area_approximation(self) -> str:
        """What is known beyond W."""
        return "none" if self.path.U is None else "space-time"
