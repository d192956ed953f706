"""Terms a s(k.z + w t + p) of which coefficients of examples are sums, written as Python expressions."""

from collections.abc import Sequence
from typing import Any, NamedTuple

# Shapes s of a term, with braces for the angle k.z + w t + p.
COS, KINK = "np.cos({})", "np.abs({})"
# Digits of phases that depend on the initial time of an example.
DIGITS = 3
LINE, SQUARE, CUBE, FOURTH = "({})", "({}) ** 2", "({}) ** 3", "({}) ** 4"


class Term(NamedTuple):
    """Function a s(k.z + w t + p) of the arguments z of a coefficient.

    Attributes
    ----------
    size : float
        a.
    wave : tuple of float
        Wave vector k; missing components are 0.
    rate : float
        w.
    phase : float
        p.
    shape : str
        Function s, with braces for its argument.
    """

    size: float
    wave: tuple[float, ...] = ()
    rate: float = 0.0
    phase: float = 0.0
    shape: str = COS

    @property
    def is_constant(self) -> bool:
        """Whether the term depends neither on z nor on time."""
        return not (any(self.wave) or self.rate)

    def times(self, factor: float) -> "Term":
        """Return the term multiplied by a factor."""
        return self._replace(size=factor * self.size)

    def later(self, t: float) -> "Term":
        """Return the term shifted in time, so that time 0 becomes t."""
        return self._replace(phase=round(self.phase + self.rate * t, DIGITS)) if self.rate else self

    def text(self, names: Sequence[str]) -> str:
        """Return the term as a Python expression.

        Parameters
        ----------
        names : sequence of str
            Python expressions of the components of z.
        """
        parts = [(k, name) for k, name in (*zip(self.wave, names, strict=False), (self.rate, "t")) if k]
        words = [name if k == 1.0 else f"{k} * {name}" for k, name in parts]
        if self.phase or not words:
            words.append(str(self.phase))
        return f"{self.size} * {self.shape.format(' + '.join(words))}"


# A scalar coefficient as the terms of its sum; and a matrix of coefficients by columns.
Field = tuple[Term, ...]
Columns = tuple[tuple[Field, ...], ...]
Coefficients = Any


def scaled(fields: Sequence[Field], factor: float) -> tuple[Field, ...]:
    """Multiply coefficients by a factor."""
    return tuple(tuple(term.times(factor) for term in field) for field in fields)


def scaled_columns(columns: Columns, factor: float) -> Columns:
    """Multiply the columns of a matrix by a factor."""
    return tuple(scaled(column, factor) for column in columns)


def later_fields(coefficients: Coefficients, t: float) -> Coefficients:
    """Shift coefficients in time, so that time 0 becomes t."""
    if isinstance(coefficients, Term):
        return coefficients.later(t)
    return tuple(later_fields(each, t) for each in coefficients)


def without(fields: Sequence[Field], row: int | None, place: int | None) -> tuple[Field, ...]:
    """Return coefficients without one or all of their cosine terms; other terms define the class and stay.

    Parameters
    ----------
    fields : sequence of Field
    row : int or None
        Index of the coefficient; None for all.
    place : int or None
        Index of the term; None for all.
    """

    def stays(n: int, m: int, term: Term) -> bool:
        return term.shape != COS or row not in {None, n} or place not in {None, m}

    return tuple(tuple(term for m, term in enumerate(each) if stays(n, m, term)) for n, each in enumerate(fields))


def sum_text(field: Field, names: Sequence[str]) -> str:
    """Return a coefficient as a Python expression.

    Parameters
    ----------
    field : tuple of Term
    names : sequence of str
        Python expressions of the components of its arguments.
    """
    return " + ".join(term.text(names) for term in field if term.size) or "0.0"


def indexed(name: str, count: int) -> list[str]:
    """Return the Python expressions of the components of a vector, ``name[0]`` etc."""
    return [f"{name}[{row}]" for row in range(count)]
