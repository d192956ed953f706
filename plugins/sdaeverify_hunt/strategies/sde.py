"""Strategies for Ito equations with scalar, diagonal, commutative, additive and general noise."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any, ClassVar, NamedTuple

from hypothesis import strategies as st

from .draws import (
    GROUPS,
    SIZES,
    choices,
    constants,
    fields,
    horizon_of,
    noise_of_group,
    of_group,
    starts,
    unit,
)
from .example import Example, matrix_text, vector_text
from .terms import Columns, Field, indexed, scaled, scaled_columns

SCALAR, DIAGONAL, COMMUTATIVE, ADDITIVE, GENERAL = KINDS = (
    "scalar",
    "diagonal",
    "commutative",
    "additive",
    "general",
)
TRAITS = {DIAGONAL: ("diagonal-noise",), ADDITIVE: ("additive-noise",)}
# Class of examples in other units, with coefficients of any other class.
OTHER_UNITS = "other units"
SUITABLE = (*GROUPS, OTHER_UNITS)


class Units(NamedTuple):
    """Other units of state and time: y = scale x + shift as a function of s = time t."""

    scale: float = 1.0
    shift: float = 0.0
    time: float = 1.0


PLAIN = Units()
# Simpler units come first. Examples: metres in nanometres, days in seconds, a temperature in kelvins.
SOME_UNITS = (
    *(Units(scale=scale) for scale in (-7.0, 1e3, 1e-3, 1e8, 1e-8)),
    *(Units(time=time) for time in (30.0, 250.0, 1e6, 1e-6)),
    *(Units(shift=shift) for shift in (-40.0, 300.0, 1e4)),
    *(Units(1e3, 1e5), Units(1.0, 1e3, 1e4), Units(1e-3, 0.0, 1e3)),
)


@dataclass(frozen=True)
class SDEExample(Example):
    """Ito equation dx = f dt + B dW, in any units.

    Attributes
    ----------
    drift : tuple of Field
        f, of t and x.
    columns : tuple of tuples of Field
        Columns of B.
    units : Units
        Units of the problem; all numbers except the horizon refer to t and x.
    """

    form: ClassVar[str] = "SDE"
    traits_of_kinds: ClassVar[Mapping[str, tuple[str, ...]]] = TRAITS
    sums: ClassVar[tuple[str, ...]] = ("drift", "columns")

    drift: tuple[Field, ...]
    columns: Columns
    units: Units = PLAIN

    @property
    def fields(self) -> tuple[Field, ...]:
        """Coefficients f and B."""
        return (*self.drift, *(field for column in self.columns for field in column))

    def definitions(self) -> Iterator[str]:
        """Yield the definitions of f and B."""
        names = indexed("x", self.dimension)
        yield vector_text("drift", "t, x", self.drift, names)
        yield matrix_text("diffusion", "t, x", self.columns, names)
        if self.units != PLAIN:
            scale, shift, time = self.units
            inner = f"s / {time}, (y - {shift}) / {scale}"
            yield f"def changed_drift(s, y):\n    return {scale / time} * drift({inner})\n"
            yield f"def changed_diffusion(s, y):\n    return {scale / sqrt(time)} * diffusion({inner})\n"

    def arguments(self) -> Iterator[str]:
        """Yield coefficients, start and number of Brownian motions."""
        scale, shift, _ = self.units
        start, changed = [scale * x + shift for x in self.start], "changed_" if self.units != PLAIN else ""
        yield from (f"drift={changed}drift", f"diffusion={changed}diffusion", f"start={start}")
        yield f"noise_dim={len(self.columns)}"
        yield 'noise=frozenset({"dW", "H", "K", "A"})'

    def begun_at(self, parts: Mapping[str, Sequence[float]], t: float) -> "SDEExample":
        """Return the example that starts at time `t` in a state of another solution, both in the example's units.

        Parameters
        ----------
        parts : mapping of str to sequence of float
            Components of the state.
        t : float
        """
        scale, shift, time = self.units
        old = {name: tuple((y - shift) / scale for y in part) for name, part in parts.items()}
        return super().begun_at(old, t / time)

    def doubled(self) -> "SDEExample":
        """Return the example with 2 f and 2 B."""
        return replace(self, drift=scaled(self.drift, 2.0), columns=scaled_columns(self.columns, 2.0))


@st.composite
def sdes(
    draw: Any, kinds: tuple[str, ...] = KINDS, groups: tuple[str, ...] = SUITABLE, largest: int = 3
) -> SDEExample:
    """Draw Ito equations.

    Parameters
    ----------
    draw : callable
        Draw function of hypothesis.
    kinds, groups : tuple of str
        Kinds of noise and classes of coefficients; with *other units*, coefficients are drawn from another class.
    largest : int
        Largest number of components, and of Brownian motions.
    """
    kind, group, d = draw(choices(kinds, groups, largest))
    changed = group == OTHER_UNITS
    units, of = (draw(st.sampled_from(SOME_UNITS)), draw(st.sampled_from(GROUPS))) if changed else (PLAIN, group)
    drift = of_group(draw(fields(d, d)), of)
    columns = noise_of_group(draw(_columns(kind, d, largest)), of)
    return SDEExample(kind, group, units.time * horizon_of(of), draw(starts(d)), drift, columns, units)


def _columns(kind: str, d: int, largest: int) -> st.SearchStrategy[Any]:
    if kind == DIAGONAL:
        return fields(d, 1).map(_diagonal)
    if kind == SCALAR:
        return st.tuples(fields(d, d))
    motions = st.integers(1 if kind == ADDITIVE else 2, max(largest, 2))
    if kind == COMMUTATIVE:
        # B_j = c_j b: columns along one field commute.
        factors = motions.flatmap(lambda l: st.tuples(*[st.sampled_from(SIZES)] * l))
        return st.builds(lambda b, c: tuple(scaled(b, factor) for factor in c), fields(d, d), factors)
    one = constants(d) if kind == ADDITIVE else fields(d, d)
    return motions.flatmap(lambda l: st.tuples(*[one] * l))


def _diagonal(entries: tuple[Field, ...]) -> Columns:
    """Return the columns of a diagonal matrix, in which entry i depends on component i only."""
    d = len(entries)

    def own(row: int) -> Field:
        return tuple(
            term._replace(wave=tuple(term.wave[0] * k for k in unit(row, d)) if term.wave else ())
            for term in entries[row]
        )

    return tuple(tuple(own(row) if row == column else () for row in range(d)) for column in range(d))
