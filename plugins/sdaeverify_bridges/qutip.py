"""Stochastic integrators of QuTiP as schemes for linear equations: one step is one call of a stepper."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sdaeverify import SDE, Array, Claim, Scheme, hookimpl
from sdaeverify_bridges.kit import (
    Bridge,
    Compiled,
    Library,
    linear_equation,
    why_not_linear_equation,
    why_not_without_areas,
)

LIBRARY = Library.find("qutip")
# Strong and, if stated, weak orders in the docstrings of the integrators.
ORDERS: dict[str, tuple[float, ...]] = {
    "euler": (0.5,),
    "pred_corr": (0.5, 1.0),
    "platen": (1.0, 2.0),
    "milstein": (1.0,),
    "milstein_imp": (1.0,),
    "explicit1.5": (1.5,),
    "taylor1.5": (1.5,),
    "taylor1.5_imp": (1.5,),
}
HIGH = frozenset({"explicit1.5", "taylor1.5", "taylor1.5_imp"})
# Number of columns of a batch of states with equal noise, fixed so that rounding does not depend on the position.
COLUMNS = 16


@dataclass(frozen=True)
class QuTiP(Bridge):
    """A step for dx = (A x + a) dt + sum_j (B_j x + b_j) dW_j, passed to QuTiP as a linear system for (x, 1).

    QuTiP steps all paths with equal noise at once. Its second normal variable is sqrt(12) H.

    Attributes
    ----------
    method : str
        Name of the method of ``SMESolver``; the method rouchon is only for density matrices.
    """

    method: str = "euler"

    name: ClassVar[str] = "qutip"
    library: ClassVar[Library] = LIBRARY
    known: ClassVar[tuple[str, ...]] = tuple(ORDERS)
    batched: ClassVar[bool] = False
    source: ClassVar[str] = f"{LIBRARY}; Kloeden & Platen 1992; Breuer & Petruccione 2002"

    @property
    def noise(self) -> frozenset[str]:  # type: ignore[override]
        """Fields dW and, for methods of order 1.5, H."""
        return frozenset({"dW", "H"} if self.method in HIGH else {"dW"})

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Orders stated by the integrator."""
        source = f"docstring of the integrator {self.method} in qutip.solver.sode"
        named = zip(("strong", "weak"), ORDERS[self.method], strict=False)
        return tuple(Claim(measure=measure, value=value, source=source) for measure, value in named)

    def refuses(self, problem: SDE) -> str:
        """Refuse equations that are not linear with constant coefficients.

        All methods except Euler also refuse noise that needs areas.
        """
        if self.method != "euler" and (reason := why_not_without_areas(problem)):
            return reason
        return why_not_linear_equation(problem)

    def compiled(self, problem: SDE) -> Compiled:
        """Return the method's step for the matrices of a problem."""
        from qutip import Qobj, QobjEvo  # noqa: PLC0415 - it may be missing
        from qutip.core.data import Dense  # noqa: PLC0415
        from qutip.solver.sode.ssystem import SimpleStochasticSystem  # noqa: PLC0415
        from qutip.solver.stochastic import SMESolver  # noqa: PLC0415

        linear = linear_equation(problem)
        A, *B = (QobjEvo(Qobj(matrix)) for matrix in (linear.drift, *np.moveaxis(linear.diffusion, -1, 0)))
        run = SMESolver.avail_integrators()[self.method].stepper(SimpleStochasticSystem(1j * A, B)).run

        def step(x: Array, t: float, h: float, dW: Array, H: Array | None = None) -> Array:
            numbers = np.stack([dW] if H is None else [dW, np.sqrt(12.0) * H])
            paths = equal_columns(numbers.reshape(-1, x.shape[1]))
            states = np.concatenate([x, np.ones((1, x.shape[1]))]).astype(complex).T[paths]
            noises = np.moveaxis(numbers[None, ..., paths[:, 0]], -1, 0).copy()
            ends, found = np.empty(x.shape), zip(states, noises, strict=True)
            whole = [run(t, Dense(state.T), h, noise, 1).to_array()[:-1].real for state, noise in found]
            ends[:, paths] = np.stack(whole, axis=1)
            return ends

        return step


def equal_columns(numbers: Array) -> NDArray[np.intp]:
    """Group equal columns of an array: indices of shape (groups, 16), padded with the last of each group."""
    order = np.lexsort(numbers)
    differ = (numbers[:, order[1:]] != numbers[:, order[:-1]]).any(axis=0)
    begins = np.flatnonzero(np.concatenate([[True], differ]))
    ends = np.append(begins[1:], len(order))
    pieces = -(-(ends - begins) // COLUMNS)
    place = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    firsts = np.repeat(begins, pieces) + COLUMNS * place
    return order[np.minimum(firsts[:, None] + np.arange(COLUMNS), np.repeat(ends, pieces)[:, None] - 1)]


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register every method for linear equations."""
    LIBRARY.require()
    return [*map(QuTiP, ORDERS)]
