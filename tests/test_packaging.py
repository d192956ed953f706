"""The built wheel carries everything: framework, schemes, problems, entry points."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Build the wheel and unpack it into an empty folder, as pip does."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def run(installed, *words):
    environment = {**os.environ, "PYTHONPATH": str(installed), "PYTHONWARNINGS": "error"}
    command = [sys.executable, "-m", "sdaeverify", *words]
    return subprocess.run(command, capture_output=True, text=True, check=True, cwd=installed, env=environment).stdout


def test_wheel_lists_the_shipped_plugins(installed):
    """From the wheel alone, list finds the shipped schemes, problems and measures."""
    listing = run(installed, "list")

    for name in ("half-explicit-euler", "pendulum-velocity-noise", "strong", "drift"):
        assert name in listing


def test_wheel_runs_a_cell(installed, tmp_path):
    """From the wheel alone, a cell is measured and its files are written."""
    words = ["matrix", "-s", "milstein", "-p", "gbm", "--paths", "200", "-j", "1", "--out", str(tmp_path)]

    run(installed, *words)

    tables = {"verdicts.csv", "not_applicable.csv", "levels.csv", "classes.csv", "columns.csv", "details"}
    written = {*tables, "run.json", "report.html", "evidence"}
    assert {path.name for path in tmp_path.iterdir() if path.suffix != ".parquet"} == written


def test_wheel_writes_a_plugin(installed, tmp_path):
    """From the wheel alone, new-plugin finds its template."""
    run(installed, "new-plugin", str(tmp_path / "rodeo"))

    assert (tmp_path / "rodeo" / ".github" / "workflows" / "verify.yml").is_file()


def test_wheel_holds_no_tests(installed):
    """Only the nine packages, their metadata and nothing else are in the wheel."""
    tops = {path.name for path in installed.iterdir()}

    packages = {
        f"sdaeverify_{part}"
        for part in ("adaptive", "bridges", "lab", "measures", "papers", "planted", "problems", "schemes")
    }
    assert tops - {"sdaeverify", *packages} == {name for name in tops if name.endswith(".dist-info")}
    assert (installed / "sdaeverify" / "py.typed").is_file()
