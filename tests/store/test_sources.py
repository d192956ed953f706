"""Which code counts for the evidence of a scheme: its own and what that imports, nothing else."""

import sys
from importlib import import_module, invalidate_caches
from importlib.machinery import EXTENSION_SUFFIXES

import pytest

from sdaeverify.registry.discovery import load_file
from sdaeverify.store import sources
from sdaeverify.store.sources import UNKNOWN, framework_source, source_of

CACHED = (
    sources.source_of,
    sources._gather_files,
    sources._content,
    sources.find_imports,
    sources._resolve_imports,
    sources._imports_by_name,
    sources._files_in,
    sources._file_below,
    sources._spec,
)


@pytest.fixture
def forget():
    """Forget what was read of sources, as another process would."""

    def clear():
        invalidate_caches()
        for function in CACHED:
            function.cache_clear()

    yield clear
    clear()


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Write a package, import its scheme, and return a function that writes its modules."""
    known = set(sys.modules)
    monkeypatch.syspath_prepend(str(tmp_path))

    def put(**modules):
        for name, text in modules.items():
            path = tmp_path / "somebody" / f"{name.replace('__in__', '/')}.py"
            path.parent.mkdir(exist_ok=True, parents=True)
            path.write_text(text)

    yield put
    for name in set(sys.modules) - known:
        del sys.modules[name]


def source(forget, module="somebody.scheme"):
    """Return the source of a module as a new process sees it."""
    forget()
    import_module(module)
    return source_of(module)


IMPORTS = {
    "relative": "from .helper import f",
    "module": "from . import helper",
    "absolute": "from somebody.helper import f",
    "dotted": "import somebody.helper",
    "late": "def step():\n    from .helper import f",
    "indirect": "from .between import f",
    "star": "from .helper import *",
}


@pytest.mark.parametrize("text", IMPORTS.values(), ids=IMPORTS)
def test_helpers_count(package, forget, text):
    """A change of a module that a scheme imports of its own package changes its source."""
    package(__init__="", scheme=text, between="from .helper import f", helper="f = 1", other="")
    before = source(forget)

    package(helper="f = 2")

    assert source(forget) != before


def test_other_modules_do_not_count(package, forget):
    """A change of a module that a scheme does not import leaves its source as it is."""
    package(__init__="from . import other", scheme="from .helper import f", helper="f = 1", other="")
    before = source(forget)

    package(other="g = 1", __init__="from . import other, helper")

    assert source(forget) == before


def test_the_scheme_itself_counts(package, forget):
    """A change of the module of a scheme changes its source, that of a comment too."""
    package(__init__="", scheme="f = 1")
    before = source(forget)

    package(scheme="f = 1  # one")

    assert source(forget) != before


@pytest.mark.parametrize("definition", ["f = 1", "from .helper import f"])
def test_what_is_imported_from_the_package_itself_counts(package, forget, definition):
    """A constant of the package, wherever it has it from, counts for the module that uses it."""
    package(__init__=definition, scheme="from . import f", helper="f = 1")
    before = source(forget)

    package(__init__=definition.replace("1", "2"), helper="f = 2")

    assert source(forget) != before


def test_subpackages_count(package, forget):
    """What a package below the package imports counts."""
    package(
        __init__="", scheme="from .below import f", below__in____init__="from .deep import f", below__in__deep="f=1"
    )
    before = source(forget)

    package(below__in__deep="f = 2")

    assert source(forget) != before


def test_circular_imports_end(package, forget):
    """Modules that import each other are each read once."""
    package(__init__="", scheme="from . import helper", helper="from . import scheme")

    assert source(forget)


def test_a_neighbour_that_is_not_installed_counts(package, forget, tmp_path):
    """A module beside the package that no distribution installed counts by its source."""
    (tmp_path / "neighbour.py").write_text("f = 1")
    package(__init__="", scheme="from neighbour import f")
    before = source(forget)

    (tmp_path / "neighbour.py").write_text("f = 2")

    assert source(forget) != before


def test_the_scheme_of_another_counts(package, forget, tmp_path):
    """A scheme that inherits from one of another package under development changes with it."""
    other = tmp_path / "another"
    other.mkdir()
    (other / "__init__.py").write_text("from .base import Base")
    (other / "base.py").write_text("class Base: order = 1")
    package(__init__="", scheme="from another import Base")
    before = source(forget)

    (other / "base.py").write_text("class Base: order = 2")

    assert source(forget) != before


def test_installed_packages_count_by_version(package, forget):
    """Packages of others are named with their versions, under the name of what was installed."""
    package(__init__="", scheme="import numpy, json, pytest, _pytest.mark, pluggy")

    text = source(forget)

    assert f"pytest {pytest.__version__}" in text
    assert "pluggy" in text
    assert "json" not in text
    assert "numpy" not in text


def test_the_framework_counts_as_far_as_it_is_imported(package, forget):
    """A measure of somebody else that uses a module of the framework has another source than one that does not."""
    package(__init__="", scheme="import sdaeverify.probe.step.solvable")
    with_roots = source_of_files(forget)
    package(scheme="from sdaeverify import Scheme")

    assert "solvable.py" in with_roots
    assert source_of_files(forget) == {"scheme.py"}


def source_of_files(forget):
    """Return the names of the files that count."""
    forget()
    file = import_module("somebody.scheme").__file__
    return {path.name for path in sources._closure("somebody.scheme", sources.Path(file))[0]}


def test_an_extension_counts(package, forget, tmp_path):
    """A compiled module of the own package counts by its content."""
    package(__init__="", scheme="def step():\n    from . import fast")
    extension = tmp_path / "somebody" / f"fast{EXTENSION_SUFFIXES[0]}"
    extension.write_bytes(b"\x7fELF 1")
    before = source(forget)

    extension.write_bytes(b"\x7fELF 2")

    assert source(forget) != before


def test_a_module_that_cannot_be_parsed_counts_by_its_content(package, forget):
    """A module for another version of the language is no reason for an error."""
    package(__init__="", scheme="def step():\n    from . import old", old="print 'x'")
    before = source(forget)

    package(old="print 'y'")

    assert source(forget) != before


def test_plugin_files(tmp_path, forget, monkeypatch):
    """Of a plugin that is a single file, the file counts, in every process under the same name."""
    monkeypatch.setattr(sys, "modules", dict(sys.modules))
    path = tmp_path / "odd_plugin.py"
    path.write_text("import os\n\ndef f():\n    return 1\n")
    first = source_of(load_file(path).__name__)
    forget()
    again = source_of(load_file(path).__name__)

    path.write_text("import os\n\ndef f():\n    return 2\n")
    changed = source_of(load_file(path).__name__)

    assert first
    assert first == again != changed


@pytest.mark.parametrize("module", ["__nowhere__", "builtins", "time", "numpy._core._multiarray_umath"])
def test_code_without_a_source(module, forget):
    """Nothing is known of code that has no source: built in, compiled, or typed into an interpreter."""
    assert source_of(module) == UNKNOWN


def test_a_file_that_is_gone(package, forget, tmp_path):
    """Nothing is known of a module whose file was deleted meanwhile."""
    package(__init__="", scheme="")
    forget()
    import_module("somebody.scheme")
    (tmp_path / "somebody" / "scheme.py").unlink()

    assert source_of("somebody.scheme") == UNKNOWN


def test_the_framework_is_what_runs_schemes():
    """Numbers depend on the time loop, the noise, the forms and the arithmetic; not on how reports are written."""
    files = {
        path.name
        for path in sources._closure(sources.RUNNER, sources.Path(import_module(sources.RUNNER).__file__))[0]
    }

    assert {"ensemble.py", "brownian.py", "sde.py", "newton.py", "tally.py", "contract.py"} <= files
    assert not {"terminal.py", "judge.py", "matrix.py", "store.py", "judging.py"} & files
    assert "numpy" in framework_source()
    assert "scipy" in framework_source()


@pytest.mark.parametrize("text", ["", "import importlib\nh = importlib.import_module('somebody.helper')"])
def test_what_no_import_names(package, forget, tmp_path, text):
    """Data beside the modules counts, and the other modules where a module imports by name."""
    package(__init__="", scheme=text, helper="f = 1")
    before = source(forget)

    package(helper="f = 2")
    then = source(forget)
    (tmp_path / "somebody" / "table.txt").write_text("1 2 3")

    assert (then != before) == bool(text)
    assert source(forget) != then


def test_a_folder_without_init(package, forget, tmp_path):
    """A module in a folder that is no package of its own counts like any other that is installed nowhere."""
    package(__init__="", scheme="from loose.helper import f")
    (tmp_path / "loose").mkdir()
    (tmp_path / "loose" / "helper.py").write_text("f = 1")
    before = source(forget)

    (tmp_path / "loose" / "helper.py").write_text("f = 2")

    assert source(forget) != before
