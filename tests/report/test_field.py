"""The report on other libraries: tables, pages and folders of findings agree."""

import re
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pandas as pd
import pytest

FIELD = Path(__file__).parents[2] / "reports" / "field"
PAGE = (FIELD / "README.md").read_text()
FOLDERS = sorted(folder for folder in (FIELD / "findings").iterdir() if folder.is_dir())


@pytest.fixture(scope="module")
def program():
    """Return the program that asks for order conditions."""
    spec = spec_from_file_location("field_classes", FIELD / "classes.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def classes():
    """Return the rows that it wrote."""
    return pd.read_csv(FIELD / "classes.csv")


def test_the_table_of_the_page_is_that_of_its_rows(program, classes):
    """What stands between the marks is written from classes.csv."""
    [told] = re.findall(f"{program.BEGIN}\n(.*?){program.END}", PAGE, re.DOTALL)
    assert told.strip().splitlines() == list(program.table(classes))


def test_an_order_tells_what_is_documented_if_that_is_another(program):
    """In brackets; in italics if nothing is."""
    row = {"scheme": "s", "class": "ode", "motions": 0}
    rows = pd.DataFrame([{**row, "order": 1.0, "claim": 0.5}, {**row, "order": 2.0, "claim": float("nan")}])
    assert list(program.table(rows))[2].startswith("| `s` | 1 (0.5) / *2* | - |")


def test_refuted_rows_are_findings(classes):
    """What is refuted for a class is Milstein's method of torchsde, which has its two folders."""
    refuted = classes[classes["verdict"] == "refuted"]
    assert set(refuted["scheme"].str.extract(r"(.*)\[method=milstein", expand=False)) == {
        "torchsde-ito",
        "torchsde-stratonovich",
    }
    assert not set(classes["verdict"]) & {"error"}


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_a_finding_has_all_that_a_maintainer_reads(folder):
    """A page with line, mend, upstream and draft; a script without this package; its output; a place in the lists."""
    page = (folder / "README.md").read_text()
    for part in ("**The line", "**Upstream.**", "## Draft of the issue"):
        assert part in page
    assert "sdaeverify" not in (folder / "check.py").read_text()
    assert (folder / "output.txt").read_text().count("\n") >= 3
    assert f"(findings/{folder.name}/README.md)" in PAGE


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_numbers_of_a_finding_are_those_of_its_output(folder):
    """Each number of the page with an exponent or with three decimals or more is a rounded one of the output."""
    printed = [float(text) for text in re.findall(r"\d+\.?\d*(?:e-?\d+)?", (folder / "output.txt").read_text())]
    told = re.findall(r"(?<![\w.])\d\.\d{3,}(?![\w.])|\d\.\de-\d+", (folder / "README.md").read_text())
    for text in told:
        decimals = len(text.split("e")[0].split(".")[1])
        assert any(text in {f"{value:.{decimals}f}", f"{value:.{decimals}e}"} for value in printed), text


def test_links_of_the_page_are_folders_of_findings():
    """None is named that is not there."""
    assert set(re.findall(r"\(findings/([^/)]+)/README.md\)", PAGE)) == {folder.name for folder in FOLDERS}
