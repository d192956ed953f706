"""Base of schemes that delegate each step to a solver of another library."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import fields
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from sdaeverify import SDE, Array, Increment, ParameterError, Problem, Scheme, Step

from .batches import in_batches
from .coefficients import why_not_bridged
from .formulas import Formulas
from .installed import Library

# Function of x, t, h and the fields of the increment that the scheme declares.
Compiled = Callable[..., Any]


class Bridge(Scheme):
    """A solver of another library as a scheme; a subclass names the solver and compiles one step of it.

    The library receives the problem's formulas and the increment that all schemes receive. Its solver is neither
    copied nor changed.

    Attributes
    ----------
    library : Library
    stratonovich : bool
        Whether the solver converges to the Stratonovich solution, so that it receives the Stratonovich drift.
    known : collection of str
        Permitted values of the first parameter, for example names of solvers; empty for no restriction.
    batched : bool
        Whether paths are passed in batches of one size, for a step compiled for that shape; otherwise all at once.
    """

    form: ClassVar[type[Problem] | tuple[type[Problem], ...]] = SDE
    # On request only, so that a run of everything does not depend on the installed libraries.
    on_request: ClassVar[bool] = True
    library: ClassVar[Library]
    batched: ClassVar[bool] = True
    known: ClassVar[Collection[str]] = ()

    def __post_init__(self) -> None:
        for name, known in self.choices.items():
            if getattr(self, name) not in known:
                raise ParameterError(f"{name} must be one of {', '.join(known)}, got {getattr(self, name)!r}")

    @property
    def choices(self) -> Mapping[str, Collection[str]]:
        """Permitted values of the first parameter."""
        return {fields(self)[0].name: self.known} if self.known else {}

    @property
    def claimant(self) -> str:
        """Name of the library, whose documentation makes the claims."""
        return self.library.name

    @property
    def stratonovich(self) -> bool:
        """Whether the solver is for Stratonovich equations."""
        return False

    @property
    def drawn(self) -> tuple[str, ...]:
        """Fields of the increment passed to a compiled step, in order."""
        return tuple(name for name in Increment._fields if name in self.noise)

    def refuses(self, problem: Any) -> str:
        """Refuse formulas that only NumPy can run."""
        return why_not_bridged(problem, stratonovich=self.stratonovich)

    def compiled(self, problem: Any) -> Compiled:
        """Return the solver's step for the formulas of a problem: (x, t, h, *noise) -> x, with paths last.

        The method is called once for all problems with the same formulas and for all step sizes.
        """
        raise NotImplementedError

    def prepare(self, problem: Any, h: float) -> Callable[[Any, float, Increment], Step]:
        """Return the step for one problem and step size."""
        compiled = compile_once(self, Formulas(problem))

        def stepper(state: Any, t: float, noise: Increment) -> Step:
            # A single Brownian motion has no areas, even if they are declared.
            given = noise if noise.A is not None else noise._replace(A=np.zeros((0, noise.dW.shape[-1])))
            numbers = (state, *(getattr(given, name) for name in self.drawn))
            whole = in_batches if self.batched else _at_once
            return Step(whole(lambda x, *drawn: compiled(x, t, h, *drawn), numbers))

        return stepper

    def step(self, problem: Any, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        return self.prepare(problem, h)(state, t, noise)


def _at_once(step: Callable[..., Any], arrays: tuple[Array, ...]) -> Array:
    return np.asarray(step(*arrays))


@lru_cache(maxsize=256)
def compile_once(bridge: Bridge, formulas: Formulas) -> Compiled:
    """Return the compiled step of a bridge, cached for all problems with the same formulas."""
    return bridge.compiled(formulas.problem)
