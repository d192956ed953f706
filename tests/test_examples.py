"""Public names have examples: programs of the site that run, or examples of a docstring."""

import inspect
import re
from importlib import import_module
from pathlib import Path

import pytest

import sdaeverify

ROOT = Path(__file__).parents[1]
EXAMPLES = tuple(ROOT / "docs" / "reference" / f"{name}.md" for name in ("examples", "examples-plugins"))
# Fences whose content is a program, and files that pages include.
PROGRAMS = re.compile(r"```(?:\{file\} \S+\.py|\{python\}|python)\n(.*?)```", re.DOTALL)
INCLUDED = re.compile(r":from: (\S+\.py)|\{literalinclude\} \.\./\.\./(\S+\.py)")
# Packages of public names; each name of them has an example.
ROOMS = ("commands", "errors", "measuring", "numerics", "probing", "studying", "testing", "trees")
WHOLE = (sdaeverify, *(import_module(f"sdaeverify.{name}") for name in ROOMS))


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


@pytest.mark.parametrize("room", WHOLE, ids=lambda room: room.__name__)
def test_every_name_has_an_example(room):
    """Each is in a program of the site, of the README or of its docstring; a name that is not is found."""
    assert without_example(room.__all__, room) == []
    assert not re.search(r"\bnobody_shows_this\b", shown())


NUMBERED = [(page, number) for page in EXAMPLES for number in range(len(programs(page.read_text(encoding="utf-8"))))]


@pytest.mark.long
@pytest.mark.parametrize(("page", "number"), NUMBERED, ids=lambda each: getattr(each, "stem", each))
def test_examples_of_names_run(page, number, monkeypatch, tmp_path):
    """Each program of the pages of examples runs by itself."""
    monkeypatch.chdir(tmp_path)
    if "hunt(" in (program := programs(page.read_text(encoding="utf-8"))[number]):
        pytest.importorskip("hypothesis", reason="needs the extra hunt")
    exec(compile(program, f"{page.name}, program {number}", "exec"), {"__name__": "__main__"})
