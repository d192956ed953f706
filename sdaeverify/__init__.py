"""sdaeverify tells whether a numerical scheme for stochastic differential-algebraic equations keeps its promises."""

import ast
import logging
from importlib import import_module
from pathlib import Path

__version__ = "0.9.0"

# Quiet unless the program that uses it asks for more: logging.basicConfig(level="INFO").
logging.getLogger(__name__).addHandler(logging.NullHandler())

# Whoever asks for a name pays for its module: every run of pytest imports the plugin of this package, most of them
# without need of numpy; tables need pandas, which workers do not. The names stand once, in the stub beside this file.
_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
_WHERE = {name.name: node.module for node in _STUB.body if isinstance(node, ast.ImportFrom) for name in node.names}

__all__ = ["__version__", *_WHERE]  # noqa: PLE0604 - a list of texts


def __getattr__(name: str) -> object:
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_WHERE[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
