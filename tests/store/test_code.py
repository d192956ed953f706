"""Which code counts for what it is written in: a package as a whole, without comments, docstrings and layout."""

import ast
import sys
from importlib import import_module, invalidate_caches
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import numpy
import pluggy
import pytest

from facade import MEASURING, SAYING, EulerMaruyama, Strong, code, code_of, framework_code, home_of, load_file
from sdaeverify.studying import code_key
from test_architecture import LAYERS

SCHEME = (
    '"""Words."""\n{}\n\nclass Mine:\n    """Words."""\n\n    def step(self):\n        # Words.\n        return {}\n'
)


@pytest.fixture
def put(tmp_path, monkeypatch):
    """Write modules of a package and others beside it, and return the code of its scheme as a new process would."""
    known = set(sys.modules)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def write(**modules):
        for name, text in modules.items():
            path = tmp_path / f"{name.replace('__in__', '/')}.py"
            path.parent.mkdir(exist_ok=True, parents=True)
            path.write_text(text)
        return read()

    yield write
    forget(known)


def forget(known):
    """Forget what was imported and read."""
    invalidate_caches()
    for name in set(sys.modules) - known:
        del sys.modules[name]
    for remembered in (code._parse_home, home_of):
        remembered.cache_clear()


def read(module="somebody.scheme", name="Mine"):
    """Return the code of a class in a module that is imported anew."""
    forget({known for known in sys.modules if known.partition(".")[0] not in {"somebody", "neighbour", "loose"}})
    found = code_of(getattr(import_module(module), name))
    return found and found.digest


def package(head="", factor="1.0", **others):
    """Return the modules of a package with a scheme."""
    files = {"__init__": "", "scheme": SCHEME.format(head, factor), **others}
    return {f"somebody__in__{name}": text for name, text in files.items()}


CHANGES = {
    "formula": {"somebody__in__scheme": SCHEME.format("", "2.0")},
    "helper": {"somebody__in__helper": "def f():\n    return 2.0\n"},
    "new helper": {"somebody__in__other": "x = 1.0\n"},
    "below": {"somebody__in__below__in__deep": "x = 2.0\n"},
    "no Python": {"somebody__in__helper": "it is none"},
}


@pytest.mark.parametrize("changed", CHANGES.values(), ids=CHANGES)
def test_a_package_counts_as_a_whole(put, changed):
    """Whatever is written otherwise in a package, its schemes are others."""
    before = put(**package(helper="def f():\n    return 1.0\n", below__in__deep="x = 1.0\n"))

    assert put(**changed) != before


WORDS = {
    "comment": "# Other words.\n" + SCHEME.format("", "1.0"),
    "docstring": SCHEME.format("", "1.0").replace("Words", "Other words"),
    "layout": SCHEME.format("\n\n", "(\n            1.0\n        )"),
}


@pytest.mark.parametrize("text", WORDS.values(), ids=WORDS)
def test_words_and_layout_do_not_count(put, text):
    """Comments, docstrings and layout may change."""
    before = put(**package())

    assert put(somebody__in__scheme=text) == before


def test_bases_of_other_packages_count(put):
    """A scheme is written in the code of its bases, too, where that is installed nowhere."""
    files = package(scheme="from neighbour import Base\nclass Mine(Base):\n    pass\n")
    before = put(**files, neighbour="class Base:\n    a = 1.0\n")

    assert put(neighbour="class Base:\n    a = 2.0\n") != before


def test_an_extension_counts(put, tmp_path):
    """A compiled module of a package counts by its bytes."""
    before = put(**package())
    compiled = tmp_path / "somebody" / f"fast{EXTENSION_SUFFIXES[0]}"
    compiled.write_bytes(b"1")
    first = read()
    compiled.write_bytes(b"2")

    assert len({before, first, read()}) == 3


def test_installed_libraries_count_by_version(put):
    """Libraries are named with their versions, without corrections, under the name of what was installed."""
    put(**package("import numpy, json, pluggy, _pytest.mark", "numpy, json, pluggy, _pytest"))
    found = code_of(sys.modules["somebody.scheme"].Mine).libraries

    assert found == tuple(
        f"{library.__name__} {'.'.join(library.__version__.split('.')[:2])}" for library in (numpy, pluggy, pytest)
    )


@pytest.mark.parametrize("thing", [int, sys.exit, ast.AST, print])
def test_code_without_a_source(thing):
    """Nothing is known of code that is built in, compiled, or of the standard library."""
    assert code_of(thing) is None


def test_plugin_files(tmp_path, monkeypatch):
    """Of a plugin that is a single file, what it held when it was loaded counts."""
    monkeypatch.setattr(sys, "modules", dict(sys.modules))
    path = tmp_path / "odd_plugin.py"
    path.write_text(SCHEME.format("", "1.0"))
    first = load_file(path).Mine
    path.write_text(SCHEME.format("# Other words.", "1.0"))
    second = load_file(path).Mine
    path.write_text(SCHEME.format("", "2.0"))
    third = load_file(path).Mine

    assert first is not second
    assert code_of(first).digest == code_of(second).digest != code_of(third).digest


MEASURE = """
from sdaeverify.measuring import Measure, Tally

class Mine(Measure):
    name = "mine"
    value_of = "{words}"

    def observer(self, problem, parts, settings):
        return Tally({number})

    def judge(self, evidence):
        return {judged}
"""


def test_what_judges_in_a_measure_does_not_count(put):
    """A measure counts by what it observes and probes; how it judges and words what it found is no part of it."""
    given = {"words": "x", "number": 1, "judged": 1}
    before = put(**package(scheme=MEASURE.format(**given)))

    assert put(somebody__in__scheme=MEASURE.format(**{**given, "words": "y", "judged": 2})) == before
    assert put(somebody__in__scheme=MEASURE.format(**{**given, "number": 2})) != before


def test_all_that_measures_in_the_framework_counts():
    """The layers up to those that run schemes and look at one step, which import no higher ones, and no others."""
    measuring = {room for room, layer in LAYERS.items() if layer <= max(LAYERS["simulate"], LAYERS["probe"])}

    assert {Path(room).stem for room in MEASURING} == measuring - {"errors"}
    assert {"finding.py"} == SAYING
    assert framework_code() == framework_code()


def test_a_key_of_code_has_all_that_determines_a_result():
    """Another class, or another text, has another key, and code without a source has none."""
    scheme, measure = EulerMaruyama, Strong
    key = code_key(scheme, measure, of="seed 1")

    assert key == code_key(scheme, measure, of="seed 1")
    assert len({key, code_key(scheme, measure, of="seed 2"), code_key(measure, of="seed 1")}) == 3
    assert code_key(scheme, int, of="seed 1") == ""
