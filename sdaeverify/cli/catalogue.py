"""What is registered, as records with stable keys: the rows of ``list`` and of its JSON."""

import math
from typing import Any

from ..contracts.scheme import form_names
from ..registry.contributions import Registered
from ..registry.load import Registry
from ..report.passports import docstring

Record = dict[str, Any]


def catalogue(registry: Registry) -> dict[str, list[Record]]:
    """Return the records of each kind, sorted by name; plugins in the order they were loaded."""
    return {
        "schemes": [_record("scheme", entry) for entry in registry.schemes.values()],
        "problems": [_record("problem", entry) for entry in registry.problems.values()],
        "measures": [_record("measure", entry) for entry in registry.measures.values()],
        "plugins": [{"kind": "plugin", **row._asdict()} for row in registry.plugins],
    }


def _record(kind: str, entry: Registered) -> Record:
    lines = docstring(entry.subject).splitlines()
    return {
        "kind": kind,
        "name": entry.name,
        "parameters": {parameter.name: _plain(parameter.default) for parameter in entry.parameters},
        "summary": lines[0] if lines else "",
        **({"form": form_names(entry.thing)} if kind == "scheme" else {}),
        **({} if kind == "measure" else {"on_request": entry.on_request}),
        "plugin": entry.origin.plugin,
        "distribution": entry.origin.distribution,
        "version": entry.origin.version,
    }


def _plain(default: Any) -> Any:
    # JSON knows neither infinity nor nan.
    return str(default) if isinstance(default, float) and not math.isfinite(default) else default
