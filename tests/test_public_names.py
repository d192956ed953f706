"""The public names: each is there, imported by whoever asks for it first."""

import ast
import inspect
import pydoc
import re
import subprocess
import sys
import textwrap
from enum import Enum
from pathlib import Path

import pytest

import sdaeverify

pytestmark = pytest.mark.quick


def test_public_names_are_those_of_the_stub():
    """Type checkers and whoever imports see the same names, each as itself."""
    stub = ast.parse(Path(sdaeverify.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    names = [name for node in stub.body if isinstance(node, ast.ImportFrom) for name in node.names]

    assert {name.asname for name in names} == {name.name for name in names} == {*sdaeverify.__all__} - {"__version__"}


def test_every_public_name_is_there():
    """A name comes from the module the table says."""
    assert [name for name in sdaeverify.__all__ if getattr(sdaeverify, name) is None] == []
    assert set(sdaeverify.__all__) <= set(dir(sdaeverify))


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
    lines = [row for line in told.splitlines() for row in textwrap.wrap(line, COLUMNS) or [""]]

    assert len(lines) <= SCREEN
    assert [each for each in inspect.signature(form).parameters if told.count(each) < 2] == []
    assert max(map(len, methods.partition("__init__")[2].splitlines()[:1])) < 10 * COLUMNS
