"""Methods of torchsde as schemes: one step is one call of ``torchsde.sdeint`` on all paths at once."""

from dataclasses import dataclass
from typing import Any, ClassVar

from sdaeverify import SDE, Array, Claim, ParameterError, Parts, Scheme, hookimpl
from sdaeverify_bridges.kit import SEPARATE, Bridge, Compiled, Library, why_not_without_areas

from ._reversible import begin_memory

LIBRARY = Library.find("torchsde")
# Strong orders stated by the solver classes for general noise, and the kinds of noise with strong order 1.
ITO: dict[str, tuple[float, tuple[str, ...]]] = {
    "euler": (0.5, ("additive-noise",)),
    "milstein": (1.0, ()),
    "srk": (1.5, ()),
}
STRATONOVICH: dict[str, tuple[float, tuple[str, ...]]] = {
    "euler_heun": (0.5, tuple(sorted(SEPARATE))),
    "log_ode": (0.5, tuple(sorted(SEPARATE))),
    "heun": (0.5, tuple(sorted(SEPARATE))),
    "midpoint": (0.5, tuple(sorted(SEPARATE))),
    "milstein": (1.0, ()),
    "reversible_heun": (0.5, ("additive-noise",)),
}
WEAK = {"srk": 1.5}


@dataclass(frozen=True)
class TorchSDE(Bridge):
    """x(t + h) = torchsde.sdeint(problem, x, [t, t + h], bm, method, dt=h) with the increment as bm.

    Attributes
    ----------
    method : str
    grad_free : bool
        Whether Milstein's method uses a difference in place of the derivative.
    """

    method: str = "euler"
    grad_free: bool = False

    library: ClassVar[Library] = LIBRARY
    batched: ClassVar[bool] = False
    calculus: ClassVar[str]
    known: ClassVar[dict[str, tuple[float, tuple[str, ...]]]]
    source: ClassVar[str] = f"{LIBRARY}; Li, Wong, Chen & Duvenaud 2020"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.grad_free and self.method != "milstein":
            raise ParameterError("grad_free is an option of milstein")

    @property
    def stratonovich(self) -> bool:
        """Whether the method solves Stratonovich equations."""
        return self.calculus == "stratonovich"

    @property
    def noise(self) -> frozenset[str]:  # type: ignore[override]
        """Fields dW and, for ``srk``, H, for ``log_ode``, A."""
        return frozenset({"dW"} | {"srk": {"H"}, "log_ode": {"A"}}.get(self.method, set()))

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Orders stated by the class of the solver."""
        order, better = self.known[self.method]
        source = f"strong_order and weak_order of the solver {self.method} in torchsde"
        higher = (Claim(measure="strong", value=1.0, when=frozenset({kind}), source=source) for kind in better)
        weak = Claim(measure="weak", value=WEAK.get(self.method, 1.0), source=source)
        return Claim(measure="strong", value=order, source=source), *higher, weak

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that the method does not support, and formulas that only NumPy can run."""
        needs_areas = self.method in {"milstein", "srk"}
        return (needs_areas and why_not_without_areas(problem)) or super().refuses(problem)

    def compiled(self, problem: SDE) -> Compiled:
        """Return the method's step for the formulas of a problem."""
        from ._torchsde_step import sde_step  # noqa: PLC0415 - loading PyTorch takes seconds

        options = {"grad_free": self.grad_free} if self.method == "milstein" else {}
        return sde_step(problem, self.calculus, self.method, options)


class TorchSDEIto(TorchSDE):
    """Methods of torchsde for dx = f dt + B dW."""

    name: ClassVar[str] = "torchsde-ito"
    calculus: ClassVar[str] = "ito"
    known: ClassVar[dict[str, tuple[float, tuple[str, ...]]]] = ITO


@dataclass(frozen=True)
class TorchSDEStratonovich(TorchSDE):
    """Methods of torchsde for dx = F dt + B o dW with F = f - (1/2) sum_j DB_j B_j.

    The reversible Heun method has a memory: z, and F and B at z.
    """

    method: str = "midpoint"

    name: ClassVar[str] = "torchsde-stratonovich"
    calculus: ClassVar[str] = "stratonovich"
    known: ClassVar[dict[str, tuple[float, tuple[str, ...]]]] = STRATONOVICH

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Array:
        """Return the problem's state, with the initial memory for the reversible method."""
        return begin_memory(problem, state, t) if self.method == "reversible_heun" else state

    def parts(self, problem: SDE, state: Any) -> Parts:
        """Return the components of the problem without the memory."""
        return problem.parts(state[: problem.dimension])


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register every method that accepts an increment, Milstein's with and without derivatives."""
    LIBRARY.require()
    ito = [*map(TorchSDEIto, ITO), TorchSDEIto("milstein", grad_free=True)]
    return [*ito, *map(TorchSDEStratonovich, STRATONOVICH), TorchSDEStratonovich("milstein", grad_free=True)]
