"""Stochastic solvers of tinydiffeq as schemes, for SDEs and for SDAEs of index 1."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from sdaeverify import SDE, Claim, DelaySDAE, DelayState, Increment, Scheme, Step, hookimpl
from sdaeverify_bridges.kit import Bridge, Compiled, Foreign, Library, why_not_run

LIBRARY = Library.find("tinydiffeq")
# Strong orders stated in the docstrings of the solvers.
ORDERS = {"EulerMaruyama": 0.5, "Milstein": 1.0, "SRA1": 1.5}


@dataclass(frozen=True)
class TinyDiffEq(Bridge):
    """x(t + h) = solve_sde(f, B, solver, t, t + h, x, n_steps=1, noise=increment), for diagonal noise.

    Attributes
    ----------
    solver : str
        Name of the class in tinydiffeq.
    """

    solver: str = "EulerMaruyama"

    name: ClassVar[str] = "tinydiffeq"
    library: ClassVar[Library] = LIBRARY
    known: ClassVar[tuple[str, ...]] = tuple(ORDERS)
    source: ClassVar[str] = f"{LIBRARY}; Roessler 2010"

    @property
    def noise(self) -> frozenset[str]:  # type: ignore[override]
        """Fields dW and, for ``SRA1``, H."""
        return frozenset({"dW", "H"} if self.solver == "SRA1" else {"dW"})

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Strong order of the solver."""
        source = f"docstring of {self.solver} in tinydiffeq"
        return (Claim(measure="strong", value=ORDERS[self.solver], source=source),)

    def refuses(self, problem: Any) -> str:
        """Refuse noise that is not diagonal or, for ``SRA1``, not additive, and formulas that only NumPy can run."""
        if "diagonal-noise" not in problem.traits:
            return "the noise is not declared diagonal"
        if self.solver == "SRA1" and "additive-noise" not in problem.traits:
            return "the noise is not declared additive"
        return super().refuses(problem)

    def compiled(self, problem: SDE) -> Compiled:
        """Return the solver's step for the formulas of a problem."""
        from ._tinydiffeq_step import sde_step  # noqa: PLC0415 - loading JAX takes seconds

        return sde_step(self.solver, problem)


class TinyDiffEqSDAE(TinyDiffEq):
    """Euler's method of solve_semi_explicit_sdae for dx = f(t, x, y) dt + g(t, x, y) dW, 0 = u(t, x, y).

    A path on which the root solver fails keeps its state and is counted as failed.
    """

    name: ClassVar[str] = "tinydiffeq-sdae"
    form: ClassVar[type[DelaySDAE]] = DelaySDAE
    known: ClassVar[tuple[str, ...]] = ("EulerMaruyama",)

    def refuses(self, problem: DelaySDAE) -> str:
        """Refuse delays, problems without y, and several components or Brownian motions."""
        if problem.delay or not problem.constraints:
            return "it has a delay" if problem.delay else "it has no algebraic components"
        if not problem.dimension == problem.noise_dim == 1:
            return "the noise is not that of one component"
        formulas = {"drift": problem.drift, "diffusion": problem.diffusion, "u": problem.constraint}
        t, x, y = (Foreign(value, np) for value in (np.float64(0.0), *problem.initial(1)))
        return why_not_run(formulas, t, x, x, y)

    def compiled(self, problem: DelaySDAE) -> Compiled:
        """Return the solver's step for the formulas of a problem, with a last row that is 1 if y was solved for."""
        from ._tinydiffeq_step import sdae_step  # noqa: PLC0415 - loading JAX takes seconds

        return sdae_step(problem)

    def prepare(self, problem: DelaySDAE, h: float) -> Callable[..., Step]:
        """Return the step for one problem and step size."""
        whole, d = super().prepare(problem, h), problem.dimension

        def stepper(state: DelayState, t: float, noise: Increment) -> Step:
            found = whole(np.concatenate(state), t, noise).state
            failed = found[-1] != 1.0
            x, y = (np.where(failed, *pair) for pair in ((state.x, found[:d]), (state.y, found[d:-1])))
            return Step(DelayState(x, y), failed)

        return stepper


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the solvers for SDEs and SDAEs."""
    LIBRARY.require()
    return [*map(TinyDiffEq, ORDERS), TinyDiffEqSDAE()]
