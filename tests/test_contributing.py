"""What CONTRIBUTING, the architecture page and its pictures name is there, and they name every room."""

import ast
import builtins
import importlib
import re
from collections import defaultdict
from functools import cache
from html import unescape

import pytest

from facade import rules
from sdaeverify.verdicts.guard import Guard
from source_trees import ROOT, nodes, parsed, sources
from test_architecture import LAYERS, SIDE

PAGES = {"CONTRIBUTING": ROOT / "CONTRIBUTING.md", "architecture": ROOT / "docs/explanation/architecture.md"}
PICTURES = {name: ROOT / "docs" / "_static" / f"{name}.svg" for name in ("cell", "way")}
NAME = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*")
# Files that a run writes, and places that a build makes.
WRITTEN = re.compile(r"[\w-]+\.csv|docs/_site")


def code_of_page(text):
    """Return the words in code between the sentences of a page, without its blocks."""
    return re.findall(r"`([^`\n]+)`", re.sub(r"^ *```.*?^ *```", "", text, flags=re.DOTALL | re.MULTILINE))


def code_of_picture(text):
    """Return the words in code of a picture, from top to bottom."""
    return [unescape(word) for word in re.findall(r'<tspan class="code">([^<]*)</tspan>', text)]


def members(*statements):
    """Yield the names that statements define, and the attributes that they set on `self`."""
    for statement in statements:
        yield from (node.name for node in nodes(statement, ast.FunctionDef, ast.ClassDef))
        stored = (node for node in nodes(statement, ast.Name, ast.Attribute) if isinstance(node.ctx, ast.Store))
        yield from (node.id if isinstance(node, ast.Name) else node.attr for node in stored)


@cache
def source():
    """Return all names of the framework and of Python, and the names and the bases of each class.

    Of plugins, which the pages name by their folders and commands, the names of folders and files.
    """
    names, own, bases = {*dir(builtins), *(path.name for path in ROOT.iterdir())}, defaultdict(set), defaultdict(set)
    names |= {part for path in sources(ROOT / "plugins") for part in path.with_suffix("").parts}
    for path in sources(ROOT / "sdaeverify"):
        tree = parsed(path)
        names |= {*members(tree), *path.relative_to(ROOT).with_suffix("").parts}
        for node in nodes(tree, ast.ClassDef):
            own[node.name] |= {*members(*node.body)}
            bases[node.name] |= {ast.unparse(base).rpartition(".")[2] for base in node.bases}
    return names, own, bases


def has(kind, member):
    """Return whether a class, or one of its bases, defines a name."""
    _, own, bases = source()
    return member in own[kind] or any(has(base, member) for base in bases[kind] if base in own)


def is_missing(word):
    """Return whether a word in code is a path or a name of which the source has none.

    Commands, options, markers and formulas are no names and are skipped.
    """
    if WRITTEN.fullmatch(word) or set(word) & set(" =*$-(<"):
        return False
    if "/" in word or word.endswith((".py", ".md", ".toml", ".lock", ".cff")):
        return not any((folder / word).exists() for folder in (ROOT, ROOT / "sdaeverify", ROOT / "plugins"))
    if not NAME.fullmatch(word):
        return False
    *kinds, member = word.split(".")
    return not has(kinds[-1], member) if kinds else word not in source()[0]


@pytest.mark.parametrize(
    "words",
    [
        *(pytest.param((path, code_of_page), id=name) for name, path in PAGES.items()),
        *(pytest.param((path, code_of_picture), id=name) for name, path in PICTURES.items()),
    ],
)
def test_named_paths_and_names_exist(words):
    """Each path is a file or folder, and each name in code is defined in the source."""
    path, read = words
    found = read(path.read_text(encoding="utf-8"))

    assert len(found) > 20
    assert sorted({word for word in found if is_missing(word)}) == []


@pytest.mark.parametrize(
    ("word", "missing"),
    [
        ("study/plan.py", False),
        ("study/nowhere.py", True),
        ("ProblemRun.accept", False),
        ("ProblemRun.fly", True),
        ("Strong.probe", False),
        ("Strong.flies", True),
        ("judge_cell", False),
        ("judge_cells", True),
        ("-m quick", False),
        ("verdicts.csv", False),
    ],
)
def test_a_missing_name_is_noticed(word, missing):
    """Names and paths that the source does not have are reported; words of commands are not."""
    assert is_missing(word) is missing


def test_contributing_names_every_room():
    """Each folder of the framework and each plugin has its line in CONTRIBUTING."""
    table = PAGES["CONTRIBUTING"].read_text(encoding="utf-8").partition("| question |")[0]
    rooms = {
        path.name
        for parent in ("sdaeverify", "plugins")
        for path in (ROOT / parent).iterdir()
        if (path / "__init__.py").is_file()
    }
    named = {word.rpartition("/")[2] for word in code_of_page(table)}

    assert rooms - named == set()


def test_the_page_shows_the_layers_of_the_code():
    """The table of layers is that of the test of imports."""
    page = PAGES["architecture"].read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\w+) \| ((?:`\w+`(?:, )?)+) \|", page, re.MULTILINE)
    shown = {room: layer for layer, cell in rows for room in code_of_page(cell)}

    assert shown == {room: str(layer) for room, layer in LAYERS.items()} | dict.fromkeys(SIDE, "beside")


def test_the_picture_shows_the_rules_in_their_order():
    """The rules of the picture are `RULES`, guards by the name of their constant."""
    picture = PICTURES["way"].read_text(encoding="utf-8")
    shown = code_of_picture(re.search(r'<g id="rules">(.*?)</g>', picture, re.DOTALL).group(1))
    constants = {id(rule): name for name, rule in vars(rules).items() if isinstance(rule, Guard)}

    assert shown == [constants.get(id(rule)) or rule.__name__ for rule in rules.RULES]


def test_the_pictures_are_those_of_the_program(monkeypatch):
    """The committed pictures are what `python docs/ways.py` writes."""
    monkeypatch.syspath_prepend(ROOT / "docs")
    drawn = importlib.import_module("ways").pictures()

    assert drawn == {path.name: path.read_text(encoding="utf-8") for path in PICTURES.values()}
