"""The built wheel carries everything: framework, schemes, problems, entry points."""

import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.long

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
    environment = {**os.environ, "COLUMNS": "", "PYTHONPATH": str(installed), "PYTHONWARNINGS": "error"}
    command = [sys.executable, "-m", "sdaeverify", *words]
    return subprocess.run(command, capture_output=True, text=True, check=True, cwd=installed, env=environment).stdout


def test_wheel_lists_the_shipped_plugins(installed):
    """From the wheel alone, list finds the shipped schemes, problems and measures."""
    listing = run(installed, "list")

    for name in ("half-explicit-euler", "pendulum-velocity-noise", "strong", "drift"):
        assert name in listing


@pytest.mark.slow
def test_wheel_runs_a_cell(installed, tmp_path):
    """From the wheel alone, a cell is measured and its files are written."""
    words = ["matrix", "-s", "milstein", "-p", "gbm", "--paths", "200", "-j", "1", "--out", str(tmp_path)]

    run(installed, *words)

    tables = {"verdicts.csv", "not_applicable.csv", "levels.csv", "columns.csv", "details"}
    written = {*tables, "run.json", "report.html", "evidence"}
    assert {path.name for path in tmp_path.iterdir() if path.suffix != ".parquet"} == written


def test_wheel_writes_a_plugin(installed, tmp_path):
    """From the wheel alone, new-plugin finds its template."""
    run(installed, "new-plugin", str(tmp_path / "rodeo"))

    assert (tmp_path / "rodeo" / ".github" / "workflows" / "verify.yml").is_file()


def test_extras_are_named_for_what_they_hold(installed):
    """Dask is Dask, a cluster's queue is beside it, and `all` is everything but other libraries and our own tools."""
    (metadata,) = installed.glob("*.dist-info/METADATA")
    told = [line for line in metadata.read_text(encoding="utf-8").splitlines() if line.startswith("Requires-Dist")]
    having = {extra: [line for line in told if f"extra == '{extra}'" in line] for extra in ("dask", "cluster", "all")}

    names = {extra: sorted(line.split()[1].partition(">")[0] for line in lines) for extra, lines in having.items()}
    assert names["dask"] == ["distributed"]
    assert names["cluster"] == ["dask-jobqueue", "distributed"]
    assert names["all"] == ["dask-jobqueue", "distributed", "hypothesis", "matplotlib", "xarray"]


def test_versions_of_python_are_those_of_the_install_page(installed):
    """A version that the metadata name is one whose tests have passed, as the page says."""
    (metadata,) = installed.glob("*.dist-info/METADATA")
    named = re.findall(
        r"(?m)^Classifier: Programming Language :: Python :: (3\.\d+)$", metadata.read_text(encoding="utf-8")
    )
    page = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    tested = re.findall(r"3\.\d+", " ".join(re.findall(r"(?m)^\| Linux, CPython ([^|]*) \| yes \|", page)))
    assert named == sorted(tested, key=lambda version: int(version.partition(".")[2]))


def test_wheel_holds_no_tests(installed):
    """Only the packages, their metadata and nothing else are in the wheel; what tests the verifier has one name."""
    tops = {path.name for path in installed.iterdir()}

    parts = "adaptive bridges hunt lab measures orders problems runs schemes sealed solvers wire"
    packages = {f"sdaeverify_{part}" for part in parts.split()}
    assert tops - {"sdaeverify", *packages} == {name for name in tops if name.endswith(".dist-info")}
    assert (installed / "sdaeverify" / "py.typed").is_file()
    assert {"papers", "planted", "selftest"} <= {path.name for path in (installed / "sdaeverify_lab").iterdir()}


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """Build the sdist and unpack it where nothing else of the repository is."""
    folder = tmp_path_factory.mktemp("sdist")
    build = [sys.executable, "-m", "build", "--sdist", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (archive,) = folder.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        packed.extractall(folder, filter="data")
    return folder / archive.name.removesuffix(".tar.gz")


# Reports of 50 kB or more in the sdist, each with the test or the extension of the site that reads it.
READERS = {
    "constants/constants.csv": "tests/trees/test_modified_linear.py",
    "field/classes.csv": "tests/report/test_field.py",
    "field/sdes/verdicts.csv": "tests/report/test_reasons.py",
    "random-sets/sets.jsonl": "docs/_ext/kept.py",
    "reference/details/invariant.csv": "tests/report/test_html.py",
    "reference/details/strong.csv": "tests/report/test_html.py",
    "reference/details/weak.csv": "tests/report/test_html.py",
    "reference/levels.csv": "tests/report/test_html.py",
    "reference/not_applicable.csv": "tests/report/test_html.py",
    "reference/run.json": "tests/test_reference_report.py",
    "reference/verdicts.csv": "tests/test_reference_report.py",
    "wrong-schemes/schemes.csv": "docs/_ext/kept.py",
}
LARGE, MOST = 50_000, 1e6


def test_sdist_leaves_out_what_nothing_reads(sources):
    """Pages, pictures and tables that nobody reads stay in the repository; each large report has a reader."""
    files = {path.relative_to(sources / "reports").as_posix(): path for path in (sources / "reports").rglob("*.*")}
    sizes = {name: path.stat().st_size for name, path in files.items() if path.is_file()}

    assert {name for name, size in sizes.items() if size >= LARGE} == {*READERS}
    assert not [name for name in sizes if name.endswith((".svg", "report.html"))]
    assert sum(size for size in sizes.values() if size < LARGE) < MOST
    assert [name for name, reader in READERS.items() if not (sources / reader).is_file()] == []


def in_sources(sources, *words):
    """Run a module of Python with the sources of the sdist in the place of what is installed."""
    path = os.pathsep.join(str(sources / part) for part in (".", "plugins", "problems"))
    environment = {**os.environ, "PYTHONPATH": path, "DOCS_GALLERY": "none"}
    command = [sys.executable, "-m", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=sources, env=environment)


@pytest.mark.slow
def test_sdist_builds_the_wheel(installed, sources, tmp_path):
    """The wheel that is built from the sdist has the files of the one that is built from the repository."""
    made = in_sources(sources, "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path), ".")

    assert made.returncode == 0, made.stderr
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if not name.endswith("/RECORD")}
    here = {path.relative_to(installed).as_posix() for path in installed.rglob("*") if path.is_file()}
    assert names == {name for name in here if not name.endswith("/RECORD") and "__pycache__" not in name}


@pytest.mark.slow
def test_sdist_builds_the_site(sources):
    """The site is built from the sdist, without a warning."""
    pytest.importorskip("sphinx_design")
    made = in_sources(sources, "sphinx", "-W", "-q", "docs", "docs/_site")

    assert made.returncode == 0, made.stderr
    assert (sources / "docs" / "_site" / "index.html").is_file()


@pytest.mark.slow
def test_sdist_passes_its_tests(sources):
    """The quick tests pass from the sdist."""
    made = in_sources(sources, "pytest", "-q", "-n", "0", "-m", "quick", "-p", "no:cacheprovider")

    assert made.returncode == 0, made.stdout[-2000:]


@pytest.mark.slow
def test_an_index_takes_it(sources):
    """The metadata of the sdist is whole, and its README renders."""
    pytest.importorskip("twine")
    checked = in_sources(sources, "twine", "check", "--strict", str(sources.with_name(f"{sources.name}.tar.gz")))

    assert checked.returncode == 0, checked.stdout
