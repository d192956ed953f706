"""Which code counts for what it is written in: what is reached by name, without comments, docstrings and layout."""

import ast
import sys
from importlib import import_module, invalidate_caches
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import pytest

import sdaeverify
from sdaeverify.measures.strong import Strong
from sdaeverify.registry.discovery import load_file
from sdaeverify.store import code
from sdaeverify.store.code import MEASURING, SAYING, code_of, framework_code

ROOT = Path(sdaeverify.__file__).parent
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
    code.forget()


def read(module="somebody.scheme", name="Mine"):
    """Return the code of a class in a module that is imported anew."""
    forget({known for known in sys.modules if known.partition(".")[0] not in {"somebody", "neighbour", "loose"}})
    found = code_of(getattr(import_module(module), name))
    return found and found.digest


def package(head="", factor="1.0", **others):
    """Return the modules of a package with a scheme."""
    files = {"__init__": "", "scheme": SCHEME.format(head, factor), **others}
    return {f"somebody__in__{name}": text for name, text in files.items()}


REACHING = {
    "relative": ("from .helper import f", "f()"),
    "module": ("from . import helper", "helper.f()"),
    "absolute": ("from somebody.helper import f", "f()"),
    "dotted": ("import somebody.helper", "somebody.helper.f()"),
    "another name": ("from .helper import f as g", "g()"),
    "another name of the module": ("import somebody.helper as other", "other.f()"),
    "star": ("from .helper import *", "f()"),
    "indirect": ("from .between import f", "f()"),
    "given to somebody": ("from . import helper", "getattr(helper, 'f' * 1)()"),
    "by a text": ("from importlib import import_module", "import_module('somebody.helper').f()"),
    "by all names": ("from .helper import *", "globals()['f']()"),
    "of the package": ("from . import k", "k()"),
    "default": ("from .helper import f\n\ndef g(a=f()):\n    return a", "g()"),
    "decorator": ("from .helper import wrap\n\n@wrap\ndef g():\n    return 1.0", "g()"),
    "base": ("from .helper import Base\n\nclass Own(Base):\n    pass", "Own().f()"),
    "constant": ("from .helper import f\nTABLE = [f()]", "TABLE[0]"),
    "condition": ("if True:\n    from .helper import f\nelse:\n    f = None", "f()"),
    "late": ("def g():\n    from .helper import f\n    return f()", "g()"),
}
HELPER = """
def f():
    return {}

def wrap(g):
    return lambda: {}

class Base:
    def f(self):
        return {}
"""


@pytest.mark.parametrize(("head", "factor"), REACHING.values(), ids=REACHING)
def test_what_is_reached_counts(put, head, factor):
    """A change of what a scheme reaches in another module of its package is another code."""
    others = {"between": "from .helper import f\n", "__init__": "from .helper import f as k\n"}
    before = put(**package(head, factor, helper=HELPER.format(1, 1, 1), **others))

    assert put(**package(head, factor, helper=HELPER.format(2, 2, 2), **others)) != before


@pytest.mark.parametrize(
    "changed",
    [
        {"scheme": SCHEME.format("from .helper import f", "f()").replace("Words", "Other words")},
        {"scheme": SCHEME.format("\n\n\nfrom .helper import f", "(\n            f()\n        )")},
        {"scheme": SCHEME.format("from .helper import f, wrap", "f()")},
        {"scheme": SCHEME.format("from .helper import f", "f()") + "\n\nclass Other(Mine):\n    pass\n"},
        {
            "scheme": SCHEME.format("from .helper import f", "f()")
            + "\nif __name__ == '__main__':\n    Mine().step()\n"
        },
        {"helper": HELPER.format(1, 2, 2)},
        {"helper": "def g():\n    return 7\n\n" + HELPER.format(1, 1, 1)},
        {"other": "a = 1"},
        {"__init__": '"""Words."""\n__all__ = ["Mine"]\n'},
    ],
    ids=["words", "layout", "import", "class", "program", "helpers", "new helper", "module", "all"],
)
def test_what_is_not_reached_does_not_count(put, changed):
    """Comments, docstrings, layout, and what a scheme does not mention, leave its code as it is."""
    files = {"scheme": SCHEME.format("from .helper import f", "f()"), "helper": HELPER.format(1, 1, 1)}
    before = put(**package(**files))

    assert before is not None
    assert put(**package(**{**files, **changed})) == before


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("from . import scheme\nscheme.A = 1.0", "from . import scheme\nscheme.A = 2.0"),
        ("from .scheme import Mine\nsetattr(Mine, 'a', 1)", "from .scheme import Mine\nsetattr(Mine, 'a', 2)"),
        ("print(1, end='')", "print(2, end='')"),
        ("print 'x'", "print 'y'"),
    ],
    ids=["attribute", "call", "anything", "no Python"],
)
def test_what_acts_by_itself_counts(put, before, after):
    """What a module of the package does to others as it is imported counts for all of it."""
    assert put(**package(register=before)) != put(**package(register=after))


@pytest.mark.parametrize("name", ["neighbour", "loose__in__neighbour", "neighbour__in____init__"])
def test_what_is_installed_nowhere_counts(put, name):
    """Modules and packages beside the own one that nobody installed count as the own one does."""
    module = name.replace("__in__", ".").removesuffix(".__init__")
    files = package(f"from {module} import f", "f()")
    before = put(**files, **{name: HELPER.format(1, 1, 1)})

    assert put(**files, **{name: HELPER.format(1, 2, 2)}) == before
    assert put(**files, **{name: HELPER.format(2, 1, 1)}) != before


def test_what_a_function_has_made_counts_with_all_of_its_package(put):
    """A class that a function made has parameters that stand elsewhere: everything counts."""
    head = "def made(a):\n    class Mine:\n        b = a\n    return Mine\n"
    before = put(**package(scheme=f"{head}\nMine = made(1)\n"))

    assert put(somebody__in__scheme=f"{head}\nMine = made(2)\n") != before


def test_a_variable_of_the_environment_that_code_names_counts(put, monkeypatch):
    """A text that names a variable of the environment counts with its value."""
    files = package("import os", "os.environ.get('SOME_WEIGHT')")
    before = put(**files)
    monkeypatch.setenv("SOME_WEIGHT", "2.0")

    assert put(**files) != before


def test_an_extension_counts(put, tmp_path):
    """A compiled module of the own package counts by its content."""
    put(**package())
    extension = tmp_path / "somebody" / f"fast{EXTENSION_SUFFIXES[0]}"
    extension.write_bytes(b"\x7fELF 1")
    before = read()

    extension.write_bytes(b"\x7fELF 2")

    assert read() != before


def test_installed_libraries_count_by_version(put):
    """Libraries are named with their versions, without corrections, under the name of what was installed."""
    put(**package("import numpy, json, pluggy, _pytest.mark", "numpy, json, pluggy, _pytest"))
    found = code_of(sys.modules["somebody.scheme"].Mine).libraries

    assert found == (
        f"pluggy {'.'.join(sys.modules['pluggy'].__version__.split('.')[:2])}",
        f"pytest {'.'.join(pytest.__version__.split('.')[:2])}",
    )


@pytest.mark.parametrize("thing", [int, sys.exit, ast.AST, print])
def test_code_without_a_source(thing):
    """Nothing is known of code that is built in, compiled, or of the standard library."""
    assert code_of(thing) is None


def test_a_file_that_is_gone(put, tmp_path):
    """Nothing is known of a module whose file was deleted meanwhile."""
    put(**package())
    forget({known for known in sys.modules if known.partition(".")[0] != "somebody"})
    mine = import_module("somebody.scheme").Mine
    (tmp_path / "somebody" / "scheme.py").unlink()

    assert code_of(mine) is None


def test_a_module_that_was_saved_after_it_was_imported(put, tmp_path):
    """Nothing is known of code that is no longer what the file holds: what was imported is what runs."""
    put(**package())
    forget({known for known in sys.modules if known.partition(".")[0] != "somebody"})
    mine = import_module("somebody.scheme").Mine
    (tmp_path / "somebody" / "scheme.py").write_text(SCHEME.format("", "1.5"))

    assert code_of(mine) is None


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


def test_shipped_measures_count_without_what_judges():
    """The code of the strong order has its observer and its probe, and nothing that tests a hypothesis."""
    found = {file.name: names for file, names in code_of(Strong).names.items()}

    assert "ErrorObserver" in found["errors.py"]
    assert "probe_strong" in found["findings.py"]
    assert "judge.py" not in found
    assert "strong_finding" not in found["findings.py"]


def rooms(start):
    """Return the files of the framework that some import, directly or not."""
    found, waiting = set(), list(start)
    while waiting:
        file = waiting.pop()
        if file not in found:
            found.add(file)
            waiting += imported(file)
    return found


def imported(file):
    """Yield the files of the framework that a file imports."""
    package = file.relative_to(ROOT.parent).parent.parts
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            stem = ROOT.parent.joinpath(*package[: len(package) - node.level + 1], *(node.module or "").split("."))
            names = [stem, *(stem / alias.name for alias in node.names)]
            yield from (
                each for name in names for each in (name.with_suffix(".py"), name / "__init__.py") if each.is_file()
            )


def test_all_that_measures_in_the_framework_counts():
    """What runs schemes and looks at one step imports nothing that does not count, but what words a finding."""
    files = rooms(
        [ROOT / "simulate" / "ensemble.py", *(ROOT / "probe").rglob("*.py"), *(ROOT / "bridges").rglob("*.py")]
    )
    others = {file.relative_to(ROOT).parts for file in files if file.relative_to(ROOT).parts[0] not in MEASURING}

    assert others <= {("__init__.py",), ("errors.py",)}
    assert not {"judge.py", "terminal.py", "store.py", "judging.py"} & {file.name for file in files}
    assert {ROOT / "contracts" / name for name in SAYING} & files <= {ROOT / "contracts" / "finding.py"}
    assert framework_code() == framework_code()
