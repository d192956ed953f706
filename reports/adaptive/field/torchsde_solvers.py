"""Adaptive solvers of torchsde as a plugin file, on the verifier's path.

`sdaeverify adaptive --plugin reports/adaptive/field/torchsde_solvers.py 'torchsde-*'`

Its error is a norm over the whole batch: rows share their steps, and batches are the unit that is sampled.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, ClassVar

import numpy as np
import torch
import torchsde
from torchsde._core import adaptive_stepping

from sdaeverify import SDE, Claim, hookimpl
from sdaeverify_adaptive import Adaptive, Path, Solved
from sdaeverify_bridges.kit import Coefficients, TorchFunctions, why_not_bridged

torch.set_num_threads(1)
STRATONOVICH = ("heun", "midpoint", "euler_heun")
NO_RATE = "a conjecture: its documentation names no rate in the tolerance"
COMMUTATIVE = frozenset({"commutative-noise"})


class Equation:
    """Drift and diffusion on tensors with paths first."""

    def __init__(self, problem: SDE, calculus: str) -> None:
        kinds = ("additive", "scalar", "diagonal")
        self.sde_type = calculus
        self.noise_type = next((kind for kind in kinds if f"{kind}-noise" in problem.traits), "general")
        self.coefficients = Coefficients(problem, TorchFunctions(torch), calculus == "stratonovich")

    def f(self, t: Any, y: Any) -> Any:
        """Return the drift."""
        return self.coefficients.drift(t, y.T).T

    def g(self, t: Any, y: Any) -> Any:
        """Return the diffusion, of diagonal noise its diagonal."""
        B = self.coefficients.diffusion(t, y.T)
        return torch.einsum("jjp->pj", B) if self.noise_type == "diagonal" else torch.moveaxis(B, -1, 0)


class OnPath(torchsde.BaseBrownian):
    """The verifier's path, whose times are refused that are no ticks; it counts what it was asked."""

    def __init__(self, path: Path) -> None:
        self.path, self.asked = path, 0

    def __call__(self, ta: Any, tb: Any = None, return_U: bool = False, return_A: bool = False) -> Any:
        """Return the increment between two times, the same for all rows."""
        self.asked += 1
        a, b = (self.path.at(np.broadcast_to(self.path.ticks_of(float(t)), (self.path.paths,))) for t in (ta, tb))
        return torch.from_numpy((b.W - a.W).T.copy())

    def __repr__(self) -> str:
        return "OnPath()"

    @property
    def dtype(self) -> Any:
        """Double precision."""
        return torch.float64

    @property
    def device(self) -> Any:
        """Of the processor."""
        return torch.device("cpu")

    @property
    def shape(self) -> tuple[int, int]:
        """Paths and Brownian motions."""
        return (self.path.paths, self.path.dimension)

    @property
    def levy_area_approximation(self) -> str:
        """None."""
        return "none"


@contextmanager
def whole_ticks(tick: float) -> Iterator[None]:
    """Round the steps of torchsde's controller down to an even number of ticks: it halves each of them."""
    own = adaptive_stepping.update_step_size

    def rounded(*given: Any, **named: Any) -> tuple[float, Any]:
        size, ratio = own(*given, **named)
        return max(2, int(float(size) / tick) // 2 * 2) * tick, ratio

    adaptive_stepping.update_step_size = rounded
    try:
        yield
    finally:
        adaptive_stepping.update_step_size = own


@dataclass(frozen=True)
class TorchSDE(Adaptive):
    """A method of torchsde with adaptive=True.

    Attributes
    ----------
    method : str
        Its name.
    scaled : str
        ``rtol``, ``atol`` or ``both``.
    """

    method: str = "heun"
    scaled: str = "both"

    name: ClassVar[str] = "torchsde-adaptive"
    in_batches: ClassVar[bool] = True
    tolerances: ClassVar[tuple[float, ...]] = tuple(2.0**-n for n in (8, 9, 10, 11))
    source: ClassVar[str] = f"torchsde {version('torchsde')}"

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Half an order in the tolerance, and in the mean number of steps."""
        return (
            Claim(measure="tolerance", value=0.5, source=NO_RATE),
            Claim(measure="tolerance-steps", value=0.5, source="documentation of torchsde, steps of one length"),
        )

    def refuses(self, problem: SDE) -> str:
        """Refuse noise of a kind that the method is not for, and formulas that torch cannot run."""
        if self.method == "milstein" and not problem.traits & {"scalar-noise", "diagonal-noise", "additive-noise"}:
            return "the noise is not diagonal"
        return why_not_bridged(problem, stratonovich=self.method in STRATONOVICH)

    def solve(self, problem: SDE, path: Path, tolerance: float) -> Solved:
        """Solve along all rows with common steps."""
        calculus = "stratonovich" if self.method in STRATONOVICH else "ito"
        equation, asked = Equation(problem, calculus), OnPath(path)
        rtol, atol = (tolerance if self.scaled in {name, "both"} else 0.0 for name in ("rtol", "atol"))
        start = torch.from_numpy(problem.initial(path.paths).T.copy())
        times = torch.tensor([0.0, problem.horizon], dtype=torch.float64)
        given = {"method": self.method, "rtol": rtol, "atol": atol, "dt": path.horizon / 8, "dt_min": 2 * path.tick}
        with whole_ticks(path.tick), torch.no_grad():
            ends = torchsde.sdeint(equation, start, times, bm=asked, adaptive=True, **given)
        # A whole step and two halves: a try has cost three.
        return Solved(ends[-1].T.numpy().copy(), max(asked.asked // 3, 1), 0, asked.asked)


@hookimpl
def sdaeverify_adaptive() -> list[Adaptive]:
    """Register what was judged."""
    return [TorchSDE(method) for method in ("heun", "midpoint", "milstein")]
