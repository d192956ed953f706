"""Examples: records of all numbers of a problem, which generate a plugin file and are built from it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from textwrap import indent
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Self

from sdaeverify import Problem

from .terms import Field, later_fields, sum_text, without

NAME = "counterexample"
HEAD = '''"""A problem that was drawn at random: {told}."""

import numpy as np

from sdaeverify import {form}, hookimpl


def rows(z, *values):
    """Return the values as rows, on as many paths as z has."""
    return np.stack([value + 0.0 * z[0] for value in values])


def counterexample(horizon: float = {horizon}{given}) -> {form}:
    """Return the problem.

    Parameters
    ----------
    horizon : float
        Final time, dimensionless.{explained}
    """
'''
FOOT = '''

@hookimpl
def sdaeverify_problems():
    """Register the problem."""
    return [counterexample]
'''
# Shift of the start for a second examination, not a multiple of any drawn number.
BESIDE = 0.37


# Name of the coefficient with one entry per Brownian motion.
COLUMNS = "columns"


class Drop(NamedTuple):
    """Terms to remove from an example.

    Attributes
    ----------
    name : str
        Name of the coefficient.
    row, place : int or None
        Row and index of the terms; None for all.
    """

    name: str
    row: int | None
    place: int | None


@dataclass(frozen=True)
class Example:
    """Numbers of a problem of a form.

    Attributes
    ----------
    kind : str
        Property of the noise or delay that holds by construction.
    group : str
        Class of the coefficients.
    horizon : float
    start : tuple of float
    """

    form: ClassVar[str]
    # Name in the source of the component that `dimension` counts, and part of the state that is observed.
    state: ClassVar[str] = "x"
    # Traits by kind that hold by construction and are not set by the form.
    traits_of_kinds: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})

    # Attributes that are sums of terms; and attributes of the initial values, by the component of the state.
    sums: ClassVar[tuple[str, ...]] = ()
    begun_by: ClassVar[Mapping[str, str]] = MappingProxyType({"x": "start"})

    kind: str
    group: str
    horizon: float
    start: tuple[float, ...]

    @property
    def told(self) -> str:
        """Form, kind and class in words."""
        return f"{self.form}, {self.kind}, {self.group}"

    @property
    def dimension(self) -> int:
        """Number d of components of the start."""
        return len(self.start)

    @property
    def traits(self) -> tuple[str, ...]:
        """Traits that hold by construction and are not set by the form."""
        return self.traits_of_kinds.get(self.kind, ())

    @property
    def fields(self) -> tuple[Field, ...]:
        """All coefficients; their number of terms measures the size of the example."""
        raise NotImplementedError

    @property
    def terms(self) -> int:
        """Number of terms of all coefficients."""
        return sum(len(field) for field in self.fields)

    @property
    def longest(self) -> int:
        """Number of terms of the longest coefficient."""
        return max(map(len, self.fields), default=0)

    def definitions(self) -> Iterator[str]:
        """Yield the statements that define the names used by `arguments`."""
        raise NotImplementedError

    def arguments(self) -> Iterator[str]:
        """Yield the keyword arguments of the form as Python code."""
        raise NotImplementedError

    def numbers(self) -> Mapping[str, tuple[float, str]]:
        """Return the parameters of the function other than the horizon: default and description by name."""
        return {}

    def doubled(self) -> Self:
        """Return the example with drift and diffusion twice as large."""
        raise NotImplementedError

    def moved(self) -> Self:
        """Return the example with a shifted start."""
        return replace(self, start=tuple(x + BESIDE for x in self.start))

    def begun_at(self, parts: Mapping[str, Sequence[float]], t: float) -> Self:
        """Return the example whose solution starts at time `t` in a state of another solution.

        Parameters
        ----------
        parts : mapping of str to sequence of float
            Components of the state.
        t : float
        """
        begun: dict[str, Any] = {name: tuple(parts[part]) for part, name in self.begun_by.items()}
        return replace(self, **begun, **{name: later_fields(getattr(self, name), t) for name in self.sums})

    def simpler(self) -> Iterator[Drop]:
        """Yield the terms that may be removed: all of a coefficient, all of a row, and single terms."""
        yield from (Drop(name, None, None) for name in self.sums)
        yield from (Drop(name, row, None) for name in self.sums for row in range(len(self._rows(name))))
        for name in self.sums:
            for row, field in enumerate(self._rows(name)):
                yield from (Drop(name, row, place) for place in reversed(range(len(field))))

    def _rows(self, name: str) -> Sequence[Field]:
        rows: Sequence[Field] = getattr(self, name)[0] if name == COLUMNS else getattr(self, name)
        return rows

    def dropped(self, terms: Drop) -> Self:
        """Return the example without some terms.

        The terms are removed from all columns of the noise, so that commuting columns still commute.
        """
        given = getattr(self, terms.name)
        fewer = partial(without, row=terms.row, place=terms.place)
        changed: dict[str, Any] = {terms.name: tuple(map(fewer, given)) if terms.name == COLUMNS else fewer(given)}
        return replace(self, **changed)

    @property
    def source(self) -> str:
        """Text of the plugin file that registers the problem."""
        numbers = self.numbers()
        given = "".join(f", {name}: float = {value}" for name, (value, _) in numbers.items())
        explained = "".join(f"\n    {name} : float\n        {text}" for name, (_, text) in numbers.items())
        head = HEAD.format(told=self.told, form=self.form, horizon=self.horizon, given=given, explained=explained)
        body = [*self.definitions(), f"return {self.form}(", *(f"    {line}," for line in self._lines()), ")"]
        return head + indent("\n".join(body), "    ") + "\n" + FOOT

    def _lines(self) -> Iterator[str]:
        yield from self.arguments()
        yield "horizon=horizon"
        if self.traits:
            yield f"traits=frozenset({sorted(self.traits)})"
        yield f"observables={{{', '.join(self.observables())}}}"
        yield 'source="drawn at random by sdaeverify hunt"'

    def observables(self) -> Iterator[str]:
        """Yield the entries of the observables: the components of the state, and its square."""
        name = self.state
        yield from (f'"{name}_{row + 1}": lambda t, s: s["{name}"][{row}]' for row in range(self.dimension))
        yield f'"|{name}|^2": lambda t, s: (s["{name}"] ** 2).sum(axis=0)'

    def build(self) -> Problem:
        """Build the problem from its plugin file.

        Raises
        ------
        ProblemError
            If the numbers contradict each other.
        """
        problem: Problem = function_of(self.source)()
        return problem


def function_of(source: str) -> Callable[..., Any]:
    """Return the problem function of a plugin file from its text."""
    names: dict[str, Any] = {"__name__": NAME}
    exec(compile(source, f"<{NAME}>", "exec"), names)
    function: Callable[..., Any] = names[NAME]
    return function


def vector_text(name: str, given: str, fields: Sequence[Field], names: Sequence[str]) -> str:
    """Return the definition of a vector-valued function of ``(t, x, ...)``, with one row for each field.

    Parameters
    ----------
    name : str
        Name of the function.
    given : str
        Arguments of the function, with or without a leading ``t``; the first other one determines the number of
        paths.
    fields : sequence of Field
    names : sequence of str
        Python expressions of the components of the fields' arguments.
    """
    first = given.removeprefix("t, ").partition(",")[0]
    values = ", ".join(sum_text(field, names) for field in fields)
    return f"def {name}({given}):\n    return rows({first}, {values})\n"


def matrix_text(name: str, given: str, columns: Sequence[Sequence[Field]], names: Sequence[str]) -> str:
    """Return the definition of a matrix-valued function of ``(t, x, ...)``, one column per sequence of fields.

    Parameters
    ----------
    name : str
        Name of the function.
    given : str
        Arguments of the function, with or without a leading ``t``.
    columns : sequence of sequences of Field
    names : sequence of str
        Python expressions of the components of the fields' arguments.
    """
    first = given.removeprefix("t, ").partition(",")[0]
    stacked = ", ".join(
        f"rows({first}, {', '.join(sum_text(field, names) for field in column)})" for column in columns
    )
    return f"def {name}({given}):\n    return np.stack([{stacked}], axis=1)\n"
