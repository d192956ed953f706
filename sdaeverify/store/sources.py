"""What code a scheme, problem or measure is made of: a hash of its module and of what that imports of its package.

Installed packages of others count by their version, modules of others that are installed nowhere by their source, and
those of the framework too. What a function imports only when it is called counts.
"""

import builtins
import hashlib
import os
import platform
import sys
from collections.abc import Hashable, Iterable, Iterator, Sequence
from enum import Enum
from functools import cache, cached_property, partial
from importlib import metadata
from importlib.machinery import EXTENSION_SUFFIXES, ModuleSpec
from importlib.util import find_spec
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any, NamedTuple, cast

import numpy as np

from .imports import find_imports

FRAMEWORK = "sdaeverify"
# The module that runs schemes on paths.
RUNNER = f"{FRAMEWORK}.simulate.ensemble"
# Packages whose arithmetic the numbers come from.
ARITHMETIC = ("numpy", "scipy")
# Folders of installed packages.
INSTALLED = frozenset({"site-packages", "dist-packages"})
UNKNOWN = ""
# What imports modules that no import statement names.
DYNAMIC = (b"import_module", b"__import__")
CACHED = "__pycache__"
# Files of a distribution that are looked at, and seconds that it takes to install one.
CODE = frozenset({".py", *EXTENSION_SUFFIXES, ".json", ".txt", ".csv", ".npy", ".npz", ".toml", ".yaml"})
PATIENCE = 60.0


@cache
def framework_source() -> str:
    """Return a hash of what runs schemes on paths, and the versions of what it computes with."""
    python = ".".join(platform.python_version_tuple()[:2])
    versions = " ".join(f"{name} {metadata.version(name)}" for name in ARITHMETIC)
    return f"{source_of(RUNNER)}, Python {python}, {versions}"


@cache
def source_of(module: str) -> str:
    """Return a hash of a module's file and of those it imports from its own package, with versions of the others.

    Parameters
    ----------
    module : str
        Dotted name of a module that is imported.

    Returns
    -------
    str
        Empty if there is no source to be read, so that nothing can be said about what it does.
    """
    files, foreign = _gather_files(module)
    return ", ".join([contents(module, files), *map(_version, sorted(foreign))]) if files else UNKNOWN


def files_of(module: str) -> tuple[Path, ...]:
    """Return the files that count for a module; none if there is no source to be read."""
    return _gather_files(module)[0]


def contents(module: str, files: Iterable[Path]) -> str:
    """Return a hash of what files held when this process first read them for a module.

    A plugin file that was saved and loaded again is another module, which the import system knows nothing of.
    """
    edition = "" if getattr(sys.modules.get(module), "__spec__", None) else module
    return _hash(_content(file, edition) for file in files)


@cache
def _content(file: Path, edition: str = "") -> bytes:  # noqa: ARG001 - of another edition it is read again
    return hashlib.blake2b(file.read_bytes(), digest_size=16).digest() if file.is_file() else b""


@cache
def _gather_files(module: str) -> tuple[tuple[Path, ...], frozenset[str]]:
    """Return the files that count for a module, and the other packages."""
    file = getattr(sys.modules.get(module), "__file__", None)
    if not (file and file.endswith(".py") and Path(file).is_file()):
        return (), frozenset()
    files, foreign = _closure(module, Path(file))
    return tuple(dict.fromkeys([*files, *_find_unnamed_files(module, files)])), frozenset(foreign)


def _find_unnamed_files(module: str, files: Sequence[Path]) -> Iterator[Path]:
    """Yield what no import names: data in packages of third parties, and all of one that imports by name."""
    top = module.partition(".")[0]
    folders = {next(p for p in f.parents if p.name == top) for f in files if top in {p.name for p in f.parents}}
    if top == FRAMEWORK or not folders:
        return
    dynamic = any(map(_imports_by_name, files))
    for folder in sorted(folders):
        yield from (file for file in _files_in(folder) if dynamic or file.suffix != ".py")


@cache
def _imports_by_name(file: Path) -> bool:
    return file.suffix == ".py" and any(word in file.read_bytes() for word in DYNAMIC)


@cache
def _files_in(folder: Path) -> tuple[Path, ...]:
    return tuple(sorted(path for path in folder.rglob("*") if path.is_file() and CACHED not in path.parts))


def _closure(start: str, first: Path) -> tuple[list[Path], set[str]]:
    """Return the files of a module and of all it imports whose source counts, and the other packages."""
    files: dict[str, Path] = {}
    foreign: set[str] = set()
    depth = start.count(".") + (first.name == "__init__.py")
    package = start.partition(".")[0], first.parents[depth - 1] if depth else None
    waiting = [(start, first)]
    while waiting:
        name, file = waiting.pop()
        if name not in files:
            files[name] = file
            found, others = _resolve_imports(name, file, *package)
            waiting += found
            foreign |= others
    return [files[name] for name in sorted(files)], foreign


@cache
def _resolve_imports(
    module: str, file: Path, own: str, folder: Path | None
) -> tuple[tuple[tuple[str, Path], ...], frozenset[str]]:
    """Return the modules that a module imports and their files, and the other packages.

    Parameters
    ----------
    module : str
    file : Path
        That it is in.
    own : str
        Name of the package whose modules count.
    folder : Path or None
        That it is in; None for a module that is in no package.
    """
    files: dict[str, Path] = {}
    foreign = set()
    for name in find_imports(module, file) if file.suffix == ".py" else ():
        top = name.partition(".")[0]
        inside = _file_below(folder, name) if folder is not None and top == own else None
        source = inside or _local_file(name, own)
        if source is not None:
            files.setdefault(_module_of(name, source), source)
        elif _is_foreign(name, own):
            foreign.add(top)
    return tuple(files.items()), frozenset(foreign)


def _local_file(name: str, own: str) -> Path | None:
    """Return the file of a module of the framework, or of another that is not among the installed packages."""
    top = name.partition(".")[0]
    if top in {own, *ARITHMETIC} or top in sys.stdlib_module_names:
        return None
    spec = _spec(top)
    if spec is not None and spec.origin is None:
        # A folder without __init__.py.
        folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
        found = (_file_below(folder, name) for folder in folders if not INSTALLED & set(folder.parts))
        return next((file for file in found if file is not None), None)
    if spec is None or not (spec.origin and spec.origin.endswith(".py")):
        return None
    file = Path(spec.origin)
    if top != FRAMEWORK and INSTALLED & set(file.parts):
        return None
    package = top == FRAMEWORK or (spec.submodule_search_locations and name != top)
    return _file_below(file.parent, name) if package else file


@cache
def _file_below(package: Path, name: str) -> Path | None:
    """Return the source or the extension of a module, given the folder of its outermost package."""
    parts = name.split(".")
    if len(parts) < 2:
        return None
    stem = package.joinpath(*parts[1:])
    endings = (".py", *EXTENSION_SUFFIXES)
    candidates = [stem / "__init__.py", *(stem.with_name(f"{stem.name}{ending}") for ending in endings)]
    # What is defined in the package itself; that of the framework only collects the names of its modules.
    if len(parts) == 2 and parts[0] != FRAMEWORK:
        candidates.append(package / "__init__.py")
    return next((file for file in candidates if file.is_file()), None)


def _module_of(name: str, file: Path) -> str:
    """Return the module of an imported name: the package where the name is one of its attributes."""
    attribute = file.name == "__init__.py" and file.parent.name != name.rpartition(".")[2]
    return name.rpartition(".")[0] if attribute else name


@cache
def _spec(package: str) -> ModuleSpec | None:
    try:
        return find_spec(package)
    except (ImportError, ValueError):
        return None


def _is_foreign(name: str, own: str) -> bool:
    top = name.partition(".")[0]
    known = {FRAMEWORK, *ARITHMETIC, own}
    return top not in sys.stdlib_module_names and top not in known


@cache
def _version(package: str) -> str:
    names = [package] if _is_distribution(package) else sorted(metadata.packages_distributions().get(package, []))
    return ", ".join(f"{name} {metadata.version(name)} {_contents(name)}" for name in names) or package


def _contents(distribution: str) -> str:
    """Return a hash of the hashes of a distribution's files: it may be installed anew under the same version.

    Files that were saved since it was installed count by what they hold.
    """
    record = metadata.distribution(distribution).read_text("RECORD") or ""
    lines = sorted(line for line in record.splitlines() if ".dist-info/" not in line and ".pyc" not in line)
    return _hash([*(line.encode() for line in lines), *map(_content, _find_edited_files(distribution))])


def _find_edited_files(distribution: str) -> list[Path]:
    places = [Path(str(file.locate())) for file in metadata.distribution(distribution).files or ()]
    record = next((place for place in places if place.name == "RECORD" and place.is_file()), None)
    if record is None:
        return []
    installed = record.stat().st_mtime + PATIENCE
    code = (place for place in places if place.suffix in CODE and place.is_file())
    return sorted(place for place in code if place.stat().st_mtime > installed)


def _is_distribution(name: str) -> bool:
    try:
        return bool(metadata.version(name))
    except metadata.PackageNotFoundError:
        return False


def _hash(contents: Iterable[bytes]) -> str:
    digest = hashlib.blake2b(digest_size=12)
    for content in contents:
        digest.update(content + b"\0")
    return digest.hexdigest()


# What loaded code is made of: the functions, classes and constants that a thing reaches, whoever wrote them there.
#
# Files may have been saved since they were imported, and a module may set what another one defines; what is in memory
# is what runs. Code of the library, of numpy, scipy and the framework counts by its name here.


# Things that are looked at: of a large package of somebody else, those that are reached first.
MOST = 20_000
# Bytes of a file that is named; of a longer one, its size and time count.
LARGEST = 2**24
KNOWN = frozenset({*sys.stdlib_module_names, *ARITHMETIC, FRAMEWORK})
PLAIN = (type(None), bool, int, float, complex, bytes, str, type(Ellipsis), range, np.generic)
# What a class has beside what its author wrote.
BOOKKEEPING = frozenset(
    {
        *("__dict__", "__weakref__", "__module__", "__doc__", "__hash__", "__match_args__", "__parameters__"),
        *("__annotations__", "__annotate_func__", "__annotations_cache__", "__firstlineno__", "__orig_bases__"),
        *(
            "__dataclass_fields__",
            "__dataclass_params__",
            "__static_attributes__",
            "__abstractmethods__",
            "_abc_impl",
        ),
    }
)


class Reached(NamedTuple):
    """What a thing says by itself, and what it reaches."""

    words: tuple[object, ...]
    things: tuple[Any, ...] = ()


@cache
def code_of(thing: Any) -> str:
    """Return a digest of what a scheme, problem function or measure is made of, as it is when first asked for.

    Texts in its code that name a variable of the environment or a file count with the content of that.

    Parameters
    ----------
    thing : object

    Returns
    -------
    str
    """
    digest, waiting, seen = hashlib.blake2b(digest_size=12), [thing], dict[int, Any]()
    while waiting and len(seen) < MOST:
        one = waiting.pop()
        if id(one) in seen and not isinstance(one, PLAIN):
            digest.update(b"again\0")
            continue
        seen[id(one)] = one
        words, things = _reach_from(one)
        digest.update(repr((*words, len(things))).encode(errors="replace") + b"\0")
        waiting += reversed(things)
    return digest.hexdigest()


def _reach_from(thing: Any) -> Reached:
    kind = type(thing)
    if isinstance(thing, PLAIN):
        return Reached((kind.__name__, thing, *(_resolve_text(thing) if isinstance(thing, str) else ())))
    if (look := _look_for(cast("Hashable", kind))) is not None:
        reached: Reached = look(thing)
        return reached
    wrapped = getattr(thing, "__wrapped__", None) if callable(thing) else None
    if wrapped is not None:
        return Reached((kind.__name__,), (wrapped,))
    return _object(thing)


def _function(function: FunctionType) -> Reached:
    if _is_known(function):
        return Reached((function.__module__, function.__qualname__))
    code, space = function.__code__, function.__globals__
    names = sorted({name for one in _codes(code) for name in one.co_names})
    cells = [cell.cell_contents for cell in function.__closure__ or () if _is_filled(cell)]
    found = [(name, space[name]) for name in names if name in space]
    values = [value for _, global_value in found for value in _find_used_values(global_value, names)]
    given = (function.__defaults__, function.__kwdefaults__, vars(function))
    return Reached(tuple(name for name, _ in found), (code, *given, *cells, *values))


def _code(code: CodeType) -> Reached:
    folder = Path(code.co_filename).parent
    texts = [text for text in code.co_consts if isinstance(text, str)]
    named = tuple(word for text in texts for word in _resolve_text(text, folder))
    words = (code.co_name, code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_flags)
    return Reached((*words, *named), code.co_consts)


def _class(kind: type) -> Reached:
    if _is_known(kind):
        return Reached((kind.__module__, kind.__qualname__))
    own = {name: value for name, value in sorted(vars(kind).items()) if name not in BOOKKEEPING}
    return Reached((kind.__name__, *own), (*kind.__bases__, *own.values()))


def _object(thing: Any) -> Reached:
    kind = type(thing)
    lazy, slots = _attributes(cast("Hashable", kind))
    own = {name: value for name, value in sorted(getattr(thing, "__dict__", {}).items()) if name not in lazy}
    own |= {name: getattr(thing, name) for name in slots if hasattr(thing, name)}
    return Reached(tuple(own), (kind, *own.values()))


@cache
def _attributes(kind: Any) -> tuple[frozenset[str], tuple[str, ...]]:
    """Return which attributes a class fills in later, and which its instances have in slots."""
    named = [(name, value) for base in kind.__mro__ for name, value in vars(base).items()]
    slots = [vars(base).get("__slots__", ()) for base in kind.__mro__ if not _is_known(base)]
    given = [name for slot in slots for name in ((slot,) if isinstance(slot, str) else slot)]
    return frozenset(name for name, value in named if isinstance(value, cached_property)), tuple(given)


def _array(array: Any) -> Reached:
    if array.dtype.hasobject:
        return Reached((array.shape,), tuple(array.flat))
    return Reached((array.dtype.str, array.shape, hashlib.blake2b(array.tobytes()).hexdigest()))


def _path(path: Path) -> Reached:
    return Reached((path.name, *_describe_file(path)))


LOOKS: tuple[tuple[Any, Any], ...] = (
    ((BuiltinFunctionType, np.ufunc), lambda function: Reached((function.__name__,))),
    (FunctionType, _function),
    (CodeType, _code),
    (type, _class),
    (Enum, lambda member: Reached((type(member).__name__, member.name))),
    ((tuple, list), lambda row: Reached((type(row).__name__,), tuple(row))),
    (dict, lambda table: Reached(("dict",), tuple(part for pair in table.items() for part in pair))),
    ((set, frozenset), lambda bag: Reached(("set", *sorted(map(_describe_element, bag))))),
    (np.ndarray, _array),
    (Path, _path),
    (ModuleType, lambda module: Reached(("module", module.__name__.rpartition(".")[2]))),
    (MethodType, lambda method: Reached(("method",), (method.__func__, method.__self__))),
    ((staticmethod, classmethod), lambda method: Reached(("method",), (method.__func__,))),
    (property, lambda given: Reached(("property",), (given.fget,))),
    (cached_property, lambda given: Reached(("property",), (given.func,))),
    (partial, lambda call: Reached(("partial",), (call.func, call.args, call.keywords))),
)


@cache
def _look_for(kind: Any) -> Any:
    return next((look for known, look in LOOKS if issubclass(kind, known)), None)


def _describe_element(element: Any) -> str:
    return repr(element) if isinstance(element, PLAIN) else type(element).__name__


def _find_used_values(value: Any, names: list[str]) -> Iterator[Any]:
    """Yield a global value; of a module of somebody's own, its attributes that the code names."""
    yield value
    if isinstance(value, ModuleType) and value.__name__.partition(".")[0] not in KNOWN:
        for name in names:
            if name in vars(value):
                yield from _find_used_values(vars(value)[name], [other for other in names if other != name])


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _is_known(thing: Any) -> bool:
    """Tell whether code is that of the library or the framework, and not only says so."""
    module = getattr(thing, "__module__", None) or ""
    if module.partition(".")[0] not in KNOWN:
        return False
    found: Any = sys.modules.get(module)
    for name in thing.__qualname__.split("."):
        found = getattr(found, name, None) if found is not None else None
    return found is thing or hasattr(builtins, thing.__qualname__)


def _is_filled(cell: Any) -> bool:
    try:
        return cell.cell_contents is not cell
    except ValueError:
        return False


def _resolve_text(text: str, folder: Path | None = None) -> Iterator[object]:
    """Yield what a text may stand for in the environment, and the content of a file of this name."""
    if text in os.environ:
        yield os.environ[text]
    if "." in text[1:] and len(text) < 256 and not any(letter.isspace() for letter in text):
        for place in {Path(text): 0, **({folder / text: 0} if folder else {})}:
            yield from _describe_file(place)


def _describe_file(path: Path) -> Iterator[object]:
    try:
        if path.is_file():
            size = path.stat().st_size
            yield hashlib.blake2b(path.read_bytes()).hexdigest() if size <= LARGEST else (size, path.stat().st_mtime)
    except (OSError, ValueError):
        return
