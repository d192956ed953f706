"""The code that evidence depends on: parsed top-level packages or files, and versions of libraries.

A package counts as a whole, even if only part of it is used. Comments, docstrings and layout do not count.
"""

import ast
import hashlib
import platform
import sys
from collections.abc import Iterable
from functools import cache
from importlib import metadata
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Any, NamedTuple

from ..contracts.measure import JUDGING, Measure
from ..contracts.opened import home_of, is_library

ROOT = Path(__file__).parents[1]
# The parts of the framework that produce evidence. Judging and reporting are not among them.
MEASURING = ("arrays.py", "conformance", "contracts", "forms", "noise", "numerics", "probe", "simulate")
MEASURES = ROOT / "measures"
# The module in these parts that defines findings, which do not affect evidence.
SAYING = frozenset({"finding.py"})
# Packages whose floating-point results enter the evidence.
ARITHMETIC = ("numpy", "scipy")
KNOWN = frozenset({*sys.stdlib_module_names, ROOT.name})
# Attribute of a loaded plugin file that holds its source.
SOURCE = "__source__"
BLOCKS = (ast.stmt, ast.excepthandler, ast.match_case)
DEFINITIONS = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


class Code(NamedTuple):
    """The code of a scheme, problem or measure.

    Attributes
    ----------
    digest : str
    libraries : tuple of str
        Names and versions of the installed libraries that it imports.
    """

    digest: str
    libraries: tuple[str, ...]


def code_of(thing: Any) -> Code | None:
    """Return the code of a class or function, as it was loaded; None if no source can be read.

    The build of a scheme, which stands for code outside Python, is part of it; there is none if the build is unknown.

    Parameters
    ----------
    thing : type or callable
        The class of a scheme or measure, or the function of a problem. Members of a measure that judge are excluded.
    """
    homes, build = homes_of(thing), getattr(thing, "build", "")
    if None in homes or build is None:
        return None
    measuring = isinstance(thing, type) and issubclass(thing, Measure)
    try:
        parsed = [_parse_home(home, _loaded_source(thing, home), measuring=measuring) for home in homes if home]
    except OSError:
        return None
    libraries = {version for _, imported in parsed for top in imported - KNOWN for version in _versions(top)}
    parts = [*(digest for digest, _ in parsed), *filter(None, [build])]
    return Code(_hash(map(str.encode, parts)), tuple(sorted(libraries)))


def judging_code(*kinds: type) -> str:
    """Return a hash of the whole framework, of the packages of some classes and of libraries; empty without source.

    Unlike `code_of`, it includes the members of measures that judge, and comments.
    """
    codes = [code_of(kind) for kind in kinds]
    known = [code for code in codes if code is not None]
    if len(known) < len(codes):
        return ""
    sources = {(home, _loaded_source(kind, home)) for kind in kinds for home in homes_of(kind) if home}
    contents = {_hash_files(home, source) for home, source in (*sources, (ROOT, None))}
    libraries = {*arithmetic(), *(name for code in known for name in code.libraries)}
    return _hash(map(str.encode, (*(code.digest for code in known), *sorted(contents), *sorted(libraries))))


@cache
def _hash_files(home: Path, source: bytes | None) -> str:
    return _hash([source] if source is not None else (file.read_bytes() for file in _files_below(home)))


def homes_of(thing: Any) -> list[Path | None]:
    """Return the top-level packages or files of a class and its bases, or of a function; None if without source."""
    bases = thing.__mro__[1:] if isinstance(thing, type) else ()
    modules = [thing.__module__, *(base.__module__ for base in bases if _counts_as_base(base.__module__))]
    return list(dict.fromkeys(map(_home_of_module, modules)))


def _counts_as_base(module: str) -> bool:
    """Return whether base classes from a module count as code: those of installed libraries count by version."""
    top, _, rest = module.partition(".")
    if top in KNOWN:
        return top == ROOT.name and rest.partition(".")[0] == MEASURES.name
    return not is_library(getattr(sys.modules.get(module), "__file__", None) or "")


def _home_of_module(name: str) -> Path | None:
    file = Path(getattr(sys.modules.get(name), "__file__", None) or "")
    if file.suffix != ".py" or name.partition(".")[0] in sys.stdlib_module_names:
        return None
    return home_of(file)


def _loaded_source(thing: Any, home: Path) -> bytes | None:
    """Return the source of a plugin file as it was loaded; None for imported modules."""
    module = sys.modules.get(thing.__module__)
    source: bytes | None = getattr(module, SOURCE, None)
    return source if source is not None and Path(module.__file__ or "") == home else None  # type: ignore[union-attr]


@cache
def _parse_home(home: Path, source: bytes | None, *, measuring: bool) -> tuple[str, frozenset[str]]:
    """Return a hash of the code of a package or file, and the top-level names of its absolute imports."""
    if source is not None:
        return _parse([(home.name, source)], frozenset())
    folder = home if home.is_dir() else home.parent
    named = ((file.relative_to(folder).as_posix(), file.read_bytes()) for file in _files_below(home))
    return _parse(named, JUDGING if measuring else frozenset())


def _parse(files: Iterable[tuple[str, bytes]], without: frozenset[str]) -> tuple[str, frozenset[str]]:
    contents, imported = list[bytes](), set[str]()
    for name, content in files:
        tree = _tree(content) if name.endswith(".py") else None
        imported |= set() if tree is None else _strip(tree, without)
        contents += [name.encode(), content if tree is None else _written(tree)]
    return _hash(contents), frozenset(imported)


def parsed_file(content: bytes) -> bytes:
    """Return the syntax tree of a module without docstrings, as bytes; the content itself if it cannot be parsed."""
    if (tree := _tree(content)) is None:
        return content
    _strip(tree)
    return _written(tree)


def _tree(content: bytes) -> ast.Module | None:
    """Return the syntax tree; None if the content is not Python of this version."""
    try:
        return ast.parse(content)
    except (SyntaxError, ValueError):
        return None


def _written(tree: ast.Module) -> bytes:
    return ast.dump(tree).encode(errors="surrogatepass")


def _strip(tree: ast.Module, without: frozenset[str] = frozenset()) -> set[str]:
    """Remove docstrings, and the named members of classes, from a tree in place; return the imported modules."""
    waiting, imported = list[ast.AST]([tree]), set[str]()
    while waiting:
        node = waiting.pop()
        imported.update(_imports(node))
        if isinstance(node, DEFINITIONS):
            dropped = without if isinstance(node, ast.ClassDef) else frozenset[str]()
            node.body = [part for part in node.body if not (_is_text(part) or _bound_name(part) in dropped)]
        # Expressions contain no statements, so only blocks are visited.
        waiting += [part for part in ast.iter_child_nodes(node) if isinstance(part, BLOCKS)]
    return imported


def _bound_name(node: ast.stmt) -> str:
    """Return the name of a definition or of a class attribute; empty for other statements."""
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", node)]
    return str(getattr(targets[0], "id", getattr(targets[0], "name", "")))


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _imports(node: ast.AST) -> list[str]:
    """Return the top-level names of the modules that a statement imports absolutely."""
    if isinstance(node, ast.Import):
        return [alias.name.partition(".")[0] for alias in node.names]
    absolute = isinstance(node, ast.ImportFrom) and not node.level
    return [(node.module or "").partition(".")[0]] if absolute else []  # type: ignore[attr-defined]


@cache
def framework_code() -> str:
    """Return a hash of the parts of the framework that produce evidence."""
    files = (file for room in MEASURING for file in _files_below(ROOT / room) if file.name not in SAYING)
    return _parse(((file.relative_to(ROOT).as_posix(), file.read_bytes()) for file in files), frozenset())[0]


def code_key(*kinds: type, of: str) -> str:
    """Return a hash of the code of the framework and of some classes, of libraries and a text; empty without source.

    Parameters
    ----------
    *kinds : type
        Classes of schemes and measures, and a class of each further package whose code counts.
    of : str
        What else determines a result.
    """
    codes = [code_of(kind) for kind in kinds]
    known = [code for code in codes if code is not None]
    if len(known) < len(codes):
        return ""
    libraries = sorted({*arithmetic(), *(name for code in known for name in code.libraries)})
    return _hash(map(str.encode, (of, framework_code(), *libraries, *(code.digest for code in known))))


def arithmetic() -> tuple[str, ...]:
    """Return the versions of Python and of the libraries that compute all numbers."""
    python = f"Python {_minor(platform.python_version())}"
    return (python, *(version for library in ARITHMETIC for version in _versions(library)))


def _files_below(home: Path) -> list[Path]:
    """Return the modules of a package, compiled ones included, or the module itself."""
    found = sorted(home.rglob("*")) if home.is_dir() else [home]
    return [file for file in found if file.name.endswith((".py", *EXTENSION_SUFFIXES)) and file.is_file()]


@cache
def _versions(top: str) -> tuple[str, ...]:
    """Return the distributions that provide a module, with versions; empty if it is not installed."""
    try:
        names = [metadata.distribution(top).metadata["Name"]]
    except (metadata.PackageNotFoundError, ValueError):
        # Look up the module in all distributions, which is slow; most have the name of their module.
        names = metadata.packages_distributions().get(top, [])
    return tuple(map(_version, names))


def _version(distribution: str) -> str:
    return f"{distribution} {_minor(metadata.version(distribution))}"


def _minor(version: str) -> str:
    """Return the first two components of a version, because later ones denote corrections only."""
    return ".".join(version.split(".")[:2])


def _hash(contents: Iterable[bytes]) -> str:
    digest = hashlib.blake2b(digest_size=12)
    for content in contents:
        digest.update(content + b"\0")
    return digest.hexdigest()
