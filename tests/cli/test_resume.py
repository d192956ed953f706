"""Runs that are killed, resumed, extended and begun afresh."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from evidence import is_class, lanes_in, rows_of

pytestmark = pytest.mark.long

PROGRAM = (sys.executable, "-m", "sdaeverify", "matrix", "-p", "gbm,ou,pendulum", "-m", "strong,weak,drift")
CHOSEN = ("-s", "milstein,euler-maruyama,half-explicit-euler", "--paths", "1024", "--max-looks", "3", "-j", "2")
MOMENTS = 20
PATIENCE = 600.0


def begin(folder: Path, *further: str) -> "subprocess.Popen[str]":
    """Start the run in a session of its own."""
    pipe, words = subprocess.PIPE, (*PROGRAM, *CHOSEN, "--progress", "none", "--out", str(folder), *further)
    return subprocess.Popen(words, stdout=pipe, stderr=pipe, text=True, start_new_session=True)


def finish(folder: Path, *further: str) -> str:
    """Carry a run to its end and return what it says."""
    out, err = begin(folder, *further).communicate(timeout=PATIENCE)
    assert err == ""
    return out


def tables(folder: Path) -> tuple[str, list[dict[str, str]]]:
    """Return both tables."""
    return (folder / "levels.csv").read_text(), rows_of(folder / "verdicts.csv")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    """Return the folder of a run that nobody interrupted, and how long it took."""
    folder, begun = tmp_path_factory.mktemp("whole"), time.monotonic()
    finish(folder)
    return folder, time.monotonic() - begun


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals are a matter of POSIX")
@pytest.mark.parametrize("moment", range(MOMENTS))
def test_a_killed_run_goes_on(whole, tmp_path, moment):
    """After kill -9 at a random moment, of its workers too or not, it has the tables of a run nobody interrupted."""
    rng = np.random.default_rng(moment)
    process = begin(tmp_path)
    time.sleep(whole[1] * rng.random())
    kill = os.killpg if moment % 2 else os.kill
    kill(process.pid, signal.SIGKILL)
    process.communicate()

    finish(tmp_path)

    assert tables(tmp_path) == tables(whole[0])
    # The tables are written by the main process, which is always killed; evidence by workers.
    assert not list((tmp_path / "evidence").rglob(".unfinished-*")) or moment % 2


SMALL = ("--block", "40", "--levels", "8..32", "-j", "1", "--progress", "none")


@pytest.fixture
def small(call, call_once, tmp_path):
    """Run ``matrix`` in this process at a small budget; return what it says and both tables."""

    def run(out, *arguments, paths=80):
        words = ("matrix", *arguments, *SMALL, "--paths", str(paths))
        outcome = call(*words, "--out", out) if (tmp_path / out).exists() else call_once(out, *words)
        assert "Traceback" not in outcome.err
        return outcome, tables(tmp_path / out)

    return run


def evidence(folder):
    """Return how long each lane took, to the last digit: one that is computed anew took another time."""
    return {(file.name, name): lane.seconds for file, name, lane in lanes_in(folder)}


TWO = ("-s", "milstein,euler-maruyama", "-p", "gbm", "-m", "strong,weak")
BOTH = ("-s", "milstein,euler-maruyama", "-p", "gbm,ou", "-m", "strong,weak")


def test_a_repeated_run_reuses_everything(small, tmp_path):
    """A run that is made again writes the same tables, computes nothing, and says so."""
    chosen = ("-s", "milstein,half-explicit-euler", "-p", "gbm,pendulum")
    first, before = small("out", *chosen)
    files = evidence(tmp_path / "out")

    second, after = small("out", *chosen)

    assert {row["measure"] for row in before[1]} >= {"drift", "strong", "weak"}
    assert after == before
    assert evidence(tmp_path / "out") == files
    assert "was reused" not in first.out
    said = " ".join(second.out.split())
    assert f"evidence of {len(files)} of {len(files)} blocks of paths, controls included, was reused, and the" in said
    assert re.search(r"findings of \d+ tests on classes of equations", said)
    assert "computed" not in second.out


def test_another_selection_into_the_same_folder(small, tmp_path):
    """Its tables replace those that were there, and evidence of both selections is reused."""
    _, before = small("out", *TWO)
    small("out", "-s", "euler-maruyama", "-p", "ou", "-m", "weak")

    assert {name for row in tables(tmp_path / "out")[1] if not is_class(name := row["problem"])} == {"ou"}
    outcome, after = small("out", *TWO)
    assert after == before
    assert "computed" not in outcome.out


def test_afresh(small, tmp_path):
    """With --fresh everything is computed again, to the same numbers."""
    _, before = small("out", *TWO)
    files = evidence(tmp_path / "out")

    outcome, after = small("out", *TWO, "--fresh")

    assert after == before
    assert evidence(tmp_path / "out").keys() == files.keys()
    assert not evidence(tmp_path / "out").items() & files.items()
    reused = f"evidence of 0 of {len(files)} blocks of paths, controls included, was reused"
    told = f"{reused}; the others were computed: {len(files)} on request"
    assert told in " ".join(outcome.out.split())


def test_further_measures_and_schemes(small):
    """What is added to a run later comes to what it comes to beside the rest from the start."""
    whole = small("whole", *TWO)[1]
    small("parts", "-s", "milstein", "-p", "gbm", "-m", "strong")
    small("parts", "-s", "milstein", "-p", "gbm", "-m", "weak")

    outcome, parts = small("parts", *TWO)

    assert parts == whole
    assert "was reused" in outcome.out


@pytest.mark.slow
def test_fewer_measures(small):
    """A cell that is judged by itself, from files of a larger run, comes to what it comes to in a fresh folder."""
    small("out", "-s", "milstein,half-explicit-euler", "-p", "gbm,pendulum")
    for measure in ("drift", "weak", "effort", "moments"):
        chosen = ("-s", "milstein,half-explicit-euler", "-p", "gbm,pendulum", "-m", measure)

        assert small("out", *chosen)[1] == small(measure, *chosen)[1]


def test_more_paths(small, tmp_path):
    """More paths in the folder of a run with fewer are a run with more; no whole block is computed again."""
    fresh = small("fresh", *TWO, paths=400)[1]
    small("out", *TWO, paths=100)
    files = evidence(tmp_path / "out")

    outcome, extended = small("out", *TWO, paths=400)

    assert extended == fresh
    assert files.items() <= evidence(tmp_path / "out").items()
    assert "was reused" in outcome.out


def test_damaged_evidence(small, tmp_path):
    """A file that was cut is computed again, and said to have been damaged; those of other problems are reused."""
    _, before = small("out", *BOTH)
    file = tmp_path / "out" / "evidence" / "gbm.sqlite"
    file.write_bytes(file.read_bytes()[:100])

    outcome, after = small("out", *BOTH)

    lanes = evidence(tmp_path / "out")
    damaged = sum(name == "gbm.sqlite" for name, _ in lanes)
    assert after == before
    told = " ".join(outcome.out.split())
    assert (
        f"evidence of {len(lanes) - damaged} of {len(lanes)} blocks of paths, controls included, was reused" in told
    )
    # What is written first takes the place of the file: of the blocks that follow nothing is there any more.
    assert "the others were computed: " in told
    assert " damaged" in told


FILE = """
class Odd(Scheme):
    name: ClassVar[str] = "odd"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

    def step(self, problem, state, t, h, noise):
        factor = float(os.environ["ODD_" + "WEIGHT"])
        return Step(state + factor * h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))

@hookimpl
def sdaeverify_schemes():
    return [Odd()]
"""


def test_another_behaviour(small, write, monkeypatch):
    """A scheme that does something else is measured again and refuted, in the folder where it was not."""
    chosen = ("-s", "odd", "-p", "ou", "-m", "strong", "--plugin", write(FILE))
    monkeypatch.setenv("ODD_WEIGHT", "1.0")
    right, _ = small("out", *chosen)
    again, _ = small("out", *chosen)
    monkeypatch.setenv("ODD_WEIGHT", "1.5")

    wrong, _ = small("out", *chosen)

    assert [right.code, again.code, wrong.code] == [0, 0, 1]
    assert "computed" not in again.out
    assert "with another behaviour of the scheme" in " ".join(wrong.out.split())


def test_one_file_a_problem(small, tmp_path):
    """However many schemes and blocks there are, evidence on a problem is one file, and that on classes another."""
    small("out", *BOTH, paths=400)

    names = sorted(path.name for path in (tmp_path / "out" / "evidence").iterdir())
    assert names == ["classes.msgpack", "gbm.sqlite", "ou.sqlite"]
    assert len(lanes_in(tmp_path / "out")) > 20
