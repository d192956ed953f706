"""Provenance of a run: versions, platform, arguments, stream fingerprint, plugins."""

import os
import platform
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version

from ..noise.brownian import fingerprint
from ..registry.load import Registry
from ..study import Study
from .folders import SCHEMA
from .saved import SavedClaim

GIT_SECONDS = 10.0
PACKAGES = ("sdaeverify", "numpy", "scipy", "pandas", "pluggy")


def provenance(registry: Registry, study: Study, arguments: Sequence[str]) -> dict[str, object]:
    """Return the contents of ``run.json``.

    Parameters
    ----------
    registry : Registry
    study : Study
    arguments : sequence of str
        Words of the command line, or a description of the call.

    Returns
    -------
    dict
    """
    settings, cells = study.settings, study.plan.cells
    return {
        **describe_making(registry, settings.seed, arguments),
        "selection": {
            "schemes": list(dict.fromkeys(cell.scheme.label for cell in cells)),
            "problems": list(dict.fromkeys(cell.spec.label for cell in cells)),
            "measures": list(dict.fromkeys(cell.measure.name for cell in cells)),
        },
        "claims": [asdict(each) for each in dict.fromkeys(_claims(study))],
        "files": list(registry.files),
        "settings": {**asdict(settings), "steps": list(settings.steps)},
    }


def _claims(study: Study) -> Iterator[SavedClaim]:
    for scheme in dict.fromkeys(cell.scheme for cell in study.plan.cells):
        yield from (SavedClaim.of(scheme, claim) for claim in scheme.promises)


def describe_making(registry: Registry, seed: int, arguments: Sequence[str]) -> dict[str, object]:
    """Return the provenance common to all kinds of runs: versions, platform, arguments, seed, plugins.

    Parameters
    ----------
    registry : Registry
        Registry with the plugins of the run.
    seed : int
    arguments : sequence of str
        Words of the command line, or a description of the call.
    """
    return {
        "schema_version": SCHEMA,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "commit": commit(),
        "versions": versions(),
        "platform": {
            "system": platform.platform(),
            "machine": platform.machine(),
            "byteorder": sys.byteorder,
        },
        "arguments": list(arguments),
        "environment": {name: value for name, value in os.environ.items() if name.startswith("SDAEVERIFY_")},
        "seed": seed,
        "stream_fingerprint": fingerprint(seed),
        "plugins": [row._asdict() for row in registry.plugins],
        "warnings": list(registry.warnings),
    }


def commit() -> str:
    """Return the git commit of the current folder, or an empty string without a repository or git."""
    asked = ["git", "rev-parse", "--short=12", "HEAD"]
    try:
        done = subprocess.run(asked, capture_output=True, text=True, timeout=GIT_SECONDS, check=False)
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def versions() -> dict[str, str]:
    """Return the versions of Python, sdaeverify and the packages it depends on."""
    return {"python": platform.python_version(), **{name: _version(name) for name in PACKAGES}}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
