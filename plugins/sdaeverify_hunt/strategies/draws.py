"""Strategies common to all forms: terms, coefficients, starts and classes of drifts. Requires hypothesis."""

from collections.abc import Sequence

from hypothesis import strategies as st

from .terms import CUBE, KINK, LINE, Columns, Field, Term, scaled_columns

# Simpler values come first, because shrinking moves to the left.
SIZES = (0.5, 1.0, -0.5, -1.0, 0.75, -0.75, 0.25, 1.25)
WAVES = (0.0, 1.0, -1.0, 0.5, 2.0, -1.5)
RATES = (0.0, 1.0, 2.0, -1.5)
PHASES = (0.0, 0.5, 1.0, -1.0, 2.0, -2.5)
STARTS = (0.5, 0.0, 1.0, -0.75, 1.5, -2.0)
TERMS = 3
LIPSCHITZ, DISSIPATIVE, GROWING, KINKED, SMALL_NOISE, LONG = GROUPS = (
    "globally Lipschitz",
    "dissipative",
    "not globally Lipschitz",
    "kinked",
    "small noise",
    "long horizon",
)
# Factor of small noise, and long horizon.
SMALL, LATE = 2.0**-5, 8.0


def numbers(values: Sequence[float], count: int) -> st.SearchStrategy[tuple[float, ...]]:
    """Draw tuples of `count` elements of `values`."""
    return st.tuples(*[st.sampled_from(values)] * count)


def terms(arguments: int, *, timed: bool = True, sizes: Sequence[float] = SIZES) -> st.SearchStrategy[Term]:
    """Draw terms a cos(k.z + w t + p).

    Parameters
    ----------
    arguments : int
        Number of components of z.
    timed : bool
        Whether terms may depend on time.
    sizes : sequence of float
        Values of a to draw from.
    """
    rates = st.sampled_from(RATES) if timed else st.just(0.0)
    return st.tuples(st.sampled_from(sizes), numbers(WAVES, arguments), rates, st.sampled_from(PHASES)).map(_term)


def _term(drawn: tuple[float, tuple[float, ...], float, float]) -> Term:
    return Term(*drawn)


def fields(count: int, arguments: int, *, timed: bool = True) -> st.SearchStrategy[tuple[Field, ...]]:
    """Draw `count` coefficients of at most three terms.

    Parameters
    ----------
    count : int
    arguments : int
        Number of components of the argument.
    timed : bool
        Whether coefficients may depend on time.
    """
    one = st.lists(terms(arguments, timed=timed), max_size=TERMS).map(tuple)
    return st.tuples(*[one] * count)


def constants(count: int) -> st.SearchStrategy[tuple[Field, ...]]:
    """Draw `count` constant coefficients."""
    return st.tuples(*[st.lists(terms(0, timed=False), max_size=1).map(tuple)] * count)


def choices(
    kinds: Sequence[str], groups: Sequence[str], largest: int, *, least: int = 1
) -> st.SearchStrategy[tuple[str, str, int]]:
    """Draw a kind, a class and a number of components.

    Parameters
    ----------
    kinds, groups : sequence of str
        Kinds and classes to draw from.
    largest, least : int
        Range of the number of components; `least` if it exceeds `largest`.
    """
    return st.tuples(st.sampled_from(kinds), st.sampled_from(groups), st.integers(least, max(least, largest)))


def starts(dimension: int) -> st.SearchStrategy[tuple[float, ...]]:
    """Draw initial states with the given number of components."""
    return numbers(STARTS, dimension)


def unit(row: int, count: int) -> tuple[float, ...]:
    """Return the unit vector with `count` components whose entry `row` is 1."""
    return tuple(float(row == other) for other in range(count))


def of_group(drift: Sequence[Field], group: str) -> tuple[Field, ...]:
    """Return a drift of a class, made from a globally Lipschitz drift by one more term in each row.

    Parameters
    ----------
    drift : sequence of Field
    group : str
        Name of the class, an element of `GROUPS`.
    """
    n = len(drift)
    more = {
        DISSIPATIVE: [Term(-1.0, unit(row, n), shape=LINE) for row in range(n)],
        GROWING: [Term(-0.25, unit(row, n), shape=CUBE) for row in range(n)],
        KINKED: [Term(0.5, unit(row, n), phase=-0.25, shape=KINK) for row in range(n)],
    }
    return (
        tuple((*field, term) for field, term in zip(drift, more[group], strict=True)) if group in more else (*drift,)
    )


def noise_of_group(columns: Columns, group: str) -> Columns:
    """Return the columns of a diffusion for a class: scaled by `SMALL` for small noise."""
    return scaled_columns(columns, SMALL) if group == SMALL_NOISE else columns


def horizon_of(group: str) -> float:
    """Return the final time of an example of a class."""
    return LATE if group == LONG else 1.0
