"""Methods of torchsde as schemes: one step is one call of ``torchsde.sdeint``."""

from dataclasses import dataclass
from importlib.util import find_spec
from typing import ClassVar

from sdaeverify import SDE, Array, Claim, Increment, ParameterError, Scheme, Step, hookimpl

ROESSLER = "Roessler 2010, SRA1 and SRID2, as documented by torchsde"
KLOEDEN_PLATEN = "Kloeden & Platen 1992"
CLAIMS = {
    "euler": (
        Claim(measure="strong", value=0.5, source=f"{KLOEDEN_PLATEN}, Theorem 10.2.2"),
        Claim(measure="weak", value=1.0, source=f"{KLOEDEN_PLATEN}, section 14.1"),
    ),
    "milstein": (
        Claim(measure="strong", value=1.0, source=f"{KLOEDEN_PLATEN}, Theorem 10.3.5; without derivatives, 11.1"),
        Claim(measure="weak", value=1.0, source=f"{KLOEDEN_PLATEN}, section 14.1: Euler's weak order"),
    ),
    "srk": (Claim(measure="strong", value=1.5, source=ROESSLER),),
}
SEPARATE = frozenset({"scalar-noise", "diagonal-noise", "additive-noise"})


@dataclass(frozen=True)
class TorchSDEMethod(Scheme):
    """x(t + h) = torchsde.sdeint(problem, x(t), [t, t + h], bm, method, dt=h), bm being the given increment.

    Where torchsde is not installed, every problem is refused with that reason.

    Attributes
    ----------
    method : str
        ``euler``; ``milstein``, without derivatives; ``srk``: SRA1 for additive noise, else SRID2.
    """

    method: str = "srk"

    name: ClassVar[str] = "torchsde"
    form: ClassVar[type[SDE]] = SDE
    source: ClassVar[str] = "Li, Wong, Chen & Duvenaud 2020; torchsde"

    def __post_init__(self) -> None:
        if self.method not in CLAIMS:
            raise ParameterError(f"method must be {', '.join(CLAIMS)}, got {self.method!r}")

    @property
    def noise(self) -> frozenset[str]:  # type: ignore[override]
        """Fields of the increment the method uses."""
        return frozenset({"dW", "H"} if self.method == "srk" else {"dW"})

    @property
    def promises(self) -> tuple[Claim, ...]:
        """The claims of the method."""
        return CLAIMS[self.method]

    def refuses(self, problem: SDE) -> str:
        """Refuse everything where torchsde is not installed, and noise that the method is not made for."""
        if find_spec("torchsde") is None:
            return "torchsde is not installed; pip install 'sdaeverify-torchsde[torch]'"
        if self.method == "euler" or problem.traits & SEPARATE:
            return ""
        return f"noise in {problem.noise_dim} dimensions is neither scalar nor diagonal nor additive"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        # Listing schemes should not take as long as loading torch.
        from ._equation import solved  # noqa: PLC0415

        return Step(solved(problem, self.method, state, (t, h), noise))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme with each of its methods."""
    return [TorchSDEMethod(), TorchSDEMethod(method="milstein"), TorchSDEMethod(method="euler")]
