"""What is registered, as records with stable keys: the rows of ``list`` and of its JSON."""

import math
from typing import Any

from ..contracts.labels import Parameter, dataclass_parameters, function_parameters
from ..contracts.scheme import form_names
from ..registry.contributions import ProblemEntry, Registered, SchemeEntry
from ..registry.load import Registry
from ..report.passports import docstring

Record = dict[str, Any]
AnyEntry = SchemeEntry | ProblemEntry | Registered


def catalogue(registry: Registry) -> dict[str, list[Record]]:
    """Return the records of each kind, sorted by name; plugins in the order they were loaded."""
    return {
        "schemes": [_record("scheme", entry) for entry in registry.schemes.values()],
        "problems": [_record("problem", entry) for entry in registry.problems.values()],
        "measures": [_record("measure", entry) for entry in registry.measures.values()],
        "plugins": [{"kind": "plugin", **row._asdict()} for row in registry.plugins],
    }


def subject(entry: AnyEntry) -> object:
    """Return what carries the docstring: the class of a scheme or measure, the function of a problem."""
    if isinstance(entry, SchemeEntry):
        return type(entry.variants[0])
    return entry.function if isinstance(entry, ProblemEntry) else type(entry.thing)


def parameters_of(entry: AnyEntry) -> tuple[Parameter, ...]:
    """Return the parameters of a scheme or problem; a measure has none."""
    if isinstance(entry, SchemeEntry):
        return dataclass_parameters(type(entry.variants[0]))
    return function_parameters(entry.function) if isinstance(entry, ProblemEntry) else ()


def _record(kind: str, entry: AnyEntry) -> Record:
    lines = docstring(subject(entry)).splitlines()
    return {
        "kind": kind,
        "name": entry.name,
        "parameters": {parameter.name: _plain(parameter.default) for parameter in parameters_of(entry)},
        "summary": lines[0] if lines else "",
        **({"form": form_names(entry.variants[0])} if isinstance(entry, SchemeEntry) else {}),
        **({} if isinstance(entry, Registered) else {"on_request": entry.on_request}),
        "plugin": entry.origin.plugin,
        "distribution": entry.origin.distribution,
        "version": entry.origin.version,
    }


def _plain(default: Any) -> Any:
    # JSON knows neither infinity nor nan.
    return str(default) if isinstance(default, float) and not math.isfinite(default) else default
