"""Coefficients that a program may request during a step, by form, and constants sent with each step."""

from collections.abc import Callable, Mapping
from string import ascii_lowercase
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import (
    SDE,
    Array,
    ConstrainedLangevin,
    DelaySDAE,
    HolonomicSDAE,
    IndexOneSDAE,
    Langevin,
    Problem,
    SchemeError,
)

from .messages import Shape, shape_text


class Form(NamedTuple):
    """A form on the wire.

    Attributes
    ----------
    kind : type
    lengths : callable, problem -> mapping of str to int
        Values of the letters of shapes.
    answers : mapping of str to str
        Coefficients that may be requested, methods of the problem: ``t x:d -> dl`` takes a time and states of shape
        (d, P), and returns an array of shape (d, l, P).
    constants : tuple of str
        Numbers of the problem that are sent with each step.
    """

    kind: type[Problem]
    lengths: Callable[[Any], Mapping[str, int]]
    answers: Mapping[str, str]
    constants: tuple[str, ...] = ()

    @property
    def letters(self) -> frozenset[str]:
        """Letters of the shapes."""
        return frozenset(
            letter for text in self.answers.values() for word in text.split() for letter in _letters(word)
        )


def _letters(word: str) -> str:
    # The letters after the colon in x:d, and the whole word of a result; a time has no letters.
    name, colon, letters = word.partition(":")
    return letters if colon else "" if name in {"t", "->"} else name


def _of_sde(problem: SDE) -> Mapping[str, int]:
    m = len(problem.constraint(problem.initial(1))) if problem.constraint else 0
    return {"d": problem.dimension, "l": problem.noise_dim, "m": m}


def _of_langevin(problem: Langevin) -> Mapping[str, int]:
    return {"n": problem.noise_dim}


def _of_mechanics(problem: HolonomicSDAE) -> Mapping[str, int]:
    return {"n": problem.dimension, "l": problem.noise_dim, "m": problem.constraints}


def _of_delay(problem: DelaySDAE) -> Mapping[str, int]:
    return {"d": problem.dimension, "l": problem.noise_dim, "q": problem.constraints}


def _of_constrained(problem: ConstrainedLangevin) -> Mapping[str, int]:
    return {"d": problem.dimension, "q": problem.constraints}


OF_DELAY = {
    "drift": "t x:d v:d y:q -> d",
    "diffusion": "t x:d v:d y:q -> dl",
    "diffused": "t x:d v:d y:q w:l -> d",
    "constraint": "t x:d v:d y:q -> q",
    "eliminated": "t x:d v:d -> q",
}
FORMS: Mapping[str, Form] = {
    "SDE": Form(
        SDE,
        _of_sde,
        {
            "drift": "t x:d -> d",
            "diffusion": "t x:d -> dl",
            "diffused": "t x:d w:l -> d",
            "derivative_of_drift": "t x:d -> dd",
            "derivative_of_diffusion": "t x:d y:d -> dl",
            "constraint": "x:d -> m",
            "dg": "x:d -> md",
        },
    ),
    "Langevin": Form(Langevin, _of_langevin, {"force": "q:n -> n"}, ("friction", "strength")),
    "HolonomicSDAE": Form(
        HolonomicSDAE,
        _of_mechanics,
        {
            "force": "t r:n v:n -> n",
            "diffusion": "t r:n v:n -> nl",
            "diffused": "t r:n v:n w:l -> n",
            "inverse_mass": "y:n -> n",
            "constraint": "r:n -> m",
            "dg": "r:n -> mn",
            "d2g": "r:n y:n z:n -> m",
        },
    ),
    "ConstrainedLangevin": Form(
        ConstrainedLangevin,
        _of_constrained,
        {"drift": "x:d -> d", "constraint": "x:d -> q", "dg": "x:d -> qd", "traces": "x:d -> q"},
        ("strength", "eps"),
    ),
    "DelaySDAE": Form(DelaySDAE, _of_delay, OF_DELAY, ("delay",)),
    "IndexOneSDAE": Form(IndexOneSDAE, _of_delay, OF_DELAY),
}


class Coefficients:
    """Coefficients of one problem, as requested by a program.

    Parameters
    ----------
    problem : Problem
    forms : tuple of str
        Names of the forms that the program solves.
    asks : frozenset of str
        Coefficients announced in its hello.
    """

    def __init__(self, problem: Any, forms: tuple[str, ...], asks: frozenset[str]) -> None:
        self.problem, self.asks = problem, asks
        # The first matching form, a derived form before its base.
        names = sorted((name for name in forms if isinstance(problem, FORMS[name].kind)), key=list(FORMS).index)
        self.form = FORMS[names[-1]]
        self.lengths = {**self.form.lengths(problem)}

    @property
    def constants(self) -> dict[str, Array]:
        """Constants of the problem, each an array with one number."""
        return {name: np.array([float(getattr(self.problem, name))]) for name in self.form.constants}

    def rows_of(self, memory: str) -> int:
        """Return the number of rows of a memory; ``2d`` is twice the length d."""
        number = memory.rstrip(ascii_lowercase)
        letter = memory[len(number) :]
        return int(number or 1) * (self.lengths[letter] if letter else 1)

    def require(self, name: str, shapes: Mapping[str, Shape]) -> None:
        """Check that a coefficient may be requested with arrays of these shapes.

        Raises
        ------
        SchemeError
            If the coefficient was not announced, or an array has another shape.
        """
        if name not in self.asks or name not in self.form.answers:
            raise SchemeError(f"asks {name!r:.60}, which its hello does not name behind 'asks' for this form")
        given, _, _ = self.form.answers[name].partition(" -> ")
        paths = max(shapes.values(), key=len, default=(1,))[-1]
        expected = dict(self._shape(argument, paths) for argument in given.split())
        if list(expected.items()) != list(shapes.items()):
            told, got = (
                " ".join(f"{key}={shape_text(shape)}" for key, shape in each.items()) for each in (expected, shapes)
            )
            raise SchemeError(f"asks {name} with {got!r:.120}, expected {told!r}")

    def answer(self, name: str, arrays: Mapping[str, Array]) -> Array:
        """Evaluate a coefficient, broadcast to all paths of the request."""
        given = [float(array[0]) if key == "t" else array for key, array in arrays.items()]
        value = getattr(self.problem, name)(*given)
        letters = self.form.answers[name].partition(" -> ")[2]
        paths = max(map(np.shape, arrays.values()), key=len)[-1]
        return np.broadcast_to(np.asarray(value, dtype=float), (*(self.lengths[each] for each in letters), paths))

    def why_too_large(self, most: tuple[tuple[str, int], ...]) -> str:
        """Return which dimension of the problem exceeds the program's limit, or an empty string."""
        for letter, largest in most:
            if (given := self.lengths.get(letter, 0)) > largest:
                return f"it is for {letter} = {largest} at most, and the problem has {letter} = {given}"
        return ""

    def why_not(self) -> str:
        """Return which announced coefficient the problem lacks, or an empty string."""
        for name in sorted(self.asks & {*self.form.answers}):
            missing = getattr(self.problem, name, None) is None
            if missing or (name == "dg" and getattr(self.problem, "constraint", None) is None):
                return f"it asks {name}, which the problem has not"
            why_not = getattr(self.problem, f"why_not_{name}", None)
            if why_not is not None and (reason := why_not()):
                return str(reason)
        return ""

    def _shape(self, argument: str, paths: int) -> tuple[str, Shape]:
        name, _, letters = argument.partition(":")
        return (name, (1,)) if not letters else (name, (*(self.lengths[each] for each in letters), paths))
