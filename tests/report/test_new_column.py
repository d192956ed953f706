"""A new column of the verdicts is one file: a field of `VerdictRow`, and what a finding gives it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import sdaeverify.report.verdict_row
from evidence import rows_of

# Runs a command with another text of the module.
PROGRAM = """
import importlib.util, sys
from pathlib import Path
name = "sdaeverify.report.verdict_row"
spec = importlib.util.find_spec(name)
module = importlib.util.module_from_spec(spec)
sys.modules[name] = module
exec(compile(Path(sys.argv[1]).read_text(encoding="utf-8"), spec.origin, "exec"), vars(module))
from sdaeverify.cli.program import execute
sys.exit(execute(sys.argv[2:]))
"""
# Its run is a program of its own, since modules are loaded with another text.
pytestmark = pytest.mark.long
FIELD = '    run_time: float = _number("time that it took", "s", label="took")\n'
GIVEN = "            run_time=0.5,\n"


@pytest.fixture(scope="module")
def with_column(tmp_path_factory):
    """Return a function that runs a command with one more column, and the folder it runs in."""
    folder = tmp_path_factory.mktemp("wider")
    text = Path(sdaeverify.report.verdict_row.__file__).read_text(encoding="utf-8")
    head, tail = text.split("    paths: int = _whole(")
    wider = f"{head}{FIELD}    paths: int = _whole({tail}".replace(
        "            paths=result.paths,\n", f"{GIVEN}            paths=result.paths,\n"
    )
    assert wider.count("run_time") == 2
    (folder / "verdict_row.txt").write_text(wider, encoding="utf-8")

    def run(*arguments):
        words = [sys.executable, "-c", PROGRAM, str(folder / "verdict_row.txt"), *arguments]
        return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=True).stdout

    alone = ("-j", "1", "--timeout", "0", "--memory", "0", "--progress", "none")
    run("matrix", "-s", "milstein", "-p", "gbm", "-m", "strong", "--paths", "80", *alone, "--out", "run")
    return run, folder / "run"


def test_the_table_and_the_dictionary_have_it(with_column):
    """Each row has its value, and it is explained with its unit."""
    _, folder = with_column
    (told,) = [row for row in rows_of(folder / "columns.csv") if row["column"] == "run_time"]

    assert {row["run_time"] for row in rows_of(folder / "verdicts.csv")} == {"0.5"}
    assert (told["file"], told["unit"], told["meaning"]) == ("verdicts.csv", "s", "time that it took")


def test_the_page_has_it(with_column):
    """The numbers of the page hold the column, with the label under which a card tells it."""
    _, folder = with_column
    page = (folder / "report.html").read_text(encoding="utf-8")
    data = json.loads(page.partition('<script type="application/json" id="data">')[2].partition("</script>")[0])

    assert set(data["findings"]["run_time"]) == {0.5}
    assert ["run_time", "took"] in data["labels"]


def test_show_tells_it(with_column):
    """It is read from the folder and told of each quantity."""
    run, folder = with_column

    assert "took 0.5" in run("show", str(folder), "milstein", "gbm")
