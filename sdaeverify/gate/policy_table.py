"""How the keys of ``[tool.sdaeverify]`` are read: each has one type, and a key that is not known is an error."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from math import isfinite
from pathlib import Path
from typing import Any

from ..contracts.labels import did_you_mean
from ..errors import UsageError
from .amounts import read_memory
from .expected import ExpectedFailure

FAILURES = "expected-failures"


def read_table(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the keywords of a policy.

    Parameters
    ----------
    table : mapping of str to object
        As it is parsed from TOML.
    folder : Path
        Plugin files are relative to it.

    Raises
    ------
    UsageError
        If a key is unknown or a value has another type.
    """
    _known(table, READERS)
    values = {key.replace("-", "_"): READERS[key](key, value) for key, value in table.items()}
    if "plugins" in values:
        values["plugins"] = tuple(str(folder.absolute() / file) for file in values["plugins"])
    return {**values, "lock_named": "lock" in table}


def _known(table: Mapping[str, Any], known: Iterable[str]) -> None:
    for key in table:
        if key not in known:
            raise UsageError(f"unknown key {key!r}{did_you_mean(key, known)} (known: {', '.join(known)})")


def _fits(key: str, expected: str, value: object, *, fits: bool) -> None:
    if not fits:
        raise UsageError(f"{key} expects {expected}, got {value!r}")


def _text(key: str, value: Any) -> str:
    _fits(key, "a text", value, fits=isinstance(value, str) and bool(value.strip()))
    return str(value)


def _texts(key: str, value: Any) -> tuple[str, ...]:
    fits = isinstance(value, list) and value and all(isinstance(text, str) and text.strip() for text in value)
    _fits(key, "a list of texts", value, fits=bool(fits))
    return tuple(value)


def _number(key: str, value: Any) -> float:
    fits = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    _fits(key, "a number", value, fits=fits)
    return float(value)


def _whole(key: str, value: Any) -> int:
    _fits(key, "a whole number", value, fits=isinstance(value, int) and not isinstance(value, bool))
    return int(value)


def _switch(key: str, value: Any) -> bool:
    _fits(key, "true or false", value, fits=isinstance(value, bool))
    return bool(value)


def _memory(key: str, value: Any) -> int:
    text = _text(key, value)
    return 0 if text == "0" else read_memory(key, text)


def _failures(key: str, value: Any) -> tuple[ExpectedFailure, ...]:
    fits = isinstance(value, list) and all(isinstance(entry, dict) for entry in value)
    _fits(key, f"tables [[tool.sdaeverify.{key}]]", value, fits=fits)
    return tuple(_failure(f"{key}[{number}]", entry) for number, entry in enumerate(value, start=1))


def _failure(where: str, entry: Mapping[str, Any]) -> ExpectedFailure:
    names = [field.name for field in fields(ExpectedFailure)]
    try:
        _known(entry, names)
        if "reason" not in entry:
            raise UsageError("has no reason; say why the failure is expected")
        values: dict[str, Any] = {key: (_switch if key == "strict" else _text)(key, entry[key]) for key in entry}
        return ExpectedFailure(**values)
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from error


READERS: Mapping[str, Callable[[str, Any], Any]] = {
    "schemes": _texts,
    "problems": _texts,
    "measures": _texts,
    "plugins": _texts,
    "alpha": _number,
    "tier": _text,
    "seed": _whole,
    "inconclusive": _text,
    "lock": _text,
    "timeout": _number,
    "memory": _memory,
    "level": _whole,
    FAILURES: _failures,
}
