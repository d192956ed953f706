"""A new plugin as its author meets it: it keeps its promises as it is written, and shows it where it does not."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from facade import PROBLEMS, SCHEMES, ExitCode, Origin, collect, load_file, names_of, write_plugin
from sdaeverify.testing import check_problem, check_scheme

NAMES = names_of(Path(), "rodeo")
# What is right, what is wrong, and the problem on which it shows.
# What stands in the step, what is written in its place, and what is told: an interval, or the state of a short step.
SIGN = ("b * dW + difference", "b * dW - difference", "rodeo-sinh", "strong x", "(99 % interval)")
TIME = ("problem.drift(t, x)", "problem.drift(0.0, x)", "forced-ou", "strong", "the mean of one step from [")


@pytest.fixture
def plugin(tmp_path):
    """Write a plugin."""
    write_plugin(tmp_path / "rodeo", NAMES)
    return tmp_path / "rodeo"


def python(plugin, *words):
    """Run a command line of Python in the plugin's folder, with the plugin installed beside it."""
    environment = {**os.environ, "PYTHONPATH": str(plugin.parent / "site")}
    command = [sys.executable, "-m", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=plugin, env=environment)


def install(plugin):
    """Build and install the plugin as pip does, without a network."""
    offline = ["--no-deps", "--no-index", "--no-build-isolation", "--upgrade"]
    ended = python(plugin, "pip", "install", "--quiet", *offline, "--target", str(plugin.parent / "site"), ".")
    assert ended.returncode == 0, ended.stderr


def failed(rows):
    """Return the checks that failed, with their reasons."""
    return {row["check"]: row["reason"] for row in rows if row["status"] == "failed"}


def test_scheme_and_problem_pass_the_kit(plugin):
    """No named check of the conformance kit fails on what is written."""
    scheme, problem = (load_file(plugin / "src" / "rodeo" / f"{name}.py") for name in ("platen", "sinh"))

    assert not failed(check_scheme(scheme.Platen(), [problem.rodeo_sinh]))
    assert not failed(check_problem(problem.rodeo_sinh))


@pytest.mark.parametrize("name", ["sdaeverify-mine", "sdaeverify-problem", "sdaeverify-plugin", "test-plugin", "a"])
def test_plugin_of_any_name_is_registered(tmp_path, name):
    """Whatever the distribution is called, both modules register what they have, and the tests shadow no module."""
    names = names_of(Path(), name)
    written = write_plugin(tmp_path / name, names)
    origin = Origin(name, name, "0", names.module)
    scheme, problem = (
        collect(load_file(tmp_path / name / "src" / names.module / f"{each}.py"), origin)
        for each in ("platen", "sinh")
    )

    assert (list(scheme[SCHEMES]), list(problem[PROBLEMS])) == ([names.scheme], [names.problem])
    assert names.module not in {Path(file).stem for file in written}


@pytest.mark.slow
@pytest.mark.parametrize("tier", ["ci", "nightly"])
def test_lock_of_a_plugin_is_complete(plugin, tier):
    """The first gate of a new package notes no claim that its lock file lacks, and writes the same file."""
    locked = (plugin / "sdaeverify.lock").read_text(encoding="utf-8")
    files = [f"--plugin=src/rodeo/{name}.py" for name in ("platen", "sinh")]

    first = python(plugin, "sdaeverify", "gate", f"--tier={tier}", "-j1", *files)
    written = python(plugin, "sdaeverify", "gate", f"--tier={tier}", "-j1", "--write-lock", *files)

    assert (first.returncode, written.returncode) == (ExitCode.OK, ExitCode.OK), first.stdout
    assert "lock file" not in first.stdout + first.stderr
    assert (plugin / "sdaeverify.lock").read_text(encoding="utf-8") == locked


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sdaeverify-mine", "test-plugin"])
def test_plugin_of_a_natural_name_passes_its_own_tests(tmp_path, name):
    """A name that begins like a hook, or like a test, is one like any other."""
    folder = tmp_path / name
    write_plugin(folder, names_of(folder))
    install(folder)

    tests, gate = python(folder, "pytest", "-q"), python(folder, "sdaeverify", "gate")

    assert (tests.returncode, gate.returncode) == (0, ExitCode.OK), tests.stdout + gate.stdout
    assert "warning" not in gate.stderr


@pytest.mark.slow
def test_annotation_of_an_installed_plugin(plugin, monkeypatch):
    """Installed as its workflow does it, a refuted claim is annotated at the scheme's class in the checkout."""
    scheme = plugin / "src" / "rodeo" / "platen.py"
    text = scheme.read_text(encoding="utf-8").replace(*SIGN[:2])
    scheme.write_text(text, encoding="utf-8")
    install(plugin)

    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    printed = python(plugin, "sdaeverify", "gate").stdout

    line = 1 + next(n for n, text in enumerate(text.splitlines()) if text.startswith("@dataclass"))
    assert f"::error file=src/rodeo/platen.py,line={line},title=" in printed


@pytest.mark.slow
def test_plugin_passes_its_own_tests_and_gate(plugin):
    """As it is written and installed, nothing fails, and the lock file is what the gate would write."""
    locked = (plugin / "sdaeverify.lock").read_text(encoding="utf-8")
    install(plugin)

    tests = python(plugin, "pytest", "-q")
    gates = [python(plugin, "sdaeverify", "gate", "--tier", tier) for tier in ("ci", "nightly")]
    written = [python(plugin, "sdaeverify", "gate", "--tier", tier, "--write-lock") for tier in ("ci", "nightly")]

    assert tests.returncode == 0, tests.stdout
    assert [(gate.returncode, gate.stderr.count("warning")) for gate in (*gates, *written)] == [(ExitCode.OK, 0)] * 4
    assert (plugin / "sdaeverify.lock").read_text(encoding="utf-8") == locked
    report = json.loads((plugin / "reports/gate/gate.json").read_text(encoding="utf-8"))
    assert report["counts"] == {"passed": 19}


@pytest.mark.slow
@pytest.mark.parametrize(("right", "wrong", "problem", "what", "found"), [SIGN, TIME], ids=["sign", "time"])
def test_mistake_is_refuted_by_tests_and_gate(plugin, right, wrong, problem, what, found):
    """With a sign turned round or the drift of another time, both are red and tell claim, finding and command."""
    scheme = plugin / "src" / "rodeo" / "platen.py"
    written = scheme.read_text(encoding="utf-8")
    assert right in written
    scheme.write_text(written.replace(right, wrong), encoding="utf-8")
    install(plugin)

    tests, gate = python(plugin, "pytest", "-q"), python(plugin, "sdaeverify", "gate")

    assert (tests.returncode, gate.returncode) == (1, ExitCode.REFUTED)
    for text in (tests.stdout, gate.stdout):
        assert f"refuted: rodeo-platen on {problem}, {what}: claimed order >= 1.0" in text, text[-3000:]
        assert found in text, text[-4000:]
        assert f"python -m sdaeverify matrix -s rodeo-platen -p {problem} -m strong" in text
