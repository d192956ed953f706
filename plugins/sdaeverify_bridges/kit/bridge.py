"""The base of schemes that hand each step to a solver of another library."""

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

# Of x, t, h and the fields of the increment that the scheme declares.
Compiled = Callable[..., Any]


class Bridge(Scheme):
    """A solver of another library as a scheme: a subclass says what it is called there and compiles one step of it.

    The library is given the problem's own formulas and the increment that all schemes are given. Its solver is
    neither copied nor changed.

    Attributes
    ----------
    library : Library
    stratonovich : bool
        Whether the solver converges to the Stratonovich solution: it is given that drift then.
    known : collection of str
        What the first parameter of the scheme may be, the library's name of a solver for example; all if it is empty.
    batched : bool
        Whether paths come in batches of one size, for a step that is compiled for it; else as many as there are.
    """

    form: ClassVar[type[Problem] | tuple[type[Problem], ...]] = SDE
    # What a run of everything contains shall not depend on which other libraries are installed.
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
        """What is known, of the first parameter."""
        return {fields(self)[0].name: self.known} if self.known else {}

    @property
    def claimant(self) -> str:
        """The library: the claims are those of its documentation."""
        return self.library.name

    @property
    def stratonovich(self) -> bool:
        """Whether the solver is for Stratonovich equations."""
        return False

    @property
    def drawn(self) -> tuple[str, ...]:
        """Fields of the increment that a compiled step is given, in their order there."""
        return tuple(name for name in Increment._fields if name in self.noise)

    def refuses(self, problem: Any) -> str:
        """Refuse formulas that only NumPy can run."""
        return why_not_bridged(problem, stratonovich=self.stratonovich)

    def compiled(self, problem: Any) -> Compiled:
        """Return the solver's step for the formulas of a problem: (x, t, h, *noise) -> x, of paths last.

        It is called once for all problems with the same formulas and all step sizes.
        """
        raise NotImplementedError

    def prepare(self, problem: Any, h: float) -> Callable[[Any, float, Increment], Step]:
        """Return the step for one problem and step size."""
        compiled = compile_once(self, Formulas(problem))

        def stepper(state: Any, t: float, noise: Increment) -> Step:
            # One Brownian motion has no areas, whether or not they are drawn.
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
    """Return the compiled step of a bridge, the same one for all problems with the same formulas."""
    return bridge.compiled(formulas.problem)
