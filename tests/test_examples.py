"""Public names have examples: programs of the site that run, or examples of a docstring."""

import inspect
import re
from pathlib import Path

import pytest

import sdaeverify
from sdaeverify.numerics import __all__ as numerical

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "reference" / "examples.md"
# Fences whose content is a program, and files that pages include.
PROGRAMS = re.compile(r"```(?:\{file\} \S+\.py|\{python\}|python)\n(.*?)```", re.DOTALL)
INCLUDED = re.compile(r":from: (\S+\.py)|\{literalinclude\} \.\./\.\./(\S+\.py)")
# Names of `sdaeverify.numerics` without an example; the number may only fall.
WITHOUT = 12


def programs(text):
    """Return the programs on a page."""
    return [re.sub(r"(?m)^:picture:.*\n", "", found) for found in PROGRAMS.findall(text)]


def shown():
    """Return all programs of the site, and of the files that its pages include."""
    pages = [path.read_text(encoding="utf-8") for path in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))]
    pages += [path.read_text(encoding="utf-8") for path in (ROOT / "docs").glob("[ehr]*/*.md")]
    files = {ROOT / (own or other) for page in pages for own, other in INCLUDED.findall(page)}
    texts = [program for page in pages for program in programs(page)]
    return "\n".join([*texts, *(path.read_text(encoding="utf-8") for path in (*files, *gallery()))])


def gallery():
    """Return the programs of the gallery."""
    return (ROOT / "docs" / "gallery").glob("*.py")


def has_own(thing):
    """Return whether a docstring of a name, or of one of its methods, has an example."""
    members = vars(thing).values() if inspect.isclass(thing) else ()
    return any(">>>" in (inspect.getdoc(each) or "") for each in (thing, *members))


def without_example(names, room):
    """Return the public names that no program and no docstring shows."""
    text = shown()
    return [name for name in names if not re.search(rf"\b{name}\b", text) and not has_own(getattr(room, name))]


def test_every_name_of_the_package_has_an_example():
    """Each is in a program of the site, of the README or of its docstring; a name that is not is found."""
    assert without_example(sdaeverify.__all__, sdaeverify) == []
    assert not re.search(r"\bnobody_shows_this\b", shown())


def test_names_of_the_numerical_tools_without_example():
    """They get fewer."""
    assert len(without_example(numerical, sdaeverify.numerics)) <= WITHOUT


@pytest.mark.long
@pytest.mark.parametrize("number", range(len(programs(PAGE.read_text(encoding="utf-8")))))
def test_examples_of_names_run(number, monkeypatch, tmp_path):
    """Each program of the page of examples runs by itself."""
    monkeypatch.chdir(tmp_path)
    if "hunt(" in (program := programs(PAGE.read_text(encoding="utf-8"))[number]):
        pytest.importorskip("hypothesis", reason="needs the extra hunt")
    exec(compile(program, f"{PAGE.name}, program {number}", "exec"), {"__name__": "example"})
