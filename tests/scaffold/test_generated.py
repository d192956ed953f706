"""A new plugin as its author meets it: it keeps its promises as it is written, and shows it where it does not."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from sdaeverify.cli.exit_codes import ExitCode
from sdaeverify.discovery import load_file
from sdaeverify.scaffold import names_of, write_plugin
from sdaeverify.testing import check_problem, check_scheme

NAMES = names_of(Path(), "rodeo")
# What is right, what is wrong, and the problem on which it shows.
SIGN = ("b * dW + difference", "b * dW - difference", "rodeo-sinh")
TIME = ("problem.drift(t, x)", "problem.drift(0.0, x)", "forced-ou")


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
    badge = json.loads((plugin / "reports/gate/badge.json").read_text(encoding="utf-8"))
    assert badge["message"] == "verified 15/15"


@pytest.mark.slow
@pytest.mark.parametrize(("right", "wrong", "problem"), [SIGN, TIME], ids=["sign", "time"])
def test_mistake_is_refuted_by_tests_and_gate(plugin, right, wrong, problem):
    """With a sign turned round or the drift of another time, both are red and tell claim, interval and command."""
    scheme = plugin / "src" / "rodeo" / "platen.py"
    written = scheme.read_text(encoding="utf-8")
    assert right in written
    scheme.write_text(written.replace(right, wrong), encoding="utf-8")
    install(plugin)

    tests, gate = python(plugin, "pytest", "-q"), python(plugin, "sdaeverify", "gate")

    assert (tests.returncode, gate.returncode) == (1, ExitCode.REFUTED)
    for text in (tests.stdout, gate.stdout):
        assert f"refuted: rodeo-platen on {problem}, strong x: claimed order >= 1.0" in text
        assert "(99 % interval)" in text
        assert f"python -m sdaeverify matrix -s rodeo-platen -p {problem} -m strong" in text
