"""Parts that are no core: each is deleted from an installed copy with its entry points, and the rest is as before."""

import compileall
import csv
import json
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
PLUGINS = (
    "adaptive",
    "bridges",
    "hunt",
    "lab",
    "lab/papers",
    "lab/planted",
    "measures",
    "orders",
    "runs",
    "sealed",
    "wire",
)
# By name, files and folders of an installed copy.
PARTS = {name: (f"sdaeverify_{name}",) for name in PLUGINS}
# A scheme on a problem of another form, and schemes of several forms on two problems, with what order conditions and
# random members say of them.
SIZES = {
    "one": ("euler-maruyama", "pendulum"),
    "several": ("euler-maruyama,milstein,half-explicit-euler", "gbm,pendulum"),
}
RUN = """
import sys
from sdaeverify.cli.program import execute

few = ["--paths", "200", "--levels", "8..32", "-j", "1", "--timeout", "0", "--memory", "0", "--progress", "none"]
assert execute(["matrix", "-s", sys.argv[1], "-p", sys.argv[2], *few, "--out", "run"]) == 0
assert execute(["gate", "-s", "milstein", "-p", "gbm", "--config", "pyproject.toml", *few[4:], "--out", "gate"]) == 0
assert execute(["show", "run", "euler-maruyama"]) == 0
assert execute(["claims", "euler-maruyama", "run"]) == 5
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
def whole(tmp_path_factory):
    """Build the wheel, unpack it, and compile its modules once for all copies."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    assert compileall.compile_dir(folder / "site", quiet=1)
    return folder / "site"


def install(whole, site, part=()):
    """Copy what is installed, without the files and folders of a part and the entry points that name it."""
    shutil.copytree(whole, site)
    for name in part:
        shutil.rmtree(site / name) if (site / name).is_dir() else (site / name).unlink()
    (entries,) = site.glob("*.dist-info/entry_points.txt")
    lines = entries.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line for line in lines if not any(f"{module_of(line)}/".startswith(f"{name}/") for name in part)]
    assert len(kept) < len(lines) or not any(name.startswith("sdaeverify_") for name in part)
    entries.write_text("".join(kept), encoding="utf-8")


def module_of(line):
    """Return the module that a line of entry points names, as a path."""
    return line.partition(" = ")[2].partition(":")[0].strip().replace(".", "/")


def run(site, folder, size):
    """Run commands from an installed copy alone, and return the rows that they wrote, by the name of the table."""
    folder.mkdir()
    (folder / "pyproject.toml").write_text(POLICY, encoding="utf-8")
    # Without `site` the repository, of which this environment has an editable install, is not found.
    places = os.pathsep.join([str(site), sysconfig.get_path("purelib")])
    done = subprocess.run(
        [sys.executable, "-S", "-c", RUN, *SIZES[size]],
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


# Kinds of solvers that share their runs and verdicts, each with a command that the other's removal leaves as it is.
SOLVERS = {
    "sealed": ["--plugin", str(ROOT / "tests" / "sealed" / "exact_ou.py"), "exact-ou", "-p", "ou"],
    "adaptive": ["heun-pi", "-p", "ou", "--paths", "100", "--tolerances", "1e-1,1e-2,1e-3"],
}


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize(("kind", "other"), [("sealed", "adaptive"), ("sealed", "wire"), ("adaptive", "sealed")])
def test_kinds_of_solvers_do_not_need_each_other(kind, other, whole, tmp_path):
    """The rows of one kind of solvers are the same without the package of another one."""
    told = []
    for part in ((), (f"sdaeverify_{other}",)):
        site = tmp_path / f"site-{len(part)}"
        install(whole, site, part)
        words = [kind, *SOLVERS[kind], "-j", "1", "--progress", "none", "--json"]
        code = f"from sdaeverify.cli.program import execute; raise SystemExit(execute({words!r}))"
        places = os.pathsep.join([str(site), sysconfig.get_path("purelib")])
        done = subprocess.run(
            [sys.executable, "-S", "-c", code],
            env={**os.environ, "PYTHONPATH": places},
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        told.append([{**row, "seconds": None} for row in json.loads(done.stdout)])
    assert told[0] == told[1]
    assert told[0]


@pytest.fixture(scope="module", params=["one", pytest.param("several", marks=pytest.mark.slow)])
def size(request):
    """Return the size of the runs: every change makes small ones."""
    return request.param


@pytest.fixture(scope="module")
def rows_of_all(size, whole, tmp_path_factory):
    """Return the rows of the whole."""
    return run(whole, tmp_path_factory.mktemp("whole") / "here", size)


@pytest.mark.parametrize("part", PARTS)
def test_what_is_left_is_the_same(part, size, whole, rows_of_all, tmp_path):
    """Runs, gates, pages and readers of a run work without it, and every row of what is left has the same bits."""
    install(whole, tmp_path / "site", PARTS[part])
    left = run(tmp_path / "site", tmp_path / "here", size)

    measures = {row["measure"] for row in left["verdicts.csv"]}
    assert {"strong", "weak", "drift"} <= measures
    kept = (lambda row: not row["problem"].startswith("every-equation")) if part == "orders" else (lambda _: True)
    for name, found in left.items():
        assert found == [row for row in rows_of_all[name] if row["measure"] in measures and kept(row)]
        assert found or (part, name) == ("orders", "details/classes.csv")
