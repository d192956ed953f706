"""Runs of several machines as one, and runs from elsewhere that do no harm."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from evidence import change_lanes, files_in, is_class, lanes_in, rows_of
from facade import read_limits, write_lanes
from sdaeverify.measuring import Tally

pytestmark = pytest.mark.long

SMALL = ("--block", "40", "--levels", "8..32", "-j", "1", "--progress", "none")
STRONG = ("-m", "strong")


@pytest.fixture
def made(call_once):
    """Run ``matrix`` at a small budget."""

    def run(out, *arguments, paths=80):
        assert call_once(out, "matrix", *arguments, *SMALL, "--paths", str(paths)).err == ""
        return Path(out)

    return run


@pytest.fixture
def merged(call):
    """Merge runs into the folder ``both``."""

    def run(*folders, further=()):
        before = {path for path in Path().rglob("*") if "both" not in path.parts}
        outcome = call("merge", *map(str, folders), "--out", "both", *further)
        assert "Traceback" not in outcome.err
        assert {path for path in Path().rglob("*") if "both" not in path.parts} == before
        return outcome

    return run


def rows(folder):
    """Return the verdicts of a run."""
    return rows_of(folder / "verdicts.csv")


def changed(folder, **changes):
    """Change what a run says it was about: its settings or its selection."""
    saved = json.loads((folder / "run.json").read_text())
    for name, value in changes.items():
        saved["settings" if name in saved["settings"] else "selection"][name] = value
    (folder / "run.json").write_text(json.dumps(saved))


def test_disjoint_runs(made, merged, monkeypatch):
    """Two runs with half of the problems each have, merged by a worker, the rows of one with all of them."""
    monkeypatch.setattr("sdaeverify.cli.commands.merge.read_limits", lambda *_: read_limits(60.0, None, 1))
    one = made("one", "-s", "milstein,euler-maruyama", "-p", "gbm", *STRONG)
    two = made("two", "-s", "milstein,euler-maruyama", "-p", "ou", *STRONG)
    whole = made("whole", "-s", "milstein,euler-maruyama", "-p", "gbm,ou", *STRONG)

    outcome = merged(one, two)

    assert rows(Path("both")) == rows(whole)
    assert (Path("both") / "levels.csv").read_text() == (whole / "levels.csv").read_text()
    assert outcome.code == 0
    assert outcome.err.count("blocks are new, 0 existed already") == 2


def test_runs_of_one_problem(made, merged):
    """Runs that share cells: each cell is there once, with the same numbers."""
    one = made("one", "-s", "milstein,stochastic-theta", "-p", "gbm", *STRONG)
    two = made("two", "-s", "milstein,euler-maruyama", "-p", "gbm", *STRONG)
    whole = made("whole", "-s", "milstein,stochastic-theta,euler-maruyama", "-p", "gbm", *STRONG)

    outcome = merged(one, two)

    assert rows(Path("both")) == rows(whole)
    assert "other numbers" not in outcome.err


def test_measures_of_one_cell_from_two_runs(made, merged):
    """Evidence of two measures on the same paths comes together in one file."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    two = made("two", "-s", "milstein", "-p", "gbm", "-m", "weak")
    whole = made("whole", "-s", "milstein", "-p", "gbm", "-m", "strong,weak")

    merged(one, two)

    assert rows(Path("both")) == rows(whole)


def test_a_run_with_itself(made, merged):
    """Merging a run with itself changes nothing, twice neither."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    merged(one)

    outcome = merged(one, one)

    assert rows(Path("both")) == rows(one)
    assert "0 blocks are new" in outcome.err
    assert "other numbers" not in outcome.err


def test_more_paths_in_one_of_the_runs(made, merged):
    """Of two numbers of paths the larger counts."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    two = made("two", "-s", "milstein", "-p", "gbm", *STRONG, paths=200)

    merged(one, two)

    assert rows(Path("both")) == rows(two)


def test_a_gap_is_told(made, merged):
    """Where evidence is missing nothing is computed: the rows say how to go on, and that does."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    for file in files_in(one):
        file.unlink()

    merged(one)

    assert {row["verdict"] for row in rows(Path("both"))} == {"not_run"}
    assert "matrix with the same --out computes it" in rows(Path("both"))[0]["reason"]
    assert not files_in(Path("both"))


def test_a_scheme_without_evidence_beside_others(made, merged, call, odd_scheme):
    """A scheme that failed costs its own cells of a merged run; the other cells of the problem are judged."""
    plugin = ("--plugin", odd_scheme("raise ValueError('no')"))
    call("matrix", "-s", "odd,milstein", "-p", "gbm", *STRONG, *SMALL, "--paths", "80", "--out", "one", *plugin)
    alone = made("alone", "-s", "milstein", "-p", "gbm", *STRONG)

    merged(Path("one"), further=plugin)

    found = rows(Path("both"))
    assert [row["verdict"] for row in found if row["scheme"] == "milstein"] == [row["verdict"] for row in rows(alone)]
    assert {row["verdict"] for row in found if row["scheme"] == "odd"} <= {"not_run", "error"}


@pytest.mark.parametrize(
    "name", ["seed", "block", "levels", "first_levels", "confidence", "coarsest", "max_looks", "tests_reserved"]
)
def test_other_settings_are_refused(made, merged, name):
    """Runs that cannot be one are refused in one line that names what differs."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    two = Path(shutil.copytree(one, "two"))
    other = {"seed": 1, "block": 80, "levels": 4, "first_levels": 5, "confidence": 0.9, "coarsest": 4, "max_looks": 2}
    value = {**other, "tests_reserved": 3}[name]
    changed(two, **{name: value})

    outcome = merged(one, two)

    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert f"two with {value}: cannot merge" in outcome.err
    assert f"one was run with {name}" in outcome.err
    assert not Path("both").exists()


def test_other_numbers_are_told(made, merged):
    """Of numbers that differ, the first ones stay, with a warning."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    two = Path(shutil.copytree(one, "two"))
    file, name, lane = next(found for found in lanes_in(two) if found[2].measures["strong"].sampled.sums)
    record = lane.measures["strong"]
    sums = {name: value + 1.0 for name, value in record.sampled.sums.items()}
    changed = lane._replace(measures={"strong": record._replace(sampled=Tally(sums))})
    write_lanes(file, {name: lambda _: changed})

    outcome = merged(one, two)

    assert rows(Path("both")) == rows(one)
    assert "two: 1 blocks exist with different numbers, which are kept" in outcome.err


def test_damaged_files_are_told(made, merged):
    """What cannot be read is left out, with a warning."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    files_in(one)[0].write_bytes(b"PK")

    outcome = merged(one)

    assert "one: 1 pieces of evidence are damaged and left out" in outcome.err


@pytest.mark.parametrize("file", ["both", "both/evidence"])
def test_a_folder_that_cannot_be_written(made, merged, file):
    """A file in the way of the merged run, or of its evidence, is told in one line."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    Path(file).parent.mkdir(exist_ok=True)
    Path(file).write_text("")

    outcome = merged(one)

    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert "cannot write" in outcome.err


def test_a_scheme_that_is_not_registered_here(made, merged, call, odd_scheme):
    """Its evidence is copied and not judged; the rest is."""
    plugin = odd_scheme("return Step(state)")
    chosen = ("-s", "odd,milstein", "-p", "gbm", *STRONG, "--plugin", plugin)
    call("matrix", *chosen, *SMALL, "--paths", "80", "--out", "one")

    outcome = merged(Path("one"))

    assert "unknown scheme 'odd'" in outcome.err
    assert "its evidence is copied but not judged" in outcome.err
    assert {row["scheme"] for row in rows(Path("both"))} == {"milstein"}


def test_nothing_is_known_here(made, merged):
    """A run about nothing that is registered is refused."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    changed(one, schemes=["somebody-elses"])

    outcome = merged(one)

    assert outcome.code == 2
    assert "nothing to merge" in outcome.err


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["../../x", "/tmp/x", "\x1b[2Jx", "a\nb", "::error::x", "x" * 3000, "", "[", "a[b=c"]
)
@pytest.mark.parametrize("kind", ["schemes", "problems"])
def test_names_from_elsewhere(made, merged, kind, name):
    """Whatever a run calls its schemes and problems, it is told on one line, and leads nowhere."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    changed(one, **{kind: [name, {"schemes": "milstein", "problems": "gbm"}[kind]]})

    outcome = merged(one)

    assert "\x1b" not in outcome.err
    assert all(line.startswith("sdaeverify: ") for line in outcome.err.splitlines())
    found = {(row["scheme"], row["problem"]) for row in rows(Path("both"))}
    assert {(scheme, problem) for scheme, problem in found if not is_class(problem)} == {("milstein", "gbm")}


HOSTILE = {
    "text": b"no json",
    "deep": b"[" * 200_000,
    "huge": None,
    "list": b"[]",
}


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE)
def test_runs_from_elsewhere(made, merged, content):
    """What is no run is refused in one line, and nothing is written."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    if content is None:
        changed(one, paths=10**18)
    else:
        (one / "run.json").write_bytes(content)

    outcome = merged(one)

    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert not Path("both").exists()


def twisted(lane, twist):
    """Return evidence in which every array is changed."""

    def tally(given):
        kinds = (given.sums, given.maxima, given.largest)
        return Tally(*({name: twist(value) for name, value in kind.items()} for kind in kinds))

    records = {n: r._replace(sampled=tally(r.sampled), probed=tally(r.probed)) for n, r in lane.measures.items()}
    return lane._replace(health=tally(lane.health), measures=records)


TWISTS = {
    "empty": lambda a: np.zeros(0),
    "scalar": lambda a: np.array(1.0),
    "longer": lambda a: np.concatenate([a.ravel(), a.ravel()]),
    "deeper": lambda a: a[..., None, None],
    "nan": lambda a: np.full_like(a, np.nan, dtype=float),
    "huge": lambda a: np.full_like(a, 1e308, dtype=float),
    "negative": lambda a: -np.asarray(a, dtype=float),
    "bool": lambda a: a > 0,
    "bytes": lambda a: np.asarray(a, dtype=np.uint8),
}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("first", [True, False], ids=["first block", "later block"])
@pytest.mark.parametrize("twist", TWISTS.values(), ids=TWISTS)
def test_numbers_from_elsewhere(made, merged, twist, first):
    """Evidence that makes no sense has no traceback: it costs the cells it is about."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG, "--max-looks", "1", paths=200)
    file, name, lane = sorted(lanes_in(one), key=lambda found: found[1])[0 if first else -1]
    write_lanes(file, {name: lambda _: twisted(lane, twist)})

    outcome = merged(one)

    assert outcome.code in {0, 1, 3}
    assert rows(Path("both"))


@pytest.mark.parametrize("paths", [-5, 0, 10**400], ids=["negative", "none", "huge"])
def test_counts_from_elsewhere(made, merged, paths):
    """A number of paths that is none has no traceback."""
    one = made("one", "-s", "milstein", "-p", "gbm", *STRONG)
    change_lanes(one, lambda lane: lane._replace(paths=paths, seconds=float("inf")))

    outcome = merged(one)

    assert outcome.code in {0, 1, 2, 3}
