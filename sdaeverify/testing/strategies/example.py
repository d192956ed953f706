"""Examples: records of all numbers of a problem, which write the problem as a plugin file and are built from it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from textwrap import indent
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Self

from ...forms import Problem
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
# Where an example is looked at again: a little beside its own start, to no multiple of anything.
BESIDE = 0.37


# The coefficient of which there is one for each Brownian motion.
COLUMNS = "columns"


class Drop(NamedTuple):
    """Terms that an example may do without.

    Attributes
    ----------
    name : str
        Of a coefficient.
    row, place : int or None
        Of the terms; None for all.
    """

    name: str
    row: int | None
    place: int | None


@dataclass(frozen=True)
class Example:
    """The numbers of a problem of some form.

    Attributes
    ----------
    kind : str
        What of its noise, or of its delay, is so by construction.
    group : str
        The class of its coefficients.
    horizon : float
    start : tuple of float
    """

    form: ClassVar[str]
    # What is counted by `dimension`, as the source calls it, and the part of a state that is observed.
    state: ClassVar[str] = "x"
    # The traits of each kind that hold by construction and are not set by the form.
    traits_of_kinds: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})

    # Attributes made of sums of terms; and what a solution begins with, by the component of a state.
    sums: ClassVar[tuple[str, ...]] = ()
    begun_by: ClassVar[Mapping[str, str]] = MappingProxyType({"x": "start"})

    kind: str
    group: str
    horizon: float
    start: tuple[float, ...]

    @property
    def told(self) -> str:
        """The example in words."""
        return f"{self.form}, {self.kind}, {self.group}"

    @property
    def dimension(self) -> int:
        """Number d of components of the start."""
        return len(self.start)

    @property
    def traits(self) -> tuple[str, ...]:
        """The traits that hold by construction and are not set by the form."""
        return self.traits_of_kinds.get(self.kind, ())

    @property
    def fields(self) -> tuple[Field, ...]:
        """All coefficients: their number of terms says how large the example is."""
        raise NotImplementedError

    @property
    def terms(self) -> int:
        """How many terms all coefficients have."""
        return sum(len(field) for field in self.fields)

    @property
    def longest(self) -> int:
        """How many terms the longest coefficient has."""
        return max(map(len, self.fields), default=0)

    def definitions(self) -> Iterator[str]:
        """Yield the statements of the function, which define what `arguments` names."""
        raise NotImplementedError

    def arguments(self) -> Iterator[str]:
        """Yield the arguments of the form, as Python writes them."""
        raise NotImplementedError

    def numbers(self) -> Mapping[str, tuple[float, str]]:
        """Return the parameters of the function beside the horizon: by name, the default and what it is."""
        return {}

    def doubled(self) -> Self:
        """Return the example with drift and diffusion twice as large."""
        raise NotImplementedError

    def moved(self) -> Self:
        """Return the example with another start."""
        return replace(self, start=tuple(x + BESIDE for x in self.start))

    def begun_at(self, parts: Mapping[str, Sequence[float]], t: float) -> Self:
        """Return the example of a solution that begins where another one is at a time.

        Parameters
        ----------
        parts : mapping of str to sequence of float
            Components of a state.
        t : float
        """
        begun: dict[str, Any] = {name: tuple(parts[part]) for part, name in self.begun_by.items()}
        return replace(self, **begun, **{name: later_fields(getattr(self, name), t) for name in self.sums})

    def simpler(self) -> Iterator[Drop]:
        """Yield which terms may be left out: of a coefficient all, of a row all, and each by itself."""
        yield from (Drop(name, None, None) for name in self.sums)
        yield from (Drop(name, row, None) for name in self.sums for row in range(len(self._rows(name))))
        for name in self.sums:
            for row, field in enumerate(self._rows(name)):
                yield from (Drop(name, row, place) for place in reversed(range(len(field))))

    def _rows(self, name: str) -> Sequence[Field]:
        rows: Sequence[Field] = getattr(self, name)[0] if name == COLUMNS else getattr(self, name)
        return rows

    def dropped(self, terms: Drop) -> Self:
        """Return the example without some terms, in all columns alike: columns that commute still do."""
        given = getattr(self, terms.name)
        fewer = partial(without, row=terms.row, place=terms.place)
        changed: dict[str, Any] = {terms.name: tuple(map(fewer, given)) if terms.name == COLUMNS else fewer(given)}
        return replace(self, **changed)

    @property
    def source(self) -> str:
        """The plugin file that registers the problem."""
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
        name = self.state
        entries = [f'"{name}_{row + 1}": lambda t, s: s["{name}"][{row}]' for row in range(self.dimension)]
        entries.append(f'"|{name}|^2": lambda t, s: (s["{name}"] ** 2).sum(axis=0)')
        yield f"observables={{{', '.join(entries)}}}"
        yield 'source="drawn at random by sdaeverify hunt"'

    def build(self) -> Problem:
        """Return the problem: what the plugin file makes.

        Raises
        ------
        ProblemError
            If the numbers contradict each other.
        """
        problem: Problem = function_of(self.source)()
        return problem


def function_of(source: str) -> Callable[..., Any]:
    """Return the problem function of a plugin file, given its text."""
    names: dict[str, Any] = {"__name__": NAME}
    exec(compile(source, f"<{NAME}>", "exec"), names)
    function: Callable[..., Any] = names[NAME]
    return function


def vector_text(name: str, given: str, fields: Sequence[Field], names: Sequence[str]) -> str:
    """Return the definition of a function of ``(t, x, ...)`` with one row for each field.

    Parameters
    ----------
    name : str
        Of the function.
    given : str
        Its arguments, with the time first or without it; the last but one letter decides nothing.
    fields : sequence of Field
    names : sequence of str
        What the components of the fields' arguments are called.
    """
    first = given.removeprefix("t, ").partition(",")[0]
    values = ", ".join(sum_text(field, names) for field in fields)
    return f"def {name}({given}):\n    return rows({first}, {values})\n"


def matrix_text(name: str, given: str, columns: Sequence[Sequence[Field]], names: Sequence[str]) -> str:
    """Return the definition of a function of ``(t, x, ...)`` with one column for each sequence of fields.

    Parameters
    ----------
    name : str
        Of the function.
    given : str
        Its arguments, with the time first or without it.
    columns : sequence of sequences of Field
    names : sequence of str
        What the components of the fields' arguments are called.
    """
    first = given.removeprefix("t, ").partition(",")[0]
    stacked = ", ".join(
        f"rows({first}, {', '.join(sum_text(field, names) for field in column)})" for column in columns
    )
    return f"def {name}({given}):\n    return np.stack([{stacked}], axis=1)\n"
