"""Terms a cos(k.z + w t + p) and their like: coefficients of examples are sums of them, which Python can read."""

from collections.abc import Sequence
from typing import Any, NamedTuple

# How the angle k.z + w t + p enters.
COS, KINK = "np.cos({})", "np.abs({})"
# To so many digits phases are kept that depend on when an example begins.
DIGITS = 3
LINE, SQUARE, CUBE, FOURTH = "({})", "({}) ** 2", "({}) ** 3", "({}) ** 4"


class Term(NamedTuple):
    """The function a s(k.z + w t + p) of the arguments z of a coefficient.

    Attributes
    ----------
    size : float
        a.
    wave : tuple of float
        k; further components are 0.
    rate : float
        w.
    phase : float
        p.
    shape : str
        s, with braces for its argument.
    """

    size: float
    wave: tuple[float, ...] = ()
    rate: float = 0.0
    phase: float = 0.0
    shape: str = COS

    @property
    def is_constant(self) -> bool:
        """Whether it depends neither on z nor on time."""
        return not (any(self.wave) or self.rate)

    def times(self, factor: float) -> "Term":
        """Return the multiple of the function."""
        return self._replace(size=factor * self.size)

    def later(self, t: float) -> "Term":
        """Return the function of the time that has passed since t."""
        return self._replace(phase=round(self.phase + self.rate * t, DIGITS)) if self.rate else self

    def text(self, names: Sequence[str]) -> str:
        """Return the function as an expression of Python.

        Parameters
        ----------
        names : sequence of str
            What the components of z are called.
        """
        parts = [(k, name) for k, name in (*zip(self.wave, names, strict=False), (self.rate, "t")) if k]
        words = [name if k == 1.0 else f"{k} * {name}" for k, name in parts]
        if self.phase or not words:
            words.append(str(self.phase))
        return f"{self.size} * {self.shape.format(' + '.join(words))}"


# A scalar coefficient: the sum of its terms; and a matrix of them, column by column.
Field = tuple[Term, ...]
Columns = tuple[tuple[Field, ...], ...]
Coefficients = Any


def scaled(fields: Sequence[Field], factor: float) -> tuple[Field, ...]:
    """Return the multiples of some coefficients."""
    return tuple(tuple(term.times(factor) for term in field) for field in fields)


def scaled_columns(columns: Columns, factor: float) -> Columns:
    """Return the multiples of the columns of a matrix."""
    return tuple(scaled(column, factor) for column in columns)


def later_fields(coefficients: Coefficients, t: float) -> Coefficients:
    """Return coefficients as functions of the time that has passed since t."""
    if isinstance(coefficients, Term):
        return coefficients.later(t)
    return tuple(later_fields(each, t) for each in coefficients)


def without(fields: Sequence[Field], row: int | None, place: int | None) -> tuple[Field, ...]:
    """Return coefficients without a term a cos(k.z + w t + p), or all of them; others make them what they are.

    Parameters
    ----------
    fields : sequence of Field
    row : int or None
        Of the coefficient; None for all.
    place : int or None
        Of the term; None for all.
    """

    def stays(n: int, m: int, term: Term) -> bool:
        return term.shape != COS or row not in {None, n} or place not in {None, m}

    return tuple(tuple(term for m, term in enumerate(each) if stays(n, m, term)) for n, each in enumerate(fields))


def sum_text(field: Field, names: Sequence[str]) -> str:
    """Return a coefficient as an expression of Python.

    Parameters
    ----------
    field : tuple of Term
    names : sequence of str
        What the components of its arguments are called.
    """
    return " + ".join(term.text(names) for term in field if term.size) or "0.0"


def indexed(name: str, count: int) -> list[str]:
    """Return what the components of a vector are called."""
    return [f"{name}[{row}]" for row in range(count)]
