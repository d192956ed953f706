"""The command ``init``."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from facade import ExitCode

PYPROJECT = """[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "my-solvers"
version = "1.0"
"""


@pytest.fixture
def library(call, tmp_path):
    """Return a library without tests, which is the folder of the call."""
    (tmp_path / "pyproject.toml").write_text(PYPROJECT)
    (tmp_path / "src" / "my_solvers").mkdir(parents=True)
    (tmp_path / "src" / "my_solvers" / "__init__.py").write_text("")
    return tmp_path


def test_a_library_gets_what_a_gate_needs(call, library):
    """A module, a test, a workflow, an entry point and a policy; what was there is as it was."""
    outcome = call("init")
    table = tomllib.loads((library / "pyproject.toml").read_text())

    assert outcome.code == ExitCode.OK
    assert "Put a step of your own into src/my_solvers/verification.py" in outcome.out
    assert (library / "pyproject.toml").read_text().startswith(PYPROJECT)
    assert table["project"]["entry-points"]["sdaeverify"] == {"my-solvers": "my_solvers.verification"}
    assert table["tool"]["sdaeverify"]["problems"] == ["gbm", "forced-ou"]
    assert "sdaeverify gate" in (library / ".github" / "workflows" / "verify.yml").read_text()


@pytest.mark.parametrize(
    ("backend", "own", "expected"),
    [
        ("", "", True),
        ('[build-system]\nrequires = ["setuptools"]\nbuild-backend = "setuptools.build_meta"\n', "", True),
        ('[build-system]\nrequires = ["hatchling"]\nbuild-backend = "hatchling.build"\n', "", False),
        ("", '[tool.setuptools]\npackages = ["my_solvers"]\n', False),
    ],
)
def test_a_gate_does_not_break_the_build_of_a_library(call, tmp_path, backend, own, expected):
    """Setuptools, which refuses two packages beside pyproject.toml, is told not to take reports for one."""
    (tmp_path / "pyproject.toml").write_text(f'{backend}[project]\nname = "my-solvers"\nversion = "1.0"\n{own}')
    (tmp_path / "my_solvers").mkdir()
    (tmp_path / "my_solvers" / "__init__.py").write_text("")
    call("init")
    found = tomllib.loads((tmp_path / "pyproject.toml").read_text())["tool"].get("setuptools", {}).get("packages")
    assert (found == {"find": {"include": ["my_solvers", "my_solvers.*"]}}) == expected


@pytest.mark.long
def test_what_is_written_passes(call, library):
    """The test of the library passes, and its gate is green."""
    call("init")
    environment = {"PYTHONPATH": str(library / "src")}
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error", "tests"]
    told = subprocess.run(words, capture_output=True, text=True, cwd=library, env=environment, check=False)
    assert told.returncode == 0, told.stdout
    outcome = call("gate", "--plugin", "src/my_solvers/verification.py", "--tier", "smoke", "-j", "1")
    assert outcome.code == ExitCode.OK
    assert "verified" in outcome.out


def test_nothing_is_overwritten(call, library):
    """A second time there is a policy; a file in the way is named, and nothing is written."""
    call("init")
    again = call("init")
    assert again.code == ExitCode.USAGE
    assert "has a table [tool.sdaeverify] already" in again.err

    (library / "pyproject.toml").write_text(PYPROJECT)
    (library / "tests" / "test_verification.py").unlink()
    before = sorted(library.rglob("*"))
    taken = call("init")
    assert taken.code == ExitCode.USAGE
    assert "verification.py exists already; init overwrites nothing" in taken.err
    assert sorted(library.rglob("*")) == before
    assert (library / "pyproject.toml").read_text() == PYPROJECT


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has no table [project] with a name"),
        ("[", "cannot read"),
        ('[project]\nname = "other"\n', "no package other in"),
        (
            '[project]\nname = "my-solvers"\ndynamic = ["entry-points"]\n',
            "has entry points that init does not change",
        ),
        ('project = {name = "my-solvers"}\n', "cannot take tables at its end"),
    ],
)
def test_a_folder_that_is_no_library_is_told(call, library, text, message):
    """In one line, and nothing is written."""
    (library / "pyproject.toml").write_text(text)
    outcome = call("init")

    assert outcome.code == ExitCode.USAGE
    assert message in outcome.err
    assert outcome.err.count("\n") == 1
    assert not Path("tests").exists()


def test_an_empty_folder_is_told(call):
    """New plugins have a command of their own."""
    assert "init is for a library that exists; new-plugin DIR writes a new one" in call("init").err
