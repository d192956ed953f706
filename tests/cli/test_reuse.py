"""What a resumed run measures again: what does something else or may, and nothing more."""

import sqlite3

import pytest

pytestmark = pytest.mark.long

SMALL = ("--block", "40", "--levels", "8..32", "--paths", "80", "--progress", "none", "--out", "out", "-j", "1")
# A limit of time is what gives one job a process of its own.
WORKER = ("--timeout", "60")
PLUGIN = '''
import json, sqlite3
from pathlib import Path
HERE = Path(__file__).parent
NOISE = 0.5

def weight():
    """Return a number."""
    return 1.0

def forcing(t):
    # The folder is put together where the step is made.
    table = np.loadtxt(HERE / ("tab" + "les") / "forcing.csv")
    return np.interp(t, np.linspace(0.0, 1.0, len(table)), table)

def forced():
    """Return an oscillation."""
    return SDE(
        drift=lambda t, x: forcing(t) - x,
        diffusion=lambda t, x: np.full((1, 1, 1), NOISE) + 0.0 * x,
        start=[1.0], noise_dim=1, horizon=1.0, source="nowhere",
    )

class Odd(Scheme):
    """A scheme."""
    name: ClassVar[str] = "odd"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

    def step(self, problem, state, t, h, noise):
        if 0.41 < t < 0.59:
            state = state + float((HERE / "shift.txt").read_text())
        return Step(state + weight() * h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))

@hookimpl
def sdaeverify_schemes():
    return [Odd()]

@hookimpl
def sdaeverify_problems():
    return [forced]
'''


@pytest.fixture
def run(call, write, tmp_path):
    """Write a plugin file with its tables, and run one of its schemes on its problem; return what is said."""
    (tmp_path / "tables").mkdir()
    write_table(tmp_path, 1.0)
    (tmp_path / "shift.txt").write_text("0.0")

    def made(plugin=PLUGIN, *further):
        words = ("-s", "odd", "-p", "forced", "-m", "strong", "--plugin", write(plugin), *further)
        outcome = call("matrix", *words, *SMALL)
        assert "Traceback" not in outcome.err
        return " ".join(outcome.out.split())

    return made


def write_table(folder, late):
    """Write the table of a forcing that is another one between .41 and .59 alone."""
    times = [step / 400 for step in range(401)]
    rows = (late if 0.41 < t < 0.59 else 1.0 for t in times)
    (folder / "tables" / "forcing.csv").write_text("\n".join(map(str, rows)))


def test_a_file_that_is_read_inside_a_step_counts(run, tmp_path):
    """A table or number that matters between .41 and .59 alone is measured again, and said to be why."""
    run()
    assert "computed" not in run()
    write_table(tmp_path, 1.01)

    assert "with another forcing.csv" in run()
    (tmp_path / "shift.txt").write_text("1e-12")
    assert "with another shift.txt" in run()
    assert "computed" not in run()


def test_what_a_process_reads_once_counts(run, tmp_path):
    """A table that is read as a plugin is imported, or once and kept, counts for what uses it."""
    kept = PLUGIN.replace("def forcing(t):", "from functools import cache\n\n@cache\ndef forcing(t):")
    kept = kept.replace("NOISE = 0.5", 'NOISE = json.loads((HERE / "noise.json").read_text())["noise"]')
    (tmp_path / "noise.json").write_text('{"noise": 0.5, "spare": 1}')
    run(kept, *WORKER)
    assert "computed" not in run(kept, *WORKER)

    (tmp_path / "noise.json").write_text('{"noise": 0.5, "spare": 2}')
    assert "with another noise.json" in run(kept, *WORKER)
    write_table(tmp_path, 1.01)
    assert "with another forcing.csv" in run(kept, *WORKER)


ELSEWHERE = """
def forcing(t):
    with sqlite3.connect(HERE / "forcing.sqlite") as rows:
        return rows.execute("SELECT max(f) FROM forcing").fetchone()[0]

def weight():
    with open(HERE / "log", "a") as log:
        log.write("x")
    try:
        return 0.0 * len((HERE / "log").read_text()) + float((HERE / "weight").read_text())
    except OSError:
        return 1.0

def forced"""


def test_whatever_a_plugin_opens_counts_but_what_it_writes(run, tmp_path):
    """So do a database and a file that was looked for in vain; a log that a scheme reads again does not."""
    with sqlite3.connect(tmp_path / "forcing.sqlite") as rows:
        rows.execute("CREATE TABLE forcing (f)")
        rows.execute("INSERT INTO forcing VALUES (1.0)")
    before, _, after = PLUGIN.partition("def weight():")
    plugin = before + ELSEWHERE.strip() + after[after.index("def forced") + len("def forced") :]
    run(plugin)
    assert "computed" not in run(plugin)

    with sqlite3.connect(tmp_path / "forcing.sqlite") as rows:
        rows.execute("INSERT INTO forcing VALUES (0.5)")
    assert "with another forcing.sqlite" in run(plugin)
    (tmp_path / "weight").write_text("1.0")
    assert "with another weight" in run(plugin)
