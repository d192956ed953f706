"""The table of public bug reports: each mistake is found, and no mended scheme is refuted."""

import csv
import importlib.util
import sys
from collections import Counter
from pathlib import Path

import pytest

from facade import load_registry, select_schemes

FOLDER = Path(__file__).parents[1] / "reports" / "bugs"
PAIRS = sorted((FOLDER / "pairs").glob("[a-z]*.py"))


@pytest.fixture(scope="module")
def program():
    """Return reports/bugs/run.py as a module."""
    spec = importlib.util.spec_from_file_location("bug_reports_run", FOLDER / "run.py")
    module = importlib.util.module_from_spec(spec)
    before = [*sys.path]
    spec.loader.exec_module(module)
    yield module
    sys.path[:] = before


@pytest.fixture(scope="module")
def table():
    """Return the rows of reports.csv."""
    with (FOLDER / "reports.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_table_has_every_pair(program, table):
    """The table has a row for each report, in the order of the files, and a line of the page with its address."""
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert [row["name"] for row in table] == [report.name for report in program.reports()]
    assert all(row["report"] in page for row in table)
    assert len({row["report"] for row in table}) >= 22


def test_no_verdict_of_table_is_wrong(table):
    """No faulty scheme of the table is verified and no mended one refuted."""
    wrong = Counter(row["name"] for row in table if row["faulty"] == "verified" or row["mended"] == "refuted")
    assert not wrong


@pytest.mark.parametrize("module", [path.stem for path in PAIRS])
def test_pairs_are_plugin(program, module):
    """Each file of pairs is a plugin whose schemes are mended unless they are asked for with ``mended=false``."""
    registry = load_registry([FOLDER / "pairs" / f"{module}.py"], environ={})
    for report in program.importlib.import_module(module).REPORTS:
        found = select_schemes(registry, [report.name, f"{report.name}[mended=false]"])
        assert [scheme.mended for scheme in found] == [True, False]


@pytest.mark.slow
def test_mistakes_are_found_and_mends_are_not(program):
    """Judged anew, no faulty scheme is verified and no mended one refuted."""
    found = [program.row_of(report) for report in program.reports()]
    assert not [row["name"] for row in found if row["faulty"] == "verified" or row["mended"] == "refuted"]
