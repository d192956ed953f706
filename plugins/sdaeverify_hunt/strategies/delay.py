"""Strategies for equations of index 1, with and without delay."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from hypothesis import strategies as st

from .draws import (
    DISSIPATIVE,
    GROWING,
    LIPSCHITZ,
    SMALL_NOISE,
    WAVES,
    choices,
    constants,
    fields,
    noise_of_group,
    numbers,
    of_group,
    starts,
    terms,
)
from .example import Example, matrix_text, vector_text
from .terms import Columns, Field, Term, indexed, scaled, scaled_columns, sum_text

ADDITIVE, DELAYED, GENERAL = "additive", "delayed noise", "general"
INDEX_ONE_KINDS, DELAY_KINDS = (GENERAL, ADDITIVE), (GENERAL, DELAYED, ADDITIVE)
TRAITS = {ADDITIVE: ("additive-noise",), DELAYED: ("delayed-noise",)}
SUITABLE = (LIPSCHITZ, DISSIPATIVE, GROWING, SMALL_NOISE)
# Delays that are multiples of all step sizes, and delays that are multiples of none.
DELAYS = (0.5, 0.25, 0.3, 0.37, 0.7)
# Horizon in delays, so that steps lie within the first delay and long after it.
LATE = 3.0
# Sizes of terms; G_y is a sum of at most two of them.
SHARE = (0.25, -0.25)


@dataclass(frozen=True)
class IndexOneExample(Example):
    """dx = f(t, x, y) dt + g(t, x, y) dW, 0 = G(t, x, y) - y with |G_y| <= 1/2.

    Attributes
    ----------
    drift : tuple of Field
        f, of t and of all other arguments stacked.
    columns : tuple of tuples of Field
        Columns of g.
    algebraic : tuple of Field
        G.
    """

    form: ClassVar[str] = "IndexOneSDAE"
    traits_of_kinds: ClassVar[Mapping[str, tuple[str, ...]]] = TRAITS
    sums: ClassVar[tuple[str, ...]] = ("drift", "columns", "algebraic")
    given: ClassVar[str] = "t, x, y"

    drift: tuple[Field, ...]
    columns: Columns
    algebraic: tuple[Field, ...]

    @property
    def fields(self) -> tuple[Field, ...]:
        """Coefficients f, g and G."""
        return (*self.drift, *(field for column in self.columns for field in column), *self.algebraic)

    @property
    def names(self) -> list[str]:
        """Python expressions of the components of all arguments."""
        return [*indexed("x", self.dimension), *indexed("y", len(self.algebraic))]

    def definitions(self) -> Iterator[str]:
        """Yield the definitions of f, g and G - y."""
        yield vector_text("drift", self.given, self.drift, self.names)
        yield matrix_text("diffusion", self.given, self.columns, self.names)
        if self.algebraic:
            solved = [f"{sum_text(field, self.names)} - y[{row}]" for row, field in enumerate(self.algebraic)]
            yield f"def constraint({self.given}):\n    return rows(x, {', '.join(solved)})\n"

    def arguments(self) -> Iterator[str]:
        """Yield coefficients, start and dimensions."""
        yield from ("drift=drift", "diffusion=diffusion", f"noise_dim={len(self.columns)}")
        yield from self.begin()
        if self.algebraic:
            yield from ("constraint=constraint", f"algebraic={len(self.algebraic)}")

    def begin(self) -> Iterator[str]:
        """Yield the arguments for the initial state."""
        yield f"start={list(self.start)}"

    def doubled(self) -> "IndexOneExample":
        """Return the example with 2 f and 2 g."""
        return replace(self, drift=scaled(self.drift, 2.0), columns=scaled_columns(self.columns, 2.0))


@dataclass(frozen=True)
class DelayExample(IndexOneExample):
    """Delay equation with v(t) = x(t - tau): f, g and G depend on t, x, v and y.

    Attributes
    ----------
    delay : float
        tau.
    slope : float
        x = start + slope sin t on [-tau, 0].
    """

    form: ClassVar[str] = "DelaySDAE"
    given: ClassVar[str] = "t, x, v, y"

    delay: float
    slope: float

    @property
    def names(self) -> list[str]:
        """Python expressions of the components of all arguments."""
        d, q = self.dimension, len(self.algebraic)
        return [*indexed("x", d), *indexed("v", d), *indexed("y", q)]

    def begin(self) -> Iterator[str]:
        """Yield the arguments for delay and history."""
        yield f"delay={self.delay}"
        yield f"history=lambda t: np.array({list(self.start)}) + {self.slope} * np.sin(t)"


def _columns(kind: str, d: int, q: int, past: int) -> st.SearchStrategy[Any]:
    if kind == ADDITIVE:
        one = constants(d)
    elif kind == DELAYED:
        one = fields(d, past).map(lambda found: tuple(_behind(field, d) for field in found))
    else:
        one = fields(d, d + past + q)
    return st.integers(1, 2).flatmap(lambda l: st.tuples(*[one] * l))


def _behind(field: Field, d: int) -> Field:
    """Rewrite a function of v as a function of (x, v, y)."""
    return tuple(term._replace(wave=(0.0,) * d + term.wave) for term in field)


def _algebraic(before: int, q: int) -> st.SearchStrategy[tuple[Field, ...]]:
    """Draw G with at most two terms per row, each of which depends on at most one component of y."""

    @st.composite
    def term(draw: Any) -> Term:
        one: Term
        one, row = draw(terms(before, sizes=SHARE)), draw(st.integers(0, q))
        of_y = tuple(float(row == other + 1) for other in range(q))
        return one._replace(wave=(*one.wave, *of_y))

    return st.tuples(*[st.lists(term(), max_size=2).map(tuple)] * q)


@st.composite
def index_ones(
    draw: Any, kinds: tuple[str, ...] = INDEX_ONE_KINDS, groups: tuple[str, ...] = SUITABLE, largest: int = 2
) -> IndexOneExample:
    """Draw equations of index 1.

    Parameters
    ----------
    draw : callable
        Draw function of hypothesis.
    kinds, groups : tuple of str
        Kinds and classes to draw from.
    largest : int
        Largest number of components of the state, and of y.
    """
    kind, group, drift, columns, algebraic, start = draw(_common(kinds, groups, largest, past=False))
    return IndexOneExample(kind, group, 1.0, start, drift, columns, algebraic)


@st.composite
def delays(
    draw: Any, kinds: tuple[str, ...] = DELAY_KINDS, groups: tuple[str, ...] = SUITABLE, largest: int = 2
) -> DelayExample:
    """Draw delay equations.

    Parameters
    ----------
    draw : callable
        Draw function of hypothesis.
    kinds, groups : tuple of str
        Kinds and classes to draw from.
    largest : int
        Largest number of components of the state, and of y.
    """
    kind, group, drift, columns, algebraic, start = draw(_common(kinds, groups, largest, past=True))
    delay, (slope,) = draw(st.sampled_from(DELAYS)), draw(numbers(WAVES, 1))
    horizon = 1.0 if draw(st.booleans()) else LATE * delay
    return DelayExample(kind, group, horizon, start, drift, columns, algebraic, delay, slope)


@st.composite
def _common(draw: Any, kinds: Sequence[str], groups: Sequence[str], largest: int, *, past: bool) -> Any:
    kind, group, d = draw(choices(kinds, groups, largest))
    q, lagged = draw(st.integers(0, largest) if past else st.integers(1, largest)), d if past else 0
    drift = of_group(draw(fields(d, d + lagged + q)), group)
    columns = noise_of_group(draw(_columns(kind, d, q, lagged)), group)
    return kind, group, drift, columns, draw(_algebraic(d + lagged, q)), draw(starts(d))
