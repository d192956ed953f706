"""Ito equations: scalar, diagonal, commutative, additive and general noise."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

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


@dataclass(frozen=True)
class SDEExample(Example):
    """dx = f dt + B dW.

    Attributes
    ----------
    drift : tuple of Field
        f, of t and x.
    columns : tuple of tuples of Field
        Those of B.
    """

    form: ClassVar[str] = "SDE"
    traits_of_kinds: ClassVar[Mapping[str, tuple[str, ...]]] = TRAITS
    sums: ClassVar[tuple[str, ...]] = ("drift", "columns")

    drift: tuple[Field, ...]
    columns: Columns

    @property
    def fields(self) -> tuple[Field, ...]:
        """F and B."""
        return (*self.drift, *(field for column in self.columns for field in column))

    def definitions(self) -> Iterator[str]:
        """Yield f and B."""
        names = indexed("x", self.dimension)
        yield vector_text("drift", "t, x", self.drift, names)
        yield matrix_text("diffusion", "t, x", self.columns, names)

    def arguments(self) -> Iterator[str]:
        """Yield coefficients, start and number of motions."""
        yield from ("drift=drift", "diffusion=diffusion", f"start={list(self.start)}")
        yield f"noise_dim={len(self.columns)}"
        yield 'noise=frozenset({"dW", "H", "K", "A"})'

    def doubled(self) -> "SDEExample":
        """Return the example with 2 f and 2 B."""
        return replace(self, drift=scaled(self.drift, 2.0), columns=scaled_columns(self.columns, 2.0))


@st.composite
def sdes(draw: Any, kinds: tuple[str, ...] = KINDS, groups: tuple[str, ...] = GROUPS, largest: int = 3) -> SDEExample:
    """Draw Ito equations.

    Parameters
    ----------
    draw : callable
        Given by hypothesis.
    kinds, groups : tuple of str
        Kinds of noise and classes of coefficients.
    largest : int
        Number of components, and of Brownian motions.
    """
    kind, group, d = draw(choices(kinds, groups, largest))
    drift = of_group(draw(fields(d, d)), group)
    columns = noise_of_group(draw(_columns(kind, d, largest)), group)
    return SDEExample(kind, group, horizon_of(group), draw(starts(d)), drift, columns)


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
    """Return the columns of a diagonal matrix, each entry a function of its own component."""
    d = len(entries)

    def own(row: int) -> Field:
        return tuple(
            term._replace(wave=tuple(term.wave[0] * k for k in unit(row, d)) if term.wave else ())
            for term in entries[row]
        )

    return tuple(tuple(own(row) if row == column else () for row in range(d)) for column in range(d))
