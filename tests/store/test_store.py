"""What is kept of a run is found again as long as nothing that determines it has changed."""

import sqlite3
from dataclasses import replace
from importlib import metadata
from typing import ClassVar

import numpy as np
import pytest

from evidence import damage_lanes, files_in, lanes_in
from facade import (
    DAMAGED,
    MADE_WITH,
    NEW,
    SOURCELESS,
    Drift,
    Entry,
    EulerMaruyama,
    SchemeEvidence,
    StochasticTheta,
    Store,
    Strong,
    Task,
    Weak,
    behaviours,
    code,
    digest_of_file,
    gbm,
    join_parts,
    keep,
    key,
    lane_ingredients,
    measure_ingredients,
    ou,
    problem_spec,
    read_lanes,
    run_block,
    write_lanes,
)
from facade import keys as keys_module
from sdaeverify import Settings, UsageError
from sdaeverify.measuring import Measure, Tally

SETTINGS = Settings(paths=120, block=40, levels=3)
ONE = (Strong(),)
TALLY = Tally({"paths": np.array([40.0])})
STEPS = Tally({"steps": np.array([320.0])})


class Probing(Measure):
    """A measure whose probe looks at the budget."""

    name: ClassVar[str] = "probing"
    budgeted: ClassVar[bool] = True


def task(scheme=None, measures=ONE, settings=SETTINGS, family=gbm, **parameters):
    """Return a task of one scheme."""
    texts = {name: str(value) for name, value in parameters.items()}
    return Task(problem_spec(family, texts), (Entry(scheme or EulerMaruyama(), tuple(measures)),), settings)


def made_up(entry, **changes):
    """Return evidence that nobody simulated."""
    nothing = tuple("" for _ in entry.measures)
    tallies, probes = tuple(TALLY for _ in nothing), tuple(Tally() for _ in nothing)
    return SchemeEvidence(tallies, probes, STEPS, 0.5, nothing, 40)._replace(**changes)


def filled(folder, given=None, block=0, **changes):
    """Keep evidence of a task."""
    given = given or task()
    recalled = Store(folder).recall(given, block)
    entries, did = [Entry(r.entry.scheme, r.missing) for r in recalled], behaviours(given)
    lanes = [made_up(entry, behaviour=one, **changes) for entry, one in zip(entries, did, strict=True)]
    keep({r.entry.scheme.label: r.place for r in recalled}, entries, lanes)


def found(folder, given=None, block=0, **options):
    """Return what is recalled of a task, and the store."""
    store = Store(folder, **options)
    (recalled,) = store.recall(given or task(), block)
    return recalled, store


def test_what_was_kept_is_found(tmp_path):
    """Numbers, health, paths and time of a block come back, and it is counted as reused."""
    filled(tmp_path)

    recalled, store = found(tmp_path)

    assert recalled.missing == ()
    assert recalled.entry == task().entries[0]
    assert recalled.lane.tallies[0].sums["paths"] == 40.0
    assert recalled.lane.health.sums["steps"] == 320.0
    assert (recalled.lane.seconds, recalled.lane.paths, recalled.lane.errors) == (0.5, 40, ("",))
    assert (store.reused, dict(store.reasons)) == (1, {})
    assert store.summary() == "evidence of 1 of 1 blocks of paths, controls included, was reused"


def test_nothing_is_there_at_first(tmp_path):
    """An empty folder has nothing to tell."""
    recalled, store = found(tmp_path)

    assert recalled.lane is None
    assert [measure.name for measure in recalled.missing] == ["strong"]
    assert dict(store.reasons) == {NEW: 1}
    assert not store.telling


SETTING = {"seed": 1, "levels": 4, "coarsest": 4, "block": 60}
OTHERS = {
    **{name: (task(settings=replace(SETTINGS, **{name: value})), 2) for name, value in SETTING.items()},
    "problem": (task(family=ou), 2),
    "parameter of the problem": (task(a=0.25), 2),
    "scheme": (task(StochasticTheta()), 2),
    "parameter": (task(StochasticTheta(theta=0.75)), 2),
    "block": (task(), 0),
    "fewer paths of the last block": (task(settings=replace(SETTINGS, paths=100)), 2),
}


@pytest.mark.parametrize(("other", "block"), OTHERS.values(), ids=OTHERS)
def test_evidence_of_something_else_is_new(tmp_path, other, block):
    """Nothing that determines the numbers may be another one; what there is stays beside what is new."""
    for given in (task(), task(StochasticTheta(theta=0.6))):
        filled(tmp_path, given, block=2)

    recalled, store = found(tmp_path, other, block)
    filled(tmp_path, other, block)

    assert recalled.lane is None
    assert dict(store.reasons) == {NEW: 1}
    assert found(tmp_path, other, block)[0].missing == found(tmp_path, block=2)[0].missing == ()


def rewrite(monkeypatch, thing, **changes):
    """Make a class or function one that is written in other code, or of which nothing is known."""
    read, other = keys_module.code_of, (lambda code: code._replace(**changes) if changes else None)
    monkeypatch.setattr(keys_module, "code_of", lambda asked: other(read(asked)) if asked is thing else read(asked))


MADE = {"code of the scheme": EulerMaruyama, "code of the problem": gbm, "framework": None}


@pytest.mark.parametrize("name", MADE)
def test_what_other_code_made_is_not_reused(tmp_path, monkeypatch, name):
    """A change of code that makes the paths, or of what measures, is named."""
    filled(tmp_path)
    if MADE[name]:
        rewrite(monkeypatch, MADE[name], digest="other")
    else:
        monkeypatch.setattr(keys_module, "framework_code", lambda: "another")

    recalled, store = found(tmp_path)

    assert recalled.lane is None
    assert dict(store.reasons) == {f"with another {name}": 1}


@pytest.fixture
def installed(monkeypatch):
    """Return a function that installs another version of numpy."""
    known = metadata.version

    def install(version):
        monkeypatch.setattr(metadata, "version", lambda name: version if name == "numpy" else known(name))
        code._versions.cache_clear()

    yield install
    monkeypatch.undo()
    code._versions.cache_clear()


def test_corrections_of_a_library_do_not_count(tmp_path, installed):
    """Evidence of numpy 2.4.6 is reused with 2.4.7, and not with 2.5."""
    installed("2.4.6")
    filled(tmp_path)

    installed("2.4.7")
    assert found(tmp_path)[1].reused == 1
    installed("2.5.0")
    assert dict(found(tmp_path)[1].reasons) == {"with another version of a library": 1}


def test_other_code_of_a_measure_costs_that_measure_only(tmp_path, monkeypatch):
    """Of two measures, the one that did not change is reused, and the other replaced."""
    given = task(measures=(Strong(), Weak()))
    filled(tmp_path, given)
    rewrite(monkeypatch, Weak, digest="other")

    recalled, store = found(tmp_path, given)
    filled(tmp_path, given)

    assert [measure.name for measure in recalled.entry.measures] == ["strong"]
    assert [measure.name for measure in recalled.missing] == ["weak"]
    assert dict(store.reasons) == {"of which a measure has changed": 1}
    assert found(tmp_path, given)[0].missing == ()


def test_files_that_were_opened_hold_what_they_held(tmp_path):
    """Evidence is reused as long as the files that code had opened for it do, whichever measures it is of."""
    table, other = tmp_path / "table.txt", tmp_path / "other.txt"
    table.write_text("1.0")
    other.write_text("1.0")
    (held,) = {digest_of_file(str(path)) for path in (table, other)}
    both = task(measures=(Strong(), Weak()))
    filled(tmp_path, opened=((str(table), held),))
    filled(tmp_path, both, opened=((str(table), held), (str(other), held)))
    assert found(tmp_path, both)[0].missing == ()

    other.write_text("2.0 and more")

    assert dict(found(tmp_path)[1].reasons) == {"with another other.txt": 1}


BUDGETS = {"paths": 200, "max_looks": 2, "confidence": 0.9, "tests_reserved": 7}


@pytest.mark.parametrize("name", BUDGETS)
def test_another_budget_is_not_reused_where_a_probe_looks_at_it(tmp_path, name):
    """How many paths there are and when they are judged leaves a block as it is, but for such a measure."""
    measures = (Strong(), Probing())
    filled(tmp_path, task(measures=measures))

    recalled, _ = found(tmp_path, task(measures=measures, settings=replace(SETTINGS, **{name: BUDGETS[name]})))

    assert [measure.name for measure in recalled.missing] == ["probing"]
    assert [measure.name for measure in recalled.entry.measures] == ["strong"]


def test_a_measure_is_added_to_what_is_there(tmp_path):
    """Evidence on one more measure goes into the same file, beside that on the others, with the fuller health."""
    filled(tmp_path, health=Tally({"steps": np.array([0.0])}), seconds=1.0)
    both = task(measures=(Strong(), Drift()))

    recalled, store = found(tmp_path, both)
    filled(tmp_path, both, seconds=2.0)

    assert dict(store.reasons) == {"to which a measure was added": 1}
    assert [measure.name for measure in recalled.missing] == ["drift"]
    assert len(lanes_in(tmp_path)) == 1
    lane = found(tmp_path, both)[0].lane
    assert (lane.seconds, lane.health.sums["steps"]) == (3.0, 320.0)


def test_parts_are_put_together_in_the_order_of_the_entry():
    """Of two parts of the measures of a scheme the evidence is that of the whole."""
    entry = Entry(EulerMaruyama(), (Drift(), Strong(), Weak()))
    one, two = Entry(entry.scheme, (Strong(),)), Entry(entry.scheme, (Weak(), Drift()))
    numbers = [Tally({"x": np.array([value])}) for value in (1.0, 2.0, 3.0)]
    parts = [
        (one, made_up(one, tallies=(numbers[1],), errors=("lost",))),
        (two, made_up(two, tallies=(numbers[2], numbers[0]), health=Tally())),
    ]

    whole = join_parts(entry, parts)

    assert [tally.sums["x"].item() for tally in whole.tallies] == [1.0, 2.0, 3.0]
    assert whole.errors == ("", "lost", "")
    assert whole.health.sums["steps"] == 320.0
    assert (whole.seconds, whole.paths) == (1.0, 40)


def test_computed_later_is_computed_together():
    """A measure that is simulated by itself has the numbers, health and paths it has beside others."""
    together = task(measures=(Strong(), Weak()))
    (whole,) = run_block(together, 0)
    parts = [(part.entries[0], run_block(part, 0)[0]) for part in (task(), task(measures=(Weak(),)))]

    lane = join_parts(together.entries[0], parts)

    assert lane.paths == whole.paths
    for one, other in zip(
        (*lane.tallies, *lane.probes, lane.health), (*whole.tallies, *whole.probes, whole.health), strict=True
    ):
        assert one.sums.keys() == other.sums.keys()
        assert all(np.array_equal(one.sums[name], other.sums[name], equal_nan=True) for name in one.sums)
        assert one.largest.keys() == other.largest.keys()
        assert all(np.array_equal(one.largest[name], other.largest[name]) for name in one.largest)


def test_what_failed_is_not_kept(tmp_path):
    """A measure that failed, a scheme that failed and one that breaks a contract are tried again."""
    both = task(measures=(Strong(), Weak()))
    filled(tmp_path, both, errors=("measure strong: KeyError", ""))
    filled(tmp_path, both, block=1, errors=("KeyError", "KeyError"))
    filled(tmp_path, both, block=2, violation="draws noise of its own")

    assert [measure.name for measure in found(tmp_path, both)[0].missing] == ["strong"]
    assert found(tmp_path, both, block=1)[0].lane is None
    assert found(tmp_path, both, block=2)[0].lane is None
    assert len(lanes_in(tmp_path)) == 1


def test_afresh(tmp_path):
    """What is there is left unread if that is asked for, and replaced as a whole."""
    both = task(measures=(Strong(), Weak()))
    filled(tmp_path, both)

    recalled, store = found(tmp_path, fresh=True)
    (entry,) = task().entries
    keep(
        {entry.scheme.label: recalled.place}, [entry], [made_up(entry, seconds=9.0, behaviour=behaviours(task())[0])]
    )

    assert recalled.lane is None
    assert dict(store.reasons) == {"on request": 1}
    assert [measure.name for measure in found(tmp_path, both)[0].missing] == ["weak"]
    assert found(tmp_path)[0].lane.seconds == 9.0


@pytest.mark.parametrize("length", [-1200, 100, 0], ids=["end", "beginning", "nothing"])
def test_a_damaged_file_is_computed_again(tmp_path, length):
    """A file that was cut is said to be damaged, and replaced."""
    filled(tmp_path)
    (file,) = files_in(tmp_path)
    file.write_bytes(file.read_bytes()[:length])

    recalled, store = found(tmp_path)
    filled(tmp_path)

    assert recalled.lane is None
    assert dict(store.reasons) == {DAMAGED: 1}
    assert found(tmp_path)[0].missing == ()


def test_a_damaged_row_costs_itself(tmp_path):
    """Of two blocks in a file the one that can be read is reused, and the other replaced."""
    filled(tmp_path)
    filled(tmp_path, block=1)
    (file,) = files_in(tmp_path)
    damage_lanes(file, lambda content: content[:-9])
    filled(tmp_path, block=1)

    assert found(tmp_path, block=1)[0].missing == ()
    assert dict(found(tmp_path)[1].reasons) == {DAMAGED: 1}
    filled(tmp_path)
    assert found(tmp_path)[0].missing == ()


def test_a_lane_under_the_name_of_another_is_not_believed(tmp_path):
    """What evidence says it is about counts, not what it is called; nothing of it is taken over."""
    filled(tmp_path, task(measures=(Strong(), Weak())), block=1)
    ((file, _, lane),) = lanes_in(tmp_path)
    name = found(tmp_path, block=0)[0].place.name
    write_lanes(file, {name: lambda _: lane})

    recalled, store = found(tmp_path)
    filled(tmp_path)

    assert recalled.lane is None
    assert dict(store.reasons) == {"with another index": 1}
    assert set(read_lanes(file, [name])[name].measures) == {"strong"}


def test_code_without_a_source_is_not_kept(tmp_path, monkeypatch):
    """Where nothing is known of what determines evidence, none is kept."""
    rewrite(monkeypatch, EulerMaruyama)

    filled(tmp_path)

    assert not list(tmp_path.iterdir())
    assert dict(found(tmp_path)[1].reasons) == {SOURCELESS: 1}


def test_a_measure_without_a_source_is_not_kept(tmp_path, monkeypatch):
    """Of two measures, the one whose source is known is."""
    rewrite(monkeypatch, Weak)
    both = task(measures=(Strong(), Weak()))

    filled(tmp_path, both)

    assert [measure.name for measure in found(tmp_path, both)[0].missing] == ["weak"]


def test_whether_all_is_there(tmp_path):
    """A study asks before it judges from what is stored alone; that leaves no trace."""
    filled(tmp_path)
    filled(tmp_path, block=1)
    store = Store(tmp_path)

    assert store.lacking(task(), range(2)) == set()
    assert store.lacking(task(), range(3)) == {(EulerMaruyama(), "strong")}
    assert store.lacking(task(measures=(Strong(), Weak())), range(1)) == {(EulerMaruyama(), "weak")}
    assert (store.reused, dict(store.reasons)) == (0, {})


def test_reasons_are_summed_up(tmp_path):
    """How much was reused and why the rest was not is one line, the most frequent reason first."""
    filled(tmp_path)
    store = Store(tmp_path)
    for block in range(3):
        store.recall(task(), block)

    reused, computed = store.summary().split("; ")
    assert reused == "evidence of 1 of 3 blocks of paths, controls included, was reused"
    assert computed == "the others were computed: 2 without stored evidence"


def test_a_full_disk(tmp_path, monkeypatch):
    """A full disk is an error in one line, and leaves what is there as it is."""
    filled(tmp_path)
    (before,) = lanes_in(tmp_path)
    full = "PRAGMA max_page_count = 1; "
    opened = sqlite3.connect

    class Full(sqlite3.Connection):
        def executescript(self, script):
            return super().executescript(full + script)

    monkeypatch.setattr(sqlite3, "connect", lambda *words, **options: opened(*words, factory=Full, **options))
    with pytest.raises(UsageError, match=r"cannot write .*database or disk is full; choose another --out"):
        filled(tmp_path, block=1)

    monkeypatch.undo()
    (after,) = lanes_in(tmp_path)
    assert (after[1], after[2].seconds) == (before[1], before[2].seconds)


def test_a_file_where_a_folder_belongs(tmp_path):
    """A file in the way is an error in one line."""
    (tmp_path / "evidence").write_text("")

    with pytest.raises(UsageError, match=r"^cannot write .*exists; choose another --out$"):
        filled(tmp_path)


def test_long_names(tmp_path):
    """Names as long as their authors like are names of files all the same, and are told apart."""

    def named(letter):
        class Long(EulerMaruyama):
            name: ClassVar[str] = "n" * 300 + letter

        return task(Long())

    filled(tmp_path, named("a"))

    assert found(tmp_path, named("a"))[0].missing == ()
    assert found(tmp_path, named("b"))[0].lane is None


def test_a_key_is_of_what_evidence_is_about():
    """Any change of it changes the key; what other code has made has the same key, and is replaced."""
    whole = lane_ingredients(EulerMaruyama(), problem_spec(gbm), SETTINGS, 0)
    others = {name: key({**whole, name: "other"}) for name in whole}

    assert {name for name, other in others.items() if other == key(whole)} == set(MADE_WITH)
    assert len(set(others.values())) == len(whole) - len(MADE_WITH) + 1


def test_builds_outside_python_are_code_of_the_scheme():
    """Evidence of another build has the same key and other ingredients; of an unknown build there is none."""
    ingredients = [
        lane_ingredients(
            type("Built", (EulerMaruyama,), {"build": build, "__module__": __name__})(),
            problem_spec(gbm),
            SETTINGS,
            0,
        )
        for build in ("one", "two", None)
    ]
    one, two, unknown = ingredients
    assert unknown is None
    assert key(one) == key(two)
    assert {name for name in one if one[name] != two[name]} == {"code of the scheme"}


def test_every_setting_is_an_ingredient_or_part_of_the_budget():
    """A setting that is added later counts, unless it is said to be part of the budget."""
    lane = lane_ingredients(EulerMaruyama(), problem_spec(gbm), SETTINGS, 0)
    own = measure_ingredients(Probing(), SETTINGS)

    assert {*lane, *own} >= {
        "paths",
        "coarsest",
        "levels",
        "seed",
        "confidence",
        "block",
        "max_looks",
        "tests_reserved",
    }
    assert keys_module.BUDGET.isdisjoint(lane)
