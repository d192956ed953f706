"""Labels: unique texts ``name[key=value,...]`` that name a scheme or problem with its parameters.

A canonical label lists the parameters that differ from their defaults, in the order of their declaration.
A value is true or false, a number, or text. Text is put between double quotes (as in JSON) where it would
read as a number or contains characters other than ASCII letters, digits and ``_ . + - / :``.
"""

import inspect
import json
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, Field, fields
from fnmatch import fnmatchcase
from numbers import Integral, Real
from typing import Any, NamedTuple

from ..errors import ParameterError, UsageError
from .spelling import did_you_mean

REQUIRED = inspect.Parameter.empty
SYNTAX = "expected name[key=value,...]"
KINDS: tuple[tuple[type, str], ...] = (
    (bool, "true or false"),
    (Integral, "a whole number"),
    (Real, "a number"),
    (str, "a word or a number"),
)
# Largest accepted number: larger ones would overflow to infinity.
LARGEST = sys.float_info.max

_LABEL = re.compile(r'\s*(?P<name>[^\[\]=,"\s]+)\s*(?P<brackets>\[(?P<inside>.*)\])?\s*', re.DOTALL)
_ITEM = re.compile(r'\s*(?P<key>\w+)\s*=\s*(?P<value>"(?:[^"\\]|\\.)*"|[^\[\]=,"]*[^\[\]=,"\s])\s*', re.DOTALL)
_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|.', re.DOTALL)
_BARE = re.compile(r"[\w.+/:-]+", re.ASCII)


class Parameter(NamedTuple):
    """A parameter of a scheme or problem.

    Attributes
    ----------
    name : str
    default : object
        Its type determines how text is converted; `REQUIRED` if there is none.
    text_only : bool
        Whether it is annotated as plain ``str``, so that digits stay text.
    """

    name: str
    default: Any
    text_only: bool = False


class Label(NamedTuple):
    """Label split into its name and parameters.

    Attributes
    ----------
    name : str
    parameters : mapping of str to str, or None
        Values as they were written, quotes included; None if there were no brackets.
    """

    name: str
    parameters: Mapping[str, str] | None


def dataclass_parameters(owner: type) -> tuple[Parameter, ...]:
    """Return the parameters of a dataclass: the fields its constructor takes."""
    return tuple(Parameter(f.name, _default(f), f.type in (str, "str")) for f in fields(owner) if f.init)


def function_parameters(function: Callable[..., object]) -> tuple[Parameter, ...]:
    """Return the parameters of a function in the order of its signature."""
    given = inspect.signature(function).parameters.values()
    return tuple(Parameter(p.name, p.default, p.annotation in (str, "str")) for p in given)


def make_label(name: str, parameters: Sequence[Parameter], values: Mapping[str, object]) -> str:
    """Return the canonical label.

    Parameters
    ----------
    name : str
    parameters : sequence of Parameter
    values : mapping of str to bool, int, float or str
        Missing parameters have their defaults.

    Raises
    ------
    ParameterError
        If a value has another type, because it could not be written on a command line.
    """
    texts = {p.name: _write(values[p.name], p) for p in parameters if p.name in values}
    shown = [f"{p.name}={texts[p.name]}" for p in parameters if p.name in texts and not _is_default(texts, p)]
    return f"{name}[{','.join(shown)}]" if shown else name


def parse_label(text: str) -> Label:
    """Split a label into its name and parameters.

    Raises
    ------
    UsageError
        If it is not of the form ``name[key=value,...]``.
    """
    match = _LABEL.fullmatch(text)
    if not match:
        raise UsageError(f"cannot read {text!r}: {SYNTAX}")
    if match["brackets"] is None:
        return Label(match["name"], None)
    parameters: dict[str, str] = {}
    for item in split_list(match["inside"]):
        key, value = _parse_item(item, text)
        if key in parameters:
            raise UsageError(f"cannot read {text!r}: parameter {key!r} is given twice")
        parameters[key] = value
    return Label(match["name"], parameters)


def split_list(text: str) -> list[str]:
    """Split at commas outside brackets and quotes, and drop empty items."""
    items, depth = [""], 0
    for token in _TOKEN.findall(text):
        depth = max(0, depth + (token == "[") - (token == "]"))
        if token == "," and not depth:
            items.append("")
        else:
            items[-1] += token
    return [item.strip() for item in items if item.strip()]


def is_glob(pattern: str) -> bool:
    """Return whether a pattern contains a wildcard in its part before the parameters."""
    return bool(set("*?") & set(pattern.partition("[")[0]))


def is_named(label: str, pattern: str) -> bool:
    """Return whether a pattern equals a label, or is a glob that matches the label's part before the parameters."""
    return label == pattern or (is_glob(pattern) and fnmatchcase(label.partition("[")[0], pattern))


def is_meant(label: str, patterns: str) -> bool:
    """Return whether any of several patterns, separated by commas, matches; an empty text matches all labels."""
    return not patterns or any(is_named(label, pattern) for pattern in split_list(patterns))


def read_values(
    owner: str, parameters: Sequence[Parameter], texts: Mapping[str, str]
) -> dict[str, bool | int | float | str]:
    """Convert the texts of a label to the types of the defaults.

    Parameters
    ----------
    owner : str
        Owner of the parameters, for messages: ``scheme 'milstein'``.
    parameters : sequence of Parameter
    texts : mapping of str to str

    Raises
    ------
    ParameterError
        If a name is unknown or a text cannot be converted to the parameter's type.
    """
    known = {p.name: p for p in parameters}
    for key in texts:
        if key not in known:
            listing = ", ".join(known) or "none"
            raise ParameterError(f"{owner} has no parameter {key!r}{did_you_mean(key, known)} (known: {listing})")
    return {key: _read(owner, text, known[key]) for key, text in texts.items()}


def checked_values(owner: str, parameters: Sequence[Parameter], values: Mapping[str, object]) -> dict[str, Any]:
    """Check that values have the types of the defaults, and are finite if these are; convert to float if needed.

    Parameters
    ----------
    owner : str
        As for `read_values`.
    parameters : sequence of Parameter
        A parameter whose default cannot be written in a label accepts any value.
    values : mapping of str to object

    Raises
    ------
    ParameterError
        If a value has another type.
    """
    checked: dict[str, Any] = dict(values)
    for name, default, _ in (p for p in parameters if p.name in values):
        if wrong := _objection(values[name], default):
            given = f"{' '.join(repr(values[name]).split()):.60}"
            raise ParameterError(f"parameter {name} of {owner} {wrong}, got {given}")
        if isinstance(default, float):
            # NumPy stores integers beyond 64 bits as objects.
            checked[name] = float(checked[name])
    return checked


def describe_kind(default: object) -> str:
    """Return a description of the values a parameter with this default takes; empty for an unsupported type."""
    return next((words for kind, words in KINDS if isinstance(default, kind)), "")


def matches(glob: str, label: str) -> bool:
    """Return whether a glob matches a whole label: only ``*`` and ``?`` are special, brackets are literal."""
    return fnmatchcase(label, glob.replace("[", "[[]"))


def _default(field: "Field[Any]") -> object:
    if field.default_factory is not MISSING:
        return field.default_factory()
    return REQUIRED if field.default is MISSING else field.default


def _parse_item(item: str, text: str) -> tuple[str, str]:
    match = _ITEM.fullmatch(item)
    if not match:
        raise UsageError(f"cannot read {item!r} in {text!r}: {SYNTAX}")
    return match["key"], match["value"]


def _is_default(texts: Mapping[str, str], parameter: Parameter) -> bool:
    # Compare texts instead of values, so that nan equals its default.
    return parameter.default is not REQUIRED and texts[parameter.name] == _write(parameter.default, parameter)


def _write(value: object, parameter: Parameter) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Integral) and isinstance(parameter.default, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value)).removesuffix(".0")
    if isinstance(value, str):
        return value if _BARE.fullmatch(value) and _number(value) is None else json.dumps(value, ensure_ascii=False)
    raise ParameterError(
        f"parameter {parameter.name} has a value of type {type(value).__name__}, "
        "expected bool, int, float or str: it must be possible to write it on a command line"
    )


def _read(owner: str, text: str, parameter: Parameter) -> bool | int | float | str:
    value = _convert(text, parameter)
    wrong = _objection(value, parameter.default)
    if value is None or wrong:
        raise ParameterError(
            f"parameter {parameter.name} of {owner} {wrong or 'expects no text at all'}, got {text!r:.60}"
        )
    return value


def _objection(value: object, default: object) -> str:
    """Return the error text for a value of a parameter with the given default; empty if the value is valid."""
    kind = next((kind for kind, _ in KINDS if isinstance(default, kind)), None)
    if kind is None:
        return ""
    if not isinstance(value, (str, Real) if kind is str else kind) or isinstance(value, bool) is not (kind is bool):
        return f"expects {describe_kind(default)}"
    if kind is Integral or not isinstance(value, Real) or _is_finite(value):
        return ""
    # An integer may be too large for a float.
    return "must be finite" if isinstance(value, Integral) or (kind is Real and _is_finite(default)) else ""


def _is_finite(value: Any) -> bool:
    return bool(abs(value) <= LARGEST)


def _convert(text: str, parameter: Parameter) -> bool | int | float | str | None:
    default = parameter.default
    if isinstance(default, bool):
        return {"true": True, "false": False}.get(text.lower())
    if isinstance(default, Integral):
        return int(text) if re.fullmatch(r"[+-]?\d{1,300}", text) else None
    if isinstance(default, Real):
        return _number(text)
    return _text(text, parameter.text_only) if isinstance(default, str) else None


def _text(text: str, text_only: bool) -> str | float | None:
    if text.startswith('"'):
        return _unquote(text)
    number = None if text_only else _number(text)
    return text if number is None else number


def text_of(value: str) -> str:
    """Return the text that a value of a label is, without quotes."""
    return (_unquote(value) or "") if value.startswith('"') else value


def _unquote(text: str) -> str | None:
    try:
        return str(json.loads(text))
    except json.JSONDecodeError:
        return None


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
