"""Docstrings of public functions: with three arguments or more, a section says what each of them is."""

import ast
import re
from pathlib import Path
from typing import NamedTuple

import pytest

pytestmark = pytest.mark.quick
ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("sdaeverify", "plugins", "problems")
MANY = 3
SECTION = re.compile(r"^(?:Parameters|Attributes)\n-+\n(.*?)(?:\n\n\w[\w ]*\n-+\n|\Z)", re.DOTALL | re.MULTILINE)


class Function(NamedTuple):
    """A function, or a method with its class."""

    place: str
    node: ast.FunctionDef
    owner: str = ""

    @property
    def key(self):
        """What a method of a base and one that overrides it have in common."""
        return self.node.name, tuple(arguments(self.node))

    @property
    def public(self):
        """Whether no name on the way to it begins with an underscore."""
        place = Path(self.place.removesuffix("/__init__.py")).parts
        return not any(part.startswith("_") for part in (*place, self.owner, self.node.name))


def arguments(node):
    """Return the names of a function's arguments, without self and cls."""
    given = node.args
    named = [a.arg for a in (*given.posonlyargs, *given.args, *given.kwonlyargs) if a.arg not in {"self", "cls"}]
    return named + ([given.vararg.arg] if given.vararg else [])


def explained(node):
    """Return what the section of parameters says of each argument, beside its type."""
    found, names = {}, []
    section = SECTION.search(ast.get_docstring(node) or "")
    for line in section[1].splitlines() if section else ():
        if line and not line.startswith(" "):
            names = [name.strip(" *") for name in line.partition(" : ")[0].split(",")]
            found |= dict.fromkeys(names, "")
        else:
            found |= {name: found[name] + line for name in names}
    return found


def unexplained(node):
    """Return the arguments without an entry; all of them where entries are names and types alone."""
    told = explained(node)
    return [name for name in arguments(node) if name not in told or not any(told.values())]


def contents(sources):
    """Return the functions and methods of modules, given as places with their text, and the bases of each class."""
    functions, bases = [], {}
    for place, text in sources:
        for node in ast.parse(text).body:
            inner = node.body if isinstance(node, ast.ClassDef) else [node]
            owner = node.name if isinstance(node, ast.ClassDef) else ""
            functions += [Function(place, each, owner) for each in inner if isinstance(each, ast.FunctionDef)]
            if owner:
                bases[owner] = [ast.unparse(base).partition("[")[0].rpartition(".")[2] for base in node.bases]
    return functions, bases


def is_command(node):
    """Tell whether a function is a command: its help is that of its options."""
    return any("click.command" in ast.unparse(decorator) for decorator in node.decorator_list)


def ancestors(owner, bases):
    """Yield the names of the bases of a class and of theirs."""
    for base in bases.get(owner, ()):
        yield base
        yield from ancestors(base, bases)


def wanting(sources):
    """Return the public functions with an argument that is nowhere explained.

    A method needs no section of its own where one of its name and arguments has it: in a base, near or far, or in a
    protocol.
    """
    functions, bases = contents(sources)
    told = {(each.owner, *each.key) for each in functions if not unexplained(each.node)}
    protocols = {tuple(key) for owner, *key in told if "Protocol" in bases.get(owner, ())}
    return [
        f"{each.place}: {each.owner}{'.' * bool(each.owner)}{each.node.name}: {', '.join(missing)}"
        for each in functions
        if each.public and len(arguments(each.node)) >= MANY and not is_command(each.node)
        if (missing := unexplained(each.node)) and each.key not in protocols
        if not any((base, *each.key) in told for base in ancestors(each.owner, bases))
    ]


def modules():
    """Yield the modules of the framework and of what is shipped."""
    for path in sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")):
        yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")


def test_arguments_of_public_functions_are_explained():
    """Whoever reads a function with three arguments or more finds what each is, in its own words or its base's."""
    assert wanting(modules()) == []


HEAD = "def f(t, x, h):"
SOUND = '"""Do.\n\n    Parameters\n    ----------\n    t, h : float\n        Times.\n    x : Array\n    """'


@pytest.mark.parametrize(
    ("source", "found"),
    [
        (f"{HEAD}\n    {SOUND}", []),
        (f"{HEAD}\n    '''Do.'''", ["m.py: f: t, x, h"]),
        (f"{HEAD}\n    {SOUND.replace('t, h', 't')}", ["m.py: f: h"]),
        (f"{HEAD}\n    {SOUND.replace('        Times.', '')}", ["m.py: f: t, x, h"]),
        ("def f(t, x):\n    pass", []),
        (f"class A:\n    {HEAD}\n        pass", ["m.py: A.f: t, x, h"]),
        (f"class A:\n    {HEAD}\n        {SOUND}\nclass B(A):\n    {HEAD}\n        pass", []),
        (f"class A:\n    {HEAD}\n        {SOUND}\nclass B:\n    {HEAD}\n        pass", ["m.py: B.f: t, x, h"]),
        (f"class _A:\n    {HEAD}\n        {SOUND}\nclass B(_A): ...\nclass C(B):\n    {HEAD}\n        pass", []),
        ("def _f(t, x, h):\n    pass", []),
        (f"class A(Protocol):\n    {HEAD}\n        {SOUND}\nclass B:\n    {HEAD}\n        pass", []),
    ],
)
def test_what_is_not_explained_is_found(source, found):
    """A section may be a base's or a protocol's; names and types alone explain nothing."""
    assert wanting([("m.py", source)]) == found
