"""The strong study in torchsde: its Euler scheme on its Brownian interval, all paths in one batch."""

from collections.abc import Callable
from typing import Any

import torch
import torchsde

from benchmarks.study import GRID, STEPS, X_0, A, B, Means, means


class Growth:
    """Geometric Brownian motion as torchsde wants it."""

    noise_type = "diagonal"
    sde_type = "ito"

    def f(self, t: torch.Tensor, x: torch.Tensor) -> torch.Tensor:
        """Return the drift."""
        return A * x

    def g(self, t: torch.Tensor, x: torch.Tensor) -> torch.Tensor:
        """Return the diffusion."""
        return B * x


def prepared(paths: int, options: dict[str, Any]) -> Callable[[], Means]:
    """Return the study in double precision on one thread, with options for the Brownian interval."""
    torch.set_num_threads(1)
    return lambda: means(_errors(paths, options).numpy())


@torch.no_grad()
def _errors(paths: int, options: dict[str, Any]) -> torch.Tensor:
    x = torch.full((paths, 1), X_0, dtype=torch.float64)
    ts = torch.tensor([0.0, *GRID], dtype=torch.float64)
    interval = torchsde.BrownianInterval(0.0, 1.0, size=x.shape, dtype=x.dtype, entropy=1, **options)
    W = torch.stack([interval(0.0, t) for t in GRID])
    exact = X_0 * torch.exp((A - 0.5 * B * B) * ts[1:, None, None] + B * W)
    solutions = (torchsde.sdeint(Growth(), x, ts, bm=interval, method="euler", dt=1.0 / n)[1:] for n in STEPS)
    return torch.stack([(solution - exact).abs().amax(dim=(0, 2)) for solution in solutions])
