"""What loaded code is made of: the functions, classes and constants that a thing reaches, whoever wrote them there.

Files may have been saved since they were imported, and a module may set what another one defines; what is in memory
is what runs. Code of the library, of numpy, scipy and the framework counts by its name here.
"""

import builtins
import hashlib
import os
import sys
from collections.abc import Hashable, Iterator
from enum import Enum
from functools import cache, cached_property, partial
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any, NamedTuple, cast

import numpy as np

from .sources import ARITHMETIC, FRAMEWORK

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
        words, things = _reached(one)
        digest.update(repr((*words, len(things))).encode(errors="replace") + b"\0")
        waiting += reversed(things)
    return digest.hexdigest()


def _reached(thing: Any) -> Reached:
    kind = type(thing)
    if isinstance(thing, PLAIN):
        return Reached((kind.__name__, thing, *(_meant(thing) if isinstance(thing, str) else ())))
    for known, look in LOOKS:
        if isinstance(thing, known):
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
    values = [value for _, global_value in found for value in _used(global_value, names)]
    given = (function.__defaults__, function.__kwdefaults__, vars(function))
    return Reached(tuple(name for name, _ in found), (code, *given, *cells, *values))


def _code(code: CodeType) -> Reached:
    folder = Path(code.co_filename).parent
    texts = [text for text in code.co_consts if isinstance(text, str)]
    named = tuple(word for text in texts for word in _meant(text, folder))
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
    return Reached((path.name, *_content(path)))


LOOKS: tuple[tuple[Any, Any], ...] = (
    ((BuiltinFunctionType, np.ufunc), lambda function: Reached((function.__name__,))),
    (FunctionType, _function),
    (CodeType, _code),
    (type, _class),
    (Enum, lambda member: Reached((type(member).__name__, member.name))),
    ((tuple, list), lambda row: Reached((type(row).__name__,), tuple(row))),
    (dict, lambda table: Reached(("dict",), tuple(part for pair in table.items() for part in pair))),
    ((set, frozenset), lambda bag: Reached(("set", *sorted(map(_shown, bag))))),
    (np.ndarray, _array),
    (Path, _path),
    (ModuleType, lambda module: Reached(("module", module.__name__.rpartition(".")[2]))),
    (MethodType, lambda method: Reached(("method",), (method.__func__, method.__self__))),
    ((staticmethod, classmethod), lambda method: Reached(("method",), (method.__func__,))),
    (property, lambda given: Reached(("property",), (given.fget,))),
    (cached_property, lambda given: Reached(("property",), (given.func,))),
    (partial, lambda call: Reached(("partial",), (call.func, call.args, call.keywords))),
)


def _shown(element: Any) -> str:
    return repr(element) if isinstance(element, PLAIN) else type(element).__name__


def _used(value: Any, names: list[str]) -> Iterator[Any]:
    """Yield a global value; of a module of somebody's own, its attributes that the code names."""
    yield value
    if isinstance(value, ModuleType) and value.__name__.partition(".")[0] not in KNOWN:
        for name in names:
            if name in vars(value):
                yield from _used(vars(value)[name], [other for other in names if other != name])


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


def _meant(text: str, folder: Path | None = None) -> Iterator[object]:
    """Yield what a text may stand for in the environment, and the content of a file of this name."""
    if text in os.environ:
        yield os.environ[text]
    if "." in text[1:] and len(text) < 256 and not any(letter.isspace() for letter in text):
        for place in {Path(text): 0, **({folder / text: 0} if folder else {})}:
            yield from _content(place)


def _content(path: Path) -> Iterator[object]:
    try:
        if path.is_file():
            size = path.stat().st_size
            yield hashlib.blake2b(path.read_bytes()).hexdigest() if size <= LARGEST else (size, path.stat().st_mtime)
    except (OSError, ValueError):
        return
