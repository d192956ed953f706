"""Algorithms of sdeint as schemes: one step is one function call, with rows of paths in place of numbers."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, ParameterError, Scheme, hookimpl
from sdaeverify_bridges.kit import Bridge, Coefficients, Compiled, Library, why_not_without_areas

LIBRARY = Library.find("sdeint")
# Strong orders stated in README and docstrings. stratKP2iS is left out: a two-step method restarted in each call.
ORDERS = {"itoEuler": None, "itoSRI2": 1.0, "stratHeun": None, "stratSRS2": 1.0}
TWICE = frozenset({"itoSRI2", "stratSRS2"})


@dataclass(frozen=True)
class SDEInt(Bridge):
    """x(t + h) = sdeint.algorithm(f, B, x, [t, t + h], dW=dW, I=I)[-1] with the double integrals I of the step.

    sdeint computes one path at a time. Each component passed to it is an object that holds a row of all paths.

    Attributes
    ----------
    algorithm : str
        Name of the function.
    areas : bool
        Whether itoSRI2 and stratSRS2 receive Levy areas. Without areas, they are restricted to noise that needs none.
    """

    algorithm: str = "itoEuler"
    areas: bool = False

    name: ClassVar[str] = "sdeint"
    library: ClassVar[Library] = LIBRARY
    known: ClassVar[tuple[str, ...]] = tuple(ORDERS)
    batched: ClassVar[bool] = False
    source: ClassVar[str] = f"{LIBRARY}; Roessler 2010; Ruemelin 1982"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.areas and self.algorithm not in TWICE:
            raise ParameterError(f"areas are for {' and '.join(sorted(TWICE))}")

    @property
    def stratonovich(self) -> bool:
        """Whether the algorithm solves Stratonovich equations."""
        return self.algorithm.startswith("strat")

    @property
    def noise(self) -> frozenset[str]:  # type: ignore[override]
        """Fields dW and, on request, A."""
        return frozenset({"dW", "A"} if self.areas else {"dW"})

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Strong order stated by sdeint, if any."""
        order, source = ORDERS[self.algorithm], f"README of sdeint and docstring of {self.algorithm}"
        return (Claim(measure="strong", value=order, source=source),) if order else ()

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that needs missing areas, and formulas that only NumPy can run."""
        needs_areas = self.algorithm in TWICE and not self.areas
        return (needs_areas and why_not_without_areas(problem)) or super().refuses(problem)

    def compiled(self, problem: SDE) -> Compiled:
        """Return the algorithm's step for the formulas of a problem."""
        import sdeint  # noqa: PLC0415 - it may be missing

        algorithm, equation = getattr(sdeint, self.algorithm), Coefficients(problem, np, self.stratonovich)
        f, B = (lambda y, t, of=of: rows(of(t, np.stack(y))) for of in (equation.drift, equation.diffusion))

        def step(x: Array, t: float, h: float, dW: Array, A: Array | None = None) -> Array:
            given = {"dW": rows(dW)[None]}
            if self.algorithm in TWICE:
                none = np.zeros((problem.noise_dim * (problem.noise_dim - 1) // 2, dW.shape[1]))
                integrals = Increment(dW, None, A=none if A is None else A).double_integrals(h)
                if self.stratonovich:
                    integrals = integrals + 0.5 * h * np.eye(problem.noise_dim)[..., None]
                given["J" if self.stratonovich else "I"] = rows(integrals)[None]
            return np.stack(algorithm(f, B, rows(x), np.array([t, t + h]), **given)[-1])

        return step


def rows(x: Array) -> Any:
    """Convert x of shape (k, ..., P) to an object array of shape (k, ...) whose entries have shape (P,)."""
    entries = np.empty(x.shape[:-1], dtype=object)
    for index in np.ndindex(entries.shape):
        entries[index] = x[index]
    return entries


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register every algorithm that accepts an increment, with and without areas if it supports them."""
    LIBRARY.require()
    return [*map(SDEInt, ORDERS), *(SDEInt(algorithm, areas=True) for algorithm in sorted(TWICE))]
