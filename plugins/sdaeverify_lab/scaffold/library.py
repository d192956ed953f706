"""Set-up of a gate for an existing library: a module, a test, a workflow, and tables of pyproject.toml."""

import tomllib
from collections.abc import Mapping
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from sdaeverify import UsageError

from . import repository

PYPROJECT, MODULE = "pyproject.toml", "verification"
ENTRY_POINTS = (
    '\n# The schemes of this distribution for sdaeverify.\n[project.entry-points.sdaeverify]\n{} = "{}.{}"\n'
)
# Files and tables by which a library chooses its packages itself.
CHOSEN = ("setup.py", "setup.cfg"), ("packages", "py-modules")


def adopt(folder: Path) -> tuple[str, ...]:
    """Write the files that a gate needs into the folder of a library, without overwriting files.

    Parameters
    ----------
    folder : Path
        Folder with a ``pyproject.toml`` that has a table ``[project]``, and the package of the same name.

    Returns
    -------
    tuple of str
        Paths of the files relative to the folder; the last is ``pyproject.toml``, to which tables are appended.

    Raises
    ------
    UsageError
        If the folder is not such a folder, already has a policy, or one of the files exists. No file is written then.
    """
    text, table = _read(folder / PYPROJECT)
    distribution = str(table["project"]["name"])
    package = _package(folder, distribution)
    values = {
        "distribution": distribution,
        "module": package.name,
        "version": version("sdaeverify"),
        "repository": repository(),
    }
    texts = {
        f"{package.relative_to(folder).as_posix()}/{MODULE}.py": _fill("library_scheme", values),
        f"tests/test_{MODULE}.py": _fill("library_tests", values),
        ".github/workflows/verify.yml": _fill("library_workflow", values),
    }
    if taken := [path for path in texts if (folder / path).exists()]:
        raise UsageError(f"{folder / taken[0]} exists already; init overwrites nothing")
    _write(folder, texts, _extended(text, table, values) + _packages(folder, table, package))
    return (*texts, PYPROJECT)


def _read(file: Path) -> tuple[str, Mapping[str, Any]]:
    """Return the text of a pyproject.toml and its parsed contents."""
    try:
        text = file.read_text(encoding="utf-8")
        table = tomllib.loads(text)
    except FileNotFoundError as error:
        raise UsageError(f"no {file}: init is for a library that exists; new-plugin DIR writes a new one") from error
    except (OSError, ValueError) as error:
        raise UsageError(f"cannot read {file}: {getattr(error, 'strerror', None) or error}") from error
    if not isinstance(table.get("project"), dict) or not isinstance(table["project"].get("name"), str):
        raise UsageError(f"{file} has no table [project] with a name, by which its schemes are found")
    if "sdaeverify" in table.get("tool", {}):
        raise UsageError(f"{file} has a table [tool.sdaeverify] already; sdaeverify gate runs it")
    return text, table


def _package(folder: Path, distribution: str) -> Path:
    """Return the folder of the library's package."""
    name = distribution.lower().replace("-", "_").replace(".", "_")
    for place in (folder / "src" / name, folder / name):
        if (place / "__init__.py").is_file():
            return place
    raise UsageError(f"no package {name} in {folder} or {folder / 'src'}, where the module {MODULE} would be written")


def _extended(text: str, table: Mapping[str, Any], values: Mapping[str, str]) -> str:
    """Return the text of pyproject.toml with the entry point and the policy appended."""
    project = table["project"]
    if "entry-points" in project.get("dynamic", ()) or "sdaeverify" in project.get("entry-points", {}):
        raise UsageError(
            f"{PYPROJECT} has entry points that init does not change; add {values['distribution']} = "
            f'"{values["module"]}.{MODULE}" to the group sdaeverify, and a table [tool.sdaeverify], by hand'
        )
    entry = ENTRY_POINTS.format(f'"{values["distribution"]}"', values["module"], MODULE)
    extended = f"{text.rstrip()}\n{entry}{_fill('library_policy', values)}"
    try:
        tomllib.loads(extended)
    except ValueError as error:
        raise UsageError(f"{PYPROJECT} cannot take tables at its end: {error}") from error
    return extended


def _packages(folder: Path, table: Mapping[str, Any], package: Path) -> str:
    """Return a table by which setuptools finds the package alone, or an empty string if none is needed.

    If a library has its package beside pyproject.toml, setuptools takes each further folder, such as the folder
    ``reports`` of a gate, for a second package and refuses to build. Without a table ``[build-system]``, pip uses
    setuptools.
    """
    names, keys = CHOSEN
    backend = table.get("build-system", {}).get("build-backend", "setuptools")
    chosen = {*keys} & {*table.get("tool", {}).get("setuptools", {})} or any(
        (folder / name).exists() for name in names
    )
    if package.parent != folder or chosen or not str(backend).startswith("setuptools"):
        return ""
    return _fill("library_packages", {"package": package.name})


def _fill(name: str, values: Mapping[str, str]) -> str:
    text = (files(__package__) / "template" / f"{name}.txt").read_text(encoding="utf-8")
    return Template(text).substitute(values)


def _write(folder: Path, texts: Mapping[str, str], pyproject: str) -> None:
    try:
        for path, text in texts.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text, encoding="utf-8")
        (folder / PYPROJECT).write_text(pyproject, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"cannot write into {folder}: {error.strerror or error}") from error
