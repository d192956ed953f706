"""SDE solvers of diffrax as schemes: one step is one call of ``solver.step``, compiled for all paths at once."""

from dataclasses import dataclass
from typing import Any, ClassVar

from sdaeverify import SDE, Array, Claim, Langevin, Parts, Scheme, hookimpl
from sdaeverify_bridges.kit import Bridge, Compiled, Library, why_not_bridged, why_not_temperature

from ._reversible import begin_memory

LIBRARY = Library.find("diffrax")
TABLE = "documentation of diffrax, SDE solver table"
# Strong and weak orders in that table for general, commutative and additive noise; empty without an entry.
HALF, ONE, HIGH = (0.5, 1.0), (1.0, 1.0), (1.5, 2.0)
Orders = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]
ORDERS: dict[str, Orders] = {
    "Euler": (HALF, HALF, ONE),
    "Heun": (HALF, ONE, ONE),
    "EulerHeun": (HALF, HALF, ONE),
    "ItoMilstein": (HALF, ONE, ONE),
    "StratonovichMilstein": (HALF, ONE, ONE),
    "ReversibleHeun": (HALF, ONE, ONE),
    "Midpoint": (HALF, ONE, ONE),
    "Ralston": (HALF, ONE, ONE),
    "ShARK": ((), (), HIGH),
    "SRA1": ((), (), HIGH),
    "SEA": ((), (), ONE),
    "SPaRK": (HALF, ONE, HIGH),
    "GeneralShARK": (HALF, ONE, HIGH),
    "SlowRK": (HALF, HIGH, HIGH),
}
ITO = frozenset({"Euler", "ItoMilstein"})
WITH_AREAS = frozenset({"ShARK", "SRA1", "SEA", "SPaRK", "GeneralShARK", "SlowRK"})
# Required trait of the problem for each column; empty for general noise.
TRAITS = ("", "commutative-noise", "additive-noise")
LANGEVIN = {"ALIGN": 2.0, "ShOULD": 3.0, "QUICSORT": 3.0}


@dataclass(frozen=True)
class Diffrax(Bridge):
    """x(t + h) = solver.step(MultiTerm(ODETerm(f), ControlTerm(B, path)), t, t + h, x) on the path of the increment.

    Solvers that converge to the Stratonovich solution receive the drift F = f - (1/2) sum_j DB_j B_j.

    Attributes
    ----------
    solver : str
        Name of the class in diffrax.
    """

    solver: str = "Euler"

    name: ClassVar[str] = "diffrax"
    library: ClassVar[Library] = LIBRARY
    known: ClassVar[tuple[str, ...]] = tuple(ORDERS)
    source: ClassVar[str] = f"{LIBRARY}; Kidger 2021, On Neural Differential Equations"

    @property
    def is_reversible(self) -> bool:
        """Whether the solver has a memory: a second state z, with drift and diffusion at z."""
        return self.solver == "ReversibleHeun"

    @property
    def stratonovich(self) -> bool:
        """Whether the solver is an ``AbstractStratonovichSolver``."""
        return self.solver not in ITO

    @property
    def noise(self) -> frozenset[str]:  # type: ignore[override]
        """Fields dW and, if ``minimal_levy_area`` of the solver is space-time, H."""
        return frozenset({"dW", "H"} if self.solver in WITH_AREAS else {"dW"})

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Orders of the table in the documentation."""
        return tuple(claim for row in zip(ORDERS[self.solver], TRAITS, strict=True) for claim in claims(*row))

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that the table excludes, and formulas that only NumPy can run."""
        if not ORDERS[self.solver][0] and "additive-noise" not in problem.traits:
            return "the noise is not declared additive"
        return super().refuses(problem)

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Array:
        """Return the problem's state, with the initial memory for the reversible solver."""
        return begin_memory(problem, state, t) if self.is_reversible else state

    def parts(self, problem: SDE, state: Any) -> Parts:
        """Return the components of the problem without the memory."""
        return problem.parts(state[: problem.dimension])

    def compiled(self, problem: SDE) -> Compiled:
        """Return the solver's step for the formulas of a problem."""
        from ._diffrax_step import reversible_step, sde_step  # noqa: PLC0415 - loading JAX takes seconds

        if self.is_reversible:
            return reversible_step(problem)
        return sde_step(self.solver, problem, stratonovich=self.stratonovich)


@dataclass(frozen=True)
class DiffraxLangevin(Bridge):
    """Solvers of diffrax for underdamped Langevin dynamics, with their terms.

    Attributes
    ----------
    solver : str
        Name of the class in diffrax.
    """

    solver: str = "ALIGN"

    name: ClassVar[str] = "diffrax-langevin"
    form: ClassVar[type[Langevin]] = Langevin
    library: ClassVar[Library] = LIBRARY
    known: ClassVar[tuple[str, ...]] = tuple(LANGEVIN)
    source: ClassVar[str] = f"{LIBRARY}; Foster, Lyons & Oberhauser 2021, The shifted ODE method"

    @property
    def noise(self) -> frozenset[str]:  # type: ignore[override]
        """Fields dW and H, and K if ``minimal_levy_area`` of the solver is space-time-time."""
        return frozenset({"dW", "H"} if self.solver == "ALIGN" else {"dW", "H", "K"})

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Strong order that the solver returns."""
        order = LANGEVIN[self.solver]
        return (Claim(measure="strong", value=order, source=f"diffrax.{self.solver}.strong_order and its docstring"),)

    def refuses(self, problem: Langevin) -> str:
        """Refuse dynamics without friction or noise, and formulas that only NumPy can run."""
        return why_not_temperature(problem) or why_not_bridged(problem.ito())

    def compiled(self, problem: Langevin) -> Compiled:
        """Return the solver's step for the force of a problem."""
        from ._diffrax_step import langevin_step  # noqa: PLC0415 - loading JAX takes seconds

        return langevin_step(self.solver, problem)


def claims(orders: tuple[float, ...], trait: str) -> list[Claim]:
    """Return the claims of a strong and a weak order, for noise with a trait or for all noise."""
    when = frozenset({trait}) if trait else frozenset[str]()
    named: Any = zip(("strong", "weak"), orders, strict=False)
    return [Claim(measure=measure, value=value, when=when, source=TABLE) for measure, value in named]


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register every solver that accepts an increment."""
    LIBRARY.require()
    return [*map(Diffrax, ORDERS), *map(DiffraxLangevin, LANGEVIN)]
