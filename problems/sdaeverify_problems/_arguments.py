"""Checks of the parameters of problems and the arguments of builders, with messages of one line."""

from collections.abc import Callable, Iterable
from functools import wraps
from math import inf
from numbers import Integral, Real
from typing import Any, TypeVar

from sdaeverify import HolonomicSDAE, ParameterError, ProblemError, SdaeverifyError

Builder = TypeVar("Builder", bound=Callable[..., HolonomicSDAE])


def number(name: str, value: object) -> float:
    """Return a real number as a float; NaN and infinities pass, because only callers know the range.

    Raises
    ------
    ParameterError
        If `value` is not a real number, or is too large for a float.
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise ParameterError(f"{name} must be a number, got {_format_value(value)}")
    try:
        return float(value)
    except OverflowError:
        raise ParameterError(f"{name} must be a number of at most 1e308, got a longer one") from None


def count(name: str, value: object, least: int, most: int) -> None:
    """Raise unless a value is an integer from `least` to `most`.

    Raises
    ------
    ParameterError
        If `value` is not an integer, or is out of range.
    """
    if not isinstance(value, Integral) or isinstance(value, bool) or not least <= value <= most:
        raise ParameterError(f"{name} must be a whole number from {least} to {most}, got {_format_value(value)}")


def instance(name: str, value: object, kind: type) -> None:
    """Raise unless a value is an instance of a class.

    Raises
    ------
    ParameterError
        If `value` is not an instance of `kind`.
    """
    if not isinstance(value, kind):
        raise ParameterError(f"{name} must be a {kind.__name__}, got {_format_value(value)}")


def function(name: str, value: object) -> None:
    """Raise unless a value is callable.

    Raises
    ------
    ParameterError
        If `value` is not callable.
    """
    if not callable(value):
        raise ParameterError(f"{name} must be a function, got {_format_value(value)}")


def check_positive(**values: float) -> None:
    """Raise unless all parameters are positive and finite.

    Raises
    ------
    ParameterError
        If a parameter is not positive and finite; the message names the first of them.
    """
    for name, value in values.items():
        if not 0.0 < value < inf:
            raise ParameterError(f"{name} must be positive and finite, got {value!r}")


def check_not_negative(**values: float) -> None:
    """Raise unless all parameters are finite and not negative.

    Raises
    ------
    ParameterError
        If a parameter is negative or not finite; the message names the first of them.
    """
    for name, value in values.items():
        if not 0.0 <= value < inf:
            raise ParameterError(f"{name} must be finite and not negative, got {value!r}")


def check_least(least: float, **values: float) -> None:
    """Raise unless all parameters are at least `least`.

    Raises
    ------
    ParameterError
        If a parameter is smaller or NaN; the message names the first of them.
    """
    for name, value in values.items():
        if not value >= least:
            raise ParameterError(f"{name} must be at least {least:g}, got {value!r}")


def check_choice(name: str, value: str, known: Iterable[str]) -> None:
    """Raise unless a value is one of the known words.

    Raises
    ------
    ParameterError
        If `value` is not in `known`.
    """
    if value not in known:
        raise ParameterError(f"{name} must be one of {', '.join(known)}, got {value!r}")


def in_one_line(build: Builder) -> Builder:
    """Wrap a builder so that errors of user functions are re-raised as errors of this package, in one line."""

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
