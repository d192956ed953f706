"""Strategies for registered problems with other parameter values."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from math import isnan
from numbers import Integral, Real
from typing import Any, ClassVar

from hypothesis import strategies as st

from sdaeverify.studying import ProblemSpec

from .example import FOOT, Example
from .terms import Field

SHIPPED = "registered"
FILE = '''"""A registered problem with other numbers: {told}."""

from {module} import {function} as registered

from sdaeverify import hookimpl


def counterexample({horizon}):
    """Return the problem."""
    return registered({given})
'''
# A number is multiplied by FACTOR to one of the POWERS, and rounded to SIGNIFICANT digits.
POWERS, FACTOR, SIGNIFICANT = (0.0, 0.5, -0.5, 1.0, -1.0, 0.25, -0.25), 5.0, 3


@dataclass(frozen=True)
class ShippedExample(Example):
    """Registered problem with other parameter values.

    Attributes
    ----------
    module, function_name : str
        Module and name of the problem function.
    parameters : tuple of (str, object)
        Parameters that differ from the defaults of the function.
    """

    form: ClassVar[str] = SHIPPED

    module: str
    function_name: str
    parameters: tuple[tuple[str, object], ...]

    @property
    def fields(self) -> tuple[Field, ...]:
        """Empty, because the example consists of parameters only."""
        return ()

    @property
    def source(self) -> str:
        """Text of the plugin file that registers the problem."""
        given, words = dict(self.parameters), []
        horizon = f"horizon: float = {given.pop('horizon')}" if "horizon" in given else ""
        words = [f"{name}={value!r}" for name, value in given.items()] + (["horizon=horizon"] if horizon else [])
        told = f"{self.group}, {', '.join(words) or 'its own'}"
        named = {"module": self.module, "function": self.function_name}
        return FILE.format(told=told, horizon=horizon, given=", ".join(words), **named) + FOOT

    def doubled(self) -> "ShippedExample":
        """Return the example unchanged, because the meaning of its parameters is unknown."""
        return self

    def begun_at(self, parts: Mapping[str, Sequence[float]], t: float) -> "ShippedExample":
        """Return the example unchanged, because the problem function determines the start."""
        return self

    def moved(self) -> "ShippedExample":
        """Return the example unchanged, because the problem function determines the start."""
        return self


def shipped(specs: Sequence[ProblemSpec]) -> st.SearchStrategy[ShippedExample]:
    """Draw registered problems with each number multiplied by a factor between 1/5 and 5.

    Zeros stay 0. Integers and texts are not changed, because they determine the structure. A problem may reject drawn
    values.

    Parameters
    ----------
    specs : sequence of ProblemSpec
        Problems to draw from.
    """
    return st.sampled_from(specs).flatmap(_with_parameters)


def _with_parameters(spec: ProblemSpec) -> st.SearchStrategy[ShippedExample]:
    known = {**_defaults(spec), **dict(spec.parameters)}
    drawn = {name: st.sampled_from(POWERS).map(_scaling(value)) for name, value in known.items() if _is_size(value)}
    return st.fixed_dictionaries(drawn).map(lambda values: _example(spec, known | values))


def _defaults(spec: ProblemSpec) -> dict[str, object]:
    """Return the defaults of the parameters of a problem function."""
    return {name: each.default for name, each in signature(spec.function).parameters.items()}


def _is_size(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, Integral) and not isnan(value)


def _scaling(value: Any) -> Callable[[float], float]:
    return lambda power: float(f"{value * FACTOR**power:.{SIGNIFICANT}g}")


def _example(spec: ProblemSpec, values: dict[str, object]) -> ShippedExample:
    own = _defaults(spec)
    given = tuple((name, value) for name, value in values.items() if name == "horizon" or value != own.get(name))
    where = spec.function.__module__, spec.function.__qualname__
    horizon = values.get("horizon", 1.0)
    assert isinstance(horizon, float)
    return ShippedExample(SHIPPED, spec.name, horizon, (), *where, given)
