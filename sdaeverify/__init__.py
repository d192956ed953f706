"""sdaeverify checks whether numerical schemes for stochastic differential-algebraic equations meet their claims."""

import ast
import logging
from importlib import import_module
from pathlib import Path

__version__ = "0.9.0"

# Silent unless the application configures logging, for example by logging.basicConfig(level="INFO").
logging.getLogger(__name__).addHandler(logging.NullHandler())

# Names are imported on first access. Every run of pytest imports the plugin of this package, usually without need of
# numpy; tables need pandas, which workers do not. The stub file is the only list of the names.
_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
_WHERE = {name.name: node.module for node in _STUB.body if isinstance(node, ast.ImportFrom) for name in node.names}

__all__ = ["__version__", *_WHERE]  # noqa: PLE0604 - a list of texts


# Functions of plugins, such as `orders`, which are found by the entry points of this group.
_FUNCTIONS = "sdaeverify.functions"


def __getattr__(name: str) -> object:
    if name in _WHERE:
        return getattr(import_module(f".{_WHERE[name]}", __name__), name)
    discovery = import_module(".registry.discovery", __name__)
    for entry in () if name.startswith("_") else discovery.enabled_entry_points(_FUNCTIONS):
        if entry.name == name:
            return entry.load()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
