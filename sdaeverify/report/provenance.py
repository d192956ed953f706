"""What a run was made with: versions, platform, arguments, stream fingerprint, plugins."""

import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version

from ..noise import fingerprint
from ..registry import Registry
from ..settings import Settings

SCHEMA = 1
PACKAGES = ("sdaeverify", "numpy", "scipy", "pandas", "pluggy")


def provenance(registry: Registry, settings: Settings, arguments: Sequence[str]) -> dict[str, object]:
    """Return the contents of ``run.json``.

    Parameters
    ----------
    registry : Registry
    settings : Settings
    arguments : sequence of str
        Words of the command line, or a description of the call.

    Returns
    -------
    dict
    """
    return {
        "schema_version": SCHEMA,
        "versions": {"python": platform.python_version(), **{name: _version(name) for name in PACKAGES}},
        "platform": {
            "system": platform.platform(),
            "machine": platform.machine(),
            "byteorder": sys.byteorder,
        },
        "arguments": list(arguments),
        "seed": settings.seed,
        "settings": {**asdict(settings), "steps": list(settings.steps)},
        "stream_fingerprint": fingerprint(settings.seed),
        "plugins": [row._asdict() for row in registry.plugins],
        "warnings": list(registry.warnings),
    }


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
