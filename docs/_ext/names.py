"""The public names: a page for each room with a table of its names, and a page for each name."""

import inspect
import re
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1]
ROOMS = {
    "sdaeverify": "sdaeverify: schemes, problems, runs",
    "sdaeverify.measuring": "sdaeverify.measuring: for authors of measures",
    "sdaeverify.probing": "sdaeverify.probing: for authors of measures that probe one step",
    "sdaeverify.testing": "sdaeverify.testing: checks and claims as tests",
    "sdaeverify.numerics": "sdaeverify.numerics: small numerical tools",
    "sdaeverify.commands": "sdaeverify.commands: for authors of commands",
    "sdaeverify.studying": "sdaeverify.studying: plans, noise and the time loop",
    "sdaeverify.trees": "sdaeverify.trees: classes of equations of a form of one's own",
    "sdaeverify.errors": "sdaeverify.errors: what is raised",
    "sdaeverify_bridges.kit": "sdaeverify_bridges.kit: steps of other libraries",
    "sdaeverify_hunt": "sdaeverify_hunt: counterexamples among random problems",
    "sdaeverify_orders": "sdaeverify_orders: claims about classes of equations",
    "sdaeverify_lab.papers": "sdaeverify_lab.papers: experiments of papers",
    "sdaeverify_lab": "sdaeverify_lab: planted bugs and calibration cases",
    "sdaeverify_sealed": "sdaeverify_sealed: solvers that draw their own random numbers",
    "sdaeverify_wire": "sdaeverify_wire: programs in other languages",
}
# Groups of the first room, by the module that has a name; the first that fits.
GROUPS = {
    "Run and look": ("sdaeverify.api", "sdaeverify.report", "sdaeverify.testing"),
    "Write a scheme": ("sdaeverify.contracts", "sdaeverify.registry"),
    "What is known of a problem": ("sdaeverify.forms.truths", "sdaeverify.forms.controls", "sdaeverify.forms.traits"),
    "Forms of equations": ("sdaeverify.forms",),
    "Noise": ("sdaeverify.noise",),
    "What is raised": ("sdaeverify.errors",),
}
OTHERS = "Types and constants"


def name_pages() -> dict[str, str]:
    """Return the pages by name of their file."""
    pages = {f"api/{room}.rst": _room(room, title) for room, title in ROOMS.items()}
    return pages | {f"api/{_file(room, name)}.rst": _page(room, name) for room in ROOMS for name in _own(room)}


def _public(room: str) -> list[str]:
    return sorted((name for name in import_module(room).__all__ if not name.startswith("_")), key=str.lower)


def _own(room: str) -> list[str]:
    """Return the names of which this is the first room."""
    return [name for name in _public(room) if _home(getattr(import_module(room), name), name) == room]


def _home(thing: Any, name: str) -> str:
    rooms = (import_module(room) for room in ROOMS if name in import_module(room).__all__)
    return next(room.__name__ for room in rooms if getattr(room, name) is thing)


def _file(room: str, name: str) -> str:
    """Return the file of a name; some systems do not tell ``Fit`` from ``fit``."""
    return f"{room}.{name}" + "-class" * (name[0].isupper() and name.lower() in _public(room))


def _room(room: str, title: str) -> str:
    """Return the page of a room: what it is for, and its names in groups, a line each."""
    about = [] if room == "sdaeverify" else [f".. automodule:: {room}", "   :no-members:", ""]
    groups: dict[str, list[str]] = {}
    for name in _public(room):
        groups.setdefault(_group(room, name), []).append(name)
    known = [*GROUPS, "Classes", "Functions", OTHERS]
    tables = (line for group in sorted(groups, key=known.index) for line in _table(room, group, groups[group]))
    pages = [f"   {_file(room, name)}" for name in _own(room)]
    return "\n".join([*_heading(title, "="), *about, *tables, ".. toctree::", "   :hidden:", "", *pages, ""])


def _group(room: str, name: str) -> str:
    thing = getattr(import_module(room), name)
    if not (inspect.isclass(thing) or inspect.isroutine(inspect.unwrap(thing))):
        return OTHERS
    if room != "sdaeverify":
        return "Classes" if inspect.isclass(thing) else "Functions"
    return next((group for group, modules in GROUPS.items() if thing.__module__.startswith(modules)), OTHERS)


def _heading(title: str, underline: str) -> list[str]:
    return [title, underline * len(title), ""]


def _table(room: str, title: str, names: Iterable[str]) -> Iterator[str]:
    things = {name: getattr(import_module(room), name) for name in names}
    yield from _heading(title, "-")
    yield from _rows(
        (f":doc:`{name} <{_file(_home(thing, name), name)}>`", _summary(thing)) for name, thing in things.items()
    )


def _rows(rows: Iterable[tuple[str, str]]) -> Iterator[str]:
    yield from (".. list-table::", "   :widths: 1 3", "")
    for name, told in rows:
        yield from (f"   * - {name}", f"     - {told}")
    yield ""


def _summary(thing: Any) -> str:
    """Return the first sentence of a docstring, in which nothing is markup."""
    if not (inspect.isclass(thing) or inspect.isroutine(thing) or inspect.ismodule(thing) or _is_property(thing)):
        return ""
    first = (inspect.getdoc(getattr(thing, "func", thing)) or "").partition("\n\n")[0]
    return re.sub(r"([*|\\]|_(?=\W|$))", r"\\\1", " ".join(first.replace("``", "`").replace("`", "``").split()))


def _is_property(thing: Any) -> bool:
    return isinstance(thing, property) or type(thing).__name__ == "cached_property"


def _page(room: str, name: str) -> str:
    """Return the page of a name."""
    thing = getattr(import_module(room), name)
    head = [*_heading(name, "="), f".. currentmodule:: {room}", ""]
    return "\n".join([*head, *_told(room, name, thing), *_used_in(name)])


def _told(room: str, name: str, thing: Any) -> Iterator[str]:
    if inspect.isclass(thing) and thing.__module__.startswith("sdaeverify"):
        yield from _class(room, name, thing)
    elif inspect.isroutine(inspect.unwrap(thing)):
        yield from (f".. autofunction:: {name}", "")
    elif inspect.ismodule(thing):
        yield from ((thing.__doc__ or "").strip(), "")
    else:
        yield from ("::", "", f"    {' '.join(repr(thing).split()):.300}", "")


def _class(room: str, name: str, thing: type) -> Iterator[str]:
    """Yield a class: what it is, a table of its properties and methods, and then each of them."""
    members = _members(thing)
    yield from (f".. autoclass:: {name}", *["   :show-inheritance:"] * (thing.__bases__ != (object,)), "")
    if members:
        yield from _heading("Properties and methods", "-")
        yield from _rows(
            (f":py:obj:`~{room}.{name}.{key}`", _summary(_plain(member))) for key, member in members.items()
        )
        for key, member in members.items():
            kind = "autoproperty" if _is_property(member) else "automethod"
            yield from (f".. {kind}:: {name}.{key}", "")


def _members(thing: type) -> dict[str, Any]:
    """Return properties and methods that have a docstring: those of the class, and of bases that have no page."""
    bases = [base for base in thing.__mro__ if base is thing or not _has_page(base)]
    found = {key: member for base in reversed(bases) for key, member in vars(base).items() if not key.startswith("_")}
    return {key: member for key, member in found.items() if _is_member(member) and _summary(_plain(member))}


def _is_member(member: Any) -> bool:
    return _is_property(member) or inspect.isroutine(_plain(member))


def _plain(member: Any) -> Any:
    return member.__func__ if isinstance(member, classmethod | staticmethod) else member


def _has_page(base: type) -> bool:
    rooms = map(import_module, ROOMS)
    return not base.__module__.startswith("sdaeverify") or any(getattr(r, base.__name__, None) is base for r in rooms)


def _used_in(name: str) -> Iterator[str]:
    """Yield the pages and programs that import a name of the package, or call it by its name."""
    used = re.compile(rf"^(?:from sdaeverify\S* )?import [^\n]*\b{name}\b|\bsdaeverify\.{name}\b", re.MULTILINE)
    pages = [
        path for path in [*sorted(DOCS.glob("[!g_]*/*.md")), DOCS / "tutorial.md"] if used.search(path.read_text())
    ]
    programs = [path for path in sorted((DOCS / "gallery").glob("*.py")) if used.search(path.read_text())]
    links = [f":doc:`/{path.relative_to(DOCS).with_suffix('')}`" for path in pages]
    links += [f":doc:`/gallery_pages/{path.stem}`" for path in programs]
    if links:
        yield f"Used in: {', '.join(links)}."
        yield ""
