"""Parts that are no core: each is deleted from an installed copy with its entry points, and the rest is as before."""

import csv
import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[1]
PLUGINS = ("adaptive", "bridges", "lab", "measures", "papers", "planted", "wire")
CORE, COMMANDS = "sdaeverify/testing", "sdaeverify/cli/commands"
# By name, files and folders of an installed copy.
PARTS = {name: (f"sdaeverify_{name}",) for name in PLUGINS} | {
    "compare": ("sdaeverify/report/compare", f"{COMMANDS}/compare.py"),
    "hunt": (f"{CORE}/hunting", f"{CORE}/strategies", f"{CORE}/hunts.py", f"{COMMANDS}/hunt.py"),
}
# Schemes of several forms, on two of their problems, with what order conditions and random members say of them.
RUN = """
from sdaeverify.cli.program import execute

few = ["--paths", "200", "--levels", "8..32", "-j", "1", "--timeout", "0", "--memory", "0", "--progress", "none"]
schemes = "euler-maruyama,milstein,half-explicit-euler"
assert execute(["matrix", "-s", schemes, "-p", "gbm,pendulum", *few, "--out", "run"]) == 0
assert execute(["gate", "-s", "milstein", "-p", "gbm", "--config", "pyproject.toml", *few[4:], "--out", "gate"]) == 0
assert execute(["show", "run", "milstein"]) == 0
assert execute(["claims", "milstein", "run"]) == 5
assert execute(["list"]) == 0
import sdaeverify.testing
assert not [row for row in sdaeverify.testing.check_scheme("milstein") if row["status"] == "failed"]
"""
POLICY = """[tool.sdaeverify]
schemes = ["milstein"]
tier = "smoke"
hunt = "1 s"
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Build the wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (found,) = folder.glob("*.whl")
    return found


def install(wheel, site, part=()):
    """Unpack a wheel, without the files and folders of a part and the entry points that name it."""
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    for name in part:
        shutil.rmtree(site / name) if (site / name).is_dir() else (site / name).unlink()
    (entries,) = site.glob("*.dist-info/entry_points.txt")
    lines = entries.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line for line in lines if module_of(line) not in part]
    assert len(kept) < len(lines) or not any(name.startswith("sdaeverify_") for name in part)
    entries.write_text("".join(kept), encoding="utf-8")


def module_of(line):
    """Return the package that a line of entry points names."""
    return line.partition(" = ")[2].partition(":")[0].partition(".")[0].strip()


def run(site, folder):
    """Run commands from an installed copy alone, and return the rows that they wrote, by the name of the table."""
    folder.mkdir()
    (folder / "pyproject.toml").write_text(POLICY, encoding="utf-8")
    # Without `site` the repository, of which this environment has an editable install, is not found.
    places = os.pathsep.join([str(site), sysconfig.get_path("purelib")])
    done = subprocess.run(
        [sys.executable, "-S", "-c", RUN],
        env={**os.environ, "PYTHONPATH": places, "COLUMNS": "80"},
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    # Schemes claim more than is left to measure: that is said, and nothing else.
    warnings = [line for line in done.stderr.splitlines() if "warning" in line]
    assert all("claims about measure" in line and "which is not registered" in line for line in warnings), warnings
    assert (folder / "run" / "report.html").is_file()
    return {name: rows(folder / "run" / name) for name in ("verdicts.csv", "levels.csv", "details/classes.csv")}


def rows(file):
    """Return the cells of a table that hold something, row by row; other measures bring columns of their own."""
    with file.open(newline="", encoding="utf-8") as text:
        return [{name: told for name, told in row.items() if told} for row in csv.DictReader(text)]


@pytest.fixture(scope="module")
def whole(wheel, tmp_path_factory):
    """Return the rows of the whole."""
    place = tmp_path_factory.mktemp("whole")
    install(wheel, place / "site")
    return run(place / "site", place / "here")


@pytest.mark.parametrize("part", PARTS)
def test_what_is_left_is_the_same(part, wheel, whole, tmp_path):
    """Runs, gates, pages and readers of a run work without it, and every row of what is left has the same bits."""
    install(wheel, tmp_path / "site", PARTS[part])
    left = run(tmp_path / "site", tmp_path / "here")

    measures = {row["measure"] for row in left["verdicts.csv"]}
    assert {"strong", "weak", "drift"} <= measures
    for name, found in left.items():
        assert found == [row for row in whole[name] if row["measure"] in measures]
