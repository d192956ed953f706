"""What is wrong with a parameter of a problem or an argument of a builder, in one line."""

from collections.abc import Callable, Iterable
from functools import wraps
from math import inf
from numbers import Integral, Real
from typing import Any, TypeVar

from sdaeverify import HolonomicSDAE, ParameterError, ProblemError, SdaeverifyError

Builder = TypeVar("Builder", bound=Callable[..., HolonomicSDAE])


def number(name: str, value: object) -> float:
    """Return a real number as a float; NaN and infinities are left to who knows the range.

    Raises
    ------
    ParameterError
        If it is none, or too large for a float.
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise ParameterError(f"{name} must be a number, got {_format_value(value)}")
    try:
        return float(value)
    except OverflowError:
        raise ParameterError(f"{name} must be a number of at most 1e308, got a longer one") from None


def count(name: str, value: object, least: int, most: int) -> None:
    """Check a whole number.

    Raises
    ------
    ParameterError
        If it is none, or out of its range.
    """
    if not isinstance(value, Integral) or isinstance(value, bool) or not least <= value <= most:
        raise ParameterError(f"{name} must be a whole number from {least} to {most}, got {_format_value(value)}")


def instance(name: str, value: object, kind: type) -> None:
    """Check what something is.

    Raises
    ------
    ParameterError
        If it is something else.
    """
    if not isinstance(value, kind):
        raise ParameterError(f"{name} must be a {kind.__name__}, got {_format_value(value)}")


def function(name: str, value: object) -> None:
    """Check that something can be called.

    Raises
    ------
    ParameterError
        If it cannot.
    """
    if not callable(value):
        raise ParameterError(f"{name} must be a function, got {_format_value(value)}")


def check_positive(**values: float) -> None:
    """Check parameters that are divided by.

    Raises
    ------
    ParameterError
        Naming the first that is not positive and finite.
    """
    for name, value in values.items():
        if not 0.0 < value < inf:
            raise ParameterError(f"{name} must be positive and finite, got {value!r}")


def check_not_negative(**values: float) -> None:
    """Check parameters that may be 0.

    Raises
    ------
    ParameterError
        Naming the first that is negative or not finite.
    """
    for name, value in values.items():
        if not 0.0 <= value < inf:
            raise ParameterError(f"{name} must be finite and not negative, got {value!r}")


def check_least(least: float, **values: float) -> None:
    """Check parameters that have a lower bound.

    Raises
    ------
    ParameterError
        Naming the first that is below.
    """
    for name, value in values.items():
        if not value >= least:
            raise ParameterError(f"{name} must be at least {least:g}, got {value!r}")


def check_choice(name: str, value: str, known: Iterable[str]) -> None:
    """Check a word.

    Raises
    ------
    ParameterError
        If it is none of those known.
    """
    if value not in known:
        raise ParameterError(f"{name} must be one of {', '.join(known)}, got {value!r}")


def in_one_line(build: Builder) -> Builder:
    """Return a builder whose errors are all of this package: those of a user's own functions are its causes."""

    @wraps(build)
    def built(*arguments: Any, **named: Any) -> HolonomicSDAE:
        try:
            return build(*arguments, **named)
        except SdaeverifyError:
            raise
        except Exception as error:
            text = f"{build.__name__} cannot be made with these arguments: {type(error).__name__}: {error}"
            raise ProblemError(" ".join(text.split())) from error

    return built  # type: ignore[return-value]


def _format_value(value: object) -> str:
    return f"{' '.join(repr(value).split()):.60}"
