"""Langevin integrators of ASE as schemes, with one atom for each coordinate of each path."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import Claim, Langevin, Scheme, hookimpl
from sdaeverify_bridges.kit import Bridge, Compiled, Library, why_not_temperature

LIBRARY = Library.find("ase")
# Papers of the propagators according to the classes, and the orders that the papers state.
CLAIMS = {
    "Langevin": ("(23) of Vanden-Eijnden & Ciccotti 2006, Second-order integrators", {"weak": 2.0}),
    "LangevinBAOAB": ("Leimkuhler & Matthews 2013", {"weak": 2.0, "invariant": 2.0}),
}


@dataclass(frozen=True)
class ASE(Bridge):
    """One call of ``step`` of an integrator for dq = p dt, dp = (F(q) - gamma p) dt + sigma dW with unit masses.

    Its normal variables are dW/sqrt(h) and, for ``Langevin``, sqrt(12/h) H.

    Attributes
    ----------
    integrator : str
        Name of the class in ``ase.md``.
    """

    integrator: str = "Langevin"

    name: ClassVar[str] = "ase"
    form: ClassVar[type[Langevin]] = Langevin
    library: ClassVar[Library] = LIBRARY
    known: ClassVar[tuple[str, ...]] = tuple(CLAIMS)
    batched: ClassVar[bool] = False
    source: ClassVar[str] = f"{LIBRARY}; Larsen et al. 2017"

    @property
    def noise(self) -> frozenset[str]:  # type: ignore[override]
        """Fields dW and, for ``Langevin``, H."""
        return frozenset({"dW", "H"} if self.integrator == "Langevin" else {"dW"})

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Orders of the paper that the docstring of the class names."""
        paper, orders = CLAIMS[self.integrator]
        source = f"docstring of {self.integrator} in ASE: {paper}"
        return tuple(Claim(measure=measure, value=order, source=source) for measure, order in orders.items())

    def refuses(self, problem: Langevin) -> str:
        """Refuse dynamics without friction or noise."""
        return why_not_temperature(problem)

    def compiled(self, problem: Langevin) -> Compiled:
        """Return the integrator's step for the force of a problem."""
        from ._ase_step import langevin_step  # noqa: PLC0415 - it may be missing

        return langevin_step(self.integrator, problem)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the integrators whose noise has increments."""
    LIBRARY.require()
    return [*map(ASE, CLAIMS)]
