"""What a scheme, a problem or a measure is written in: code that is parsed, and versions of libraries.

Code is that of its top-level package, or of the file it is in, and of what that imports from other places where
nothing is installed, as far as it is reached by name. Installed libraries count by their version, the framework by
what measures in it.
"""

import hashlib
import os
import platform
import sys
from collections.abc import Hashable, Iterable, Mapping
from functools import cache
from importlib import metadata
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple, cast

from ..contracts.measure import JUDGING, Measure
from ..contracts.opened import Caller, is_library, owners, saved_since_import
from .statements import INIT, Reached, Space, Statement, parse_statements

FRAMEWORK = "sdaeverify"
ROOT = Path(__file__).parents[1]
# The rooms of the framework that evidence comes from. What judges and reports is none of them.
MEASURING = ("arrays.py", "bridges", "conformance", "contracts", "forms", "noise", "numerics", "probe", "simulate")
# Modules of these rooms that say what is made of evidence.
SAYING = frozenset({f"{name}.py" for name in ("cases", "coverage", "exhibit", "experiment", "finding")})
# Packages whose arithmetic the numbers come from.
ARITHMETIC = ("numpy", "scipy")
KNOWN = frozenset({*sys.stdlib_module_names, *ARITHMETIC, FRAMEWORK, ""})
MEASURES = ROOT / "measures"
# Where a plugin file that was loaded keeps what it held.
SOURCE = "__source__"


class Code(NamedTuple):
    """Code that something is written in.

    Attributes
    ----------
    digest : str
    libraries : tuple of str
        Names and versions of installed ones.
    homes : tuple of Path
        Folders of packages, and single files.
    names : mapping of Path to frozenset of str
        What it reaches, by file.
    saved : str
        Hash of the files as they are, which tells whether they were saved; empty of a plugin file that was loaded:
        its module is called after what it held.
    """

    digest: str
    libraries: tuple[str, ...]
    homes: tuple[Path, ...]
    names: Mapping[Path, frozenset[str]]
    saved: str

    def reaches(self, caller: Caller) -> bool:
        """Tell whether running code is part of this: a definition that it reaches, or what its file runs itself."""
        names = self.names.get(Path(caller.file), frozenset())
        return caller.name in names or (caller.name.startswith("<") and bool(names))


def code_of(thing: Any) -> Code | None:
    """Return the code of a class or function, as it was first read; None where it has no source that can be read.

    Parameters
    ----------
    thing : type or callable
        The class of a scheme or measure, or the function of a problem. What judges in a measure does not count.
    """
    return _code_of(cast("Hashable", thing))


@cache
def _code_of(thing: Any) -> Code | None:
    module = sys.modules.get(getattr(thing, "__module__", ""))
    file = Path(getattr(module, "__file__", None) or "")
    if module is None or file.suffix != ".py" or module.__name__.partition(".")[0] in sys.stdlib_module_names:
        return None
    own = getattr(module, SOURCE, None)
    if own is None and not file.is_file():
        return None
    measuring = isinstance(thing, type) and issubclass(thing, Measure)
    # What a function has made has parameters that are written down elsewhere.
    name = "" if "<locals>" in thing.__qualname__ else thing.__qualname__.partition(".")[0]
    homes = [home_of(file), *([MEASURES] if measuring else [])]
    try:
        reached = _reach(homes, file, name, own, JUDGING if measuring else frozenset())
        if own is None and any(map(saved_since_import, reached.names)):
            return None
        digest, saved = _digest(reached, homes), contents(tuple(homes)) if own is None else ""
    except OSError:
        return None
    owners().update(map(str, homes))
    return Code(digest, tuple(sorted(_libraries(reached))), tuple(homes), reached.names, saved)


def _reach(homes: list[Path], file: Path, name: str, own: bytes | None, without: frozenset[str]) -> Reached:
    """Return what a name reaches in its home and, as they are found, in those of others that it imports."""
    while True:
        reached = _space(tuple(homes), own, without).reach(file, name)
        found = dict.fromkeys(filter(None, map(_home_of_import, sorted(_imported(reached)))))
        more = [home for home in found if home not in homes]
        if not more:
            return reached
        homes += more


@cache
def _space(homes: tuple[Path, ...], own: bytes | None, without: frozenset[str]) -> Space:
    """Return the statements of some homes, of the first one what it held when it was loaded, where that is known."""
    first, *others = (_statements(home, own if home == homes[0] else None, without) for home in homes)
    return Space(sum(others, first))


@cache
def _statements(home: Path, content: bytes | None, without: frozenset[str]) -> tuple[Statement, ...]:
    if content is not None:
        return parse_statements(home, home.stem, content, without)
    return tuple(one for file in files_below(home) if file.suffix == ".py" for one in _parse(home, file, without))


def _parse(home: Path, file: Path, without: frozenset[str]) -> tuple[Statement, ...]:
    below = file.relative_to(home.parent).with_suffix("").parts
    module, content = ".".join(below[:-1] if file.name == INIT else below), file.read_bytes()
    try:
        return parse_statements(file, module, content, without)
    except (SyntaxError, ValueError):
        # It is for another version of the language, or none of it: all of it counts for everybody.
        return parse_statements(file, module, f"{content!r}.count".encode(), without)


def _digest(reached: Reached, homes: Iterable[Path]) -> str:
    """Return a hash of statements, of compiled modules, and of variables of the environment that texts name."""
    texts = {text for one in reached.statements for text in one.words.texts if text in os.environ}
    compiled = (file for home in homes for file in files_below(home) if file.suffix != ".py")
    return _hash(
        [
            *(one.content for one in reached.statements),
            *(file.read_bytes() for file in compiled),
            *(f"{text}={os.environ[text]}".encode() for text in sorted(texts)),
        ]
    )


def forget() -> None:
    """Read files again for what nobody has asked for so far."""
    for function in (_space, _statements, files_below, _home_of_import, _contents):
        function.cache_clear()


def contents(homes: Iterable[Path]) -> str:
    """Return a hash of what is in the files of packages, as this process has first read them."""
    return _hash(_contents(home) for home in homes)


@cache
def _contents(home: Path) -> bytes:
    return _hash(f"{file.name} ".encode() + file.read_bytes() for file in files_below(home)).encode()


@cache
def framework_code() -> str:
    """Return a hash of what measures in the framework."""
    homes = [ROOT / room for room in MEASURING]
    files = [(home, file) for home in homes for file in files_below(home) if file.name not in SAYING]
    statements = (one for home, file in files for one in _parse(home, file, frozenset()))
    return _hash(one.content for one in statements)


@cache
def arithmetic() -> tuple[str, ...]:
    """Return the versions of what all numbers are computed with."""
    return f"Python {_minor(platform.python_version())}", *map(_version, ARITHMETIC)


@cache
def home_of(file: Path) -> Path:
    """Return the top-level package that a module is in, or itself where there is none; of the framework a room."""
    if ROOT in file.parents:
        return ROOT / file.relative_to(ROOT).parts[0]
    if not (file.parent / INIT).is_file():
        return file
    return next(folder for folder in file.parents if not (folder.parent / INIT).is_file())


@cache
def files_below(home: Path) -> tuple[Path, ...]:
    """Return the modules of a package, or a module itself, those that are compiled as well."""
    found = sorted(home.rglob("*")) if home.is_dir() else [home]
    return tuple(file for file in found if file.name.endswith((".py", *EXTENSION_SUFFIXES)) and file.is_file())


def _imported(reached: Reached) -> set[str]:
    """Return the dotted names of what statements import from elsewhere."""
    found = (each for one in reached.statements for each in one.words.imports if not each.relative)
    names = {f"{each.module}.{each.name}".strip(".") for each in found}
    return {name for name in names if name.partition(".")[0] not in KNOWN}


@cache
def _home_of_import(name: str) -> Path | None:
    """Return where the code of an imported module is, if that is where nothing is installed."""
    top, *rest = name.split(".")
    try:
        spec = find_spec(top)
    except (ImportError, ValueError):
        return None
    if spec is None:
        return None
    if spec.origin is not None:
        file = Path(spec.origin)
        return home_of(file) if file.is_file() and not is_library(str(file)) else None
    # A folder without __init__.py.
    folders = [Path(folder) for folder in spec.submodule_search_locations or () if not is_library(folder)]
    stems = [folder.joinpath(*rest[:length]) for folder in folders for length in range(len(rest), 0, -1)]
    places = (place for stem in stems for place in (stem.with_suffix(".py"), stem / INIT))
    return next((home_of(place) for place in places if place.is_file()), None)


def _libraries(reached: Reached) -> set[str]:
    """Return the installed libraries that statements import, by distribution and version."""
    tops = {name.partition(".")[0] for name in _imported(reached) if _home_of_import(name) is None}
    return {_version(name) for top in tops for name in _distributions(top)}


def _distributions(top: str) -> list[str]:
    """Return the distributions that a module is of; most are called after it, and the others take long to find."""
    try:
        return [metadata.distribution(top).metadata["Name"]]
    except (metadata.PackageNotFoundError, KeyError):
        return _owners().get(top, [])


@cache
def _owners() -> dict[str, list[str]]:
    return {top: list(names) for top, names in metadata.packages_distributions().items()}


def _version(distribution: str) -> str:
    return f"{distribution} {_minor(metadata.version(distribution))}"


def _minor(version: str) -> str:
    """Return a version without what is but a correction."""
    return ".".join(version.split(".")[:2])


def _hash(contents: Iterable[bytes]) -> str:
    digest = hashlib.blake2b(digest_size=12)
    for content in contents:
        digest.update(content + b"\0")
    return digest.hexdigest()
