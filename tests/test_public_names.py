"""The public names: each is there, imported by whoever asks for it first, and explains its arguments."""

import ast
import inspect
import pydoc
import re
import subprocess
import sys
import textwrap
from enum import Enum
from pathlib import Path
from typing import NamedTuple

import pytest

import sdaeverify
import sdaeverify_hunt
import sdaeverify_orders
from source_trees import ROOT, parsed, sources

pytestmark = pytest.mark.quick
FOLDERS = [ROOT / folder for folder in ("sdaeverify", "plugins", "problems")]
MANY = 3
SECTION = re.compile(r"^(?:Parameters|Attributes)\n-+\n(.*?)(?:\n\n\w[\w ]*\n-+\n|\Z)", re.DOTALL | re.MULTILINE)


def test_public_names_are_those_of_the_stub():
    """Type checkers and whoever imports see the same names, each as itself."""
    stub = ast.parse(Path(sdaeverify.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    names = [name for node in stub.body if isinstance(node, ast.ImportFrom) for name in node.names]

    assert {name.asname for name in names} == {name.name for name in names} == {*sdaeverify.__all__} - {"__version__"}


def test_every_public_name_is_there():
    """A name comes from the module the table says."""
    assert [name for name in sdaeverify.__all__ if getattr(sdaeverify, name) is None] == []
    assert set(sdaeverify.__all__) <= set(dir(sdaeverify))


def test_functions_of_plugins_are_attributes():
    """What the entry points of plugins name is found in the package as well."""
    assert (sdaeverify.orders, sdaeverify.hunt) == (sdaeverify_orders.orders, sdaeverify_hunt.hunt)
    assert sdaeverify.modified_equations is sdaeverify_orders.modified_equations


def test_no_other_name_is_there():
    """A misspelt name is missing, as in any other module."""
    with pytest.raises(AttributeError, match="has no attribute 'Shceme'"):
        sdaeverify.Shceme  # noqa: B018


def test_importing_the_package_is_cheap():
    """The package alone, and the plugin that every run of pytest loads, import neither numpy nor anything slow."""
    heavy = ["numpy", "scipy", "pandas", "rich", "click", "pluggy", "sdaeverify.registry.load"]
    code = f"import sys, sdaeverify; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.strip() == "[]"


def arguments_without_a_word(thing):
    """Return the arguments of a class or function with three or more that its documentation does not name."""
    names = [name for name in inspect.signature(thing).parameters if name not in {"args", "kwargs"}]
    told = set(re.findall(r"\w+", inspect.getdoc(thing) or ""))
    sections = re.search(r"^(Parameters|Attributes)$", inspect.getdoc(thing) or "", re.MULTILINE)
    return [name for name in names if name not in told or not sections] if len(names) >= 3 else []


def test_every_argument_of_a_public_name_is_explained():
    """Whoever calls one of the package's classes or functions with three arguments finds each in its help."""
    things = {name: getattr(sdaeverify, name) for name in sdaeverify.__all__}
    own = {
        name: thing
        for name, thing in things.items()
        if inspect.isfunction(thing) or (inspect.isclass(thing) and not issubclass(thing, (Enum, Exception)))
    }
    assert {name: missing for name, thing in own.items() if (missing := arguments_without_a_word(thing))} == {}


FORMS = ("SDE", "Langevin", "IndexOneSDAE", "DelaySDAE", "HolonomicSDAE", "ConstrainedLangevin")
SCREEN, COLUMNS = 54, 120


@pytest.mark.parametrize("name", FORMS)
def test_the_help_of_a_form_begins_with_all_of_it(name):
    """One screen of `help` has the equation and every argument, with what each is; methods come after."""
    form = getattr(sdaeverify, name)
    told, _, methods = pydoc.plain(pydoc.render_doc(form)).partition("Method resolution order:")
    # Python 3.13 writes a signature with a line for each argument: it is taken away, one line instead.
    stripped = "\n".join(map(str.rstrip, told.splitlines()))
    _, _, described = stripped.partition("\n |\n")
    lines = [row for line in described.splitlines() for row in textwrap.wrap(line, COLUMNS) or [""]]

    assert 1 <= len(lines) <= SCREEN - len(textwrap.wrap(str(inspect.signature(form)), COLUMNS))
    assert [each for each in inspect.signature(form).parameters if told.count(each) < 2] == []
    assert max(map(len, methods.partition("__init__")[2].splitlines()[:1])) < 10 * COLUMNS


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


def contents(trees):
    """Return the functions and methods of modules, given as places with their trees, and the bases of each class."""
    functions, bases = [], {}
    for place, tree in trees:
        for node in tree.body:
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


def wanting(trees):
    """Return the public functions with an argument that is nowhere explained.

    A method needs no section of its own where one of its name and arguments has it: in a base, near or far, or in a
    protocol.
    """
    functions, bases = contents(trees)
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
    for path in sources(*FOLDERS):
        yield path.relative_to(ROOT).as_posix(), parsed(path)


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
    assert wanting([("m.py", ast.parse(source))]) == found
