"""Template of a plugin: a package with one scheme, one problem, their claims, tests, lock file and workflow.

The files are written into a temporary folder next to the target, and moved when they are complete.
"""

import json
import keyword
import os
import re
import shutil
import sys
from collections.abc import Mapping
from importlib.metadata import metadata, version
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from string import Template
from tempfile import mkdtemp
from typing import NamedTuple

from sdaeverify import UsageError
from sdaeverify.commands import claims_on_lines

# Names of modules that a plugin needs, or that are installed with it, and that it must not reuse.
TAKEN = frozenset({"sdaeverify", "numpy", "scipy", "pandas", "pluggy", "pytest", "click", "rich", "test", "tests"})
LONGEST = 60

_DISTRIBUTION = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
# Target of each file of the template. Names in the template have neither a leading dot nor the suffix .py, so that
# tools do not treat it as a project.
LOCK = "sdaeverify.lock"
FILES = {
    ".github/workflows/verify.yml": "workflow",
    ".gitignore": "gitignore",
    "LICENSE": "license",
    "README.md": "readme",
    "pyproject.toml": "pyproject",
    LOCK: "lock",
    "src/$module/__init__.py": "package",
    "src/$module/platen.py": "scheme",
    "src/$module/sinh.py": "problem",
    # Differs from every module name: tests/test_plugin.py would shadow the module of a plugin "test-plugin".
    "tests/test_$module.py": "tests",
}


class Names(NamedTuple):
    """Names to substitute in the template.

    Attributes
    ----------
    distribution : str
        Name of the distribution in lower case with hyphens.
    module : str
        Name of the module, with underscores.
    """

    distribution: str
    module: str

    @property
    def scheme(self) -> str:
        """Registered name of the scheme, unique to the plugin."""
        return f"{self.distribution}-platen"

    @property
    def problem(self) -> str:
        """Registered name of the problem."""
        return f"{self.distribution}-sinh"


def names_of(folder: Path, name: str | None = None) -> Names:
    """Return the names of the plugin in a folder.

    Parameters
    ----------
    folder : Path
        Folder, whose last part is the default name.
    name : str, optional
        Name in any spelling that package indexes consider equal: ``My_Schemes`` is ``my-schemes``.

    Raises
    ------
    UsageError
        If the name is not valid for a distribution and a module.
    """
    given = Path(os.path.realpath(folder)).name if name is None else name
    distribution = re.sub(r"[-_.]+", "-", given).lower()
    module = distribution.replace("-", "_")
    where = "; choose another with --name" if name is None else ""
    if not _DISTRIBUTION.fullmatch(distribution) or len(distribution) > LONGEST:
        expected = f"at most {LONGEST} letters a to z, digits and hyphens, beginning with a letter"
        raise UsageError(f"{given!r} cannot be the name of a plugin: expected {expected}{where}")
    if keyword.iskeyword(module) or module in sys.stdlib_module_names or module in TAKEN:
        raise UsageError(f"{given!r} cannot be the name of a plugin: {module} is a name of Python's or ours{where}")
    if _is_installed(module):
        raise UsageError(f"{given!r} cannot be the name of a plugin: a module {module} is installed already{where}")
    return Names(distribution, module)


def _is_installed(module: str) -> bool:
    """Return whether a module of this name can be imported, excluding namespace folders."""
    try:
        found = find_spec(module)
    except (ImportError, ValueError):
        return True
    return found is not None and found.origin is not None


def write_plugin(folder: Path, names: Names) -> tuple[str, ...]:
    """Write a plugin into a folder that is new or empty.

    Parameters
    ----------
    folder : Path
    names : Names

    Returns
    -------
    tuple of str
        Paths of the files relative to the folder.

    Raises
    ------
    UsageError
        If the folder is not empty, or cannot be written; it is then left unchanged.
    """
    texts = fill_in(names)
    try:
        _require_empty(folder)
        folder.parent.mkdir(parents=True, exist_ok=True)
        # On the same disk, where a move is atomic.
        beside = Path(mkdtemp(prefix=f".{names.distribution}-", dir=folder.resolve().parent))
        try:
            _write(beside, texts)
            _move(beside, folder)
        finally:
            shutil.rmtree(beside, ignore_errors=True)
    except (OSError, RuntimeError) as error:
        # A loop of symbolic links raises either of these.
        why = getattr(error, "strerror", None) or error
        raise UsageError(f"cannot write the plugin into {folder}: {why}") from error
    return tuple(texts)


def fill_in(names: Names) -> Mapping[str, str]:
    """Return the text of each file by its path relative to the folder of the plugin."""
    values = {
        **names._asdict(),
        "scheme": names.scheme,
        "problem": names.problem,
        "version": version("sdaeverify"),
        "repository": repository(),
    }
    template = files(__package__) / "template"

    def fill(text: str) -> str:
        return Template(text).substitute(values)

    texts = {fill(path): fill((template / f"{name}.txt").read_text(encoding="utf-8")) for path, name in FILES.items()}
    # In the order of the gate, which depends on the names of this plugin.
    return texts | {LOCK: claims_on_lines(json.loads(texts[LOCK]))}


def repository() -> str:
    """Return the repository address of sdaeverify from its metadata."""
    links = dict(link.split(", ", 1) for link in metadata("sdaeverify").get_all("Project-URL") or ())
    return str(links["Repository"])


def _require_empty(folder: Path) -> None:
    if not folder.is_dir() and (folder.exists() or folder.is_symlink()):
        raise UsageError(f"{folder} is not a folder; new-plugin expects a folder that is new or empty")
    if folder.exists() and any(folder.iterdir()):
        raise UsageError(f"{folder} is not empty; new-plugin expects a folder that is new or empty")


def _write(root: Path, texts: Mapping[str, str]) -> None:
    for path, text in texts.items():
        target = root / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")


def _move(source: Path, folder: Path) -> None:
    if not folder.exists():
        # mkdtemp restricts permissions to the owner.
        source.chmod(folder.resolve().parent.stat().st_mode & 0o777)
        source.rename(folder)
        return
    moved: list[Path] = []
    try:
        for child in sorted(source.iterdir()):
            moved.append(child.rename(folder / child.name))
    except OSError:
        for child in moved:
            child.rename(source / child.name)
        raise
