"""Findings on classes of equations in the folder of a run: taken again while behaviour and code are the same."""

from collections import Counter
from dataclasses import dataclass, replace
from typing import ClassVar

import pytest

from facade import (
    ClassFindings,
    ClassTask,
    Entry,
    EulerMaruyama,
    Store,
    Strong,
    Study,
    class_findings,
    gbm,
    plan,
    problem_spec,
)
from sdaeverify import Claim, Settings, UsageError
from sdaeverify.measuring import Finding, Method, Reason, Verdict
from sdaeverify.studying import ClassTests

SETTINGS = Settings(paths=40, block=40, levels=3)
TESTED = Counter()


@dataclass(frozen=True)
class Kind:
    """A class of equations."""

    name: str = "all"


class Counted(ClassTests):
    """Tests that are counted."""

    def classes(self, entry, seed):
        """Yield one class."""
        yield Kind()

    claimed = classes

    def findings(self, entry, kind, seed, *, modified=False):
        """Yield one finding with numbers, texts and a claim."""
        TESTED[entry.scheme.label] += 1
        (claim,) = entry.scheme.claims
        reason = Reason("order {order:.1f}", "order", {"order": 0.5}).then("and a remark")
        details = {"motions": 2, "order": float("nan"), "first": "", "held": 0.1 + 0.2}
        found = {"quantity": "order", "verdict": Verdict.VERIFIED, "reason": reason, "claim": claim}
        yield "strong", Finding(**found, method=Method("counted"), details=details)

    def failed(self, entry, kind, why):
        """Yield an error."""
        yield "strong", Finding(quantity="", verdict=Verdict.ERROR, reason=Reason(why))


class Moved(EulerMaruyama):
    """Euler-Maruyama with a further drift, which is set from outside and is no part of its code."""

    name: ClassVar[str] = "moved"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=0.5, source="planted"),)
    drift: ClassVar[float] = 0.0

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        made = super().step(problem, state, t, h, noise)
        return made._replace(state=made.state + h * self.drift)


ENTRY = Entry(Moved(), (Strong(),))
TASK = ClassTask(Counted(), Kind(), (ENTRY,))


def findings(task=TASK):
    """Return the findings on a task, as they are computed."""
    return {entry: tuple(task.tests.findings(entry, task.kind, task.seed)) for entry in task.entries}


def known(folder, behaviour="as before", **options):
    """Return what is stored in a folder, for a scheme with some behaviour."""
    return ClassFindings(Store(folder, **options), {ENTRY.scheme: behaviour})


def test_findings_are_stored_to_the_last_bit(tmp_path):
    """What is recalled equals what was computed, claims and numbers included."""
    computed = findings()
    known(tmp_path).keep(TASK, computed)
    store = known(tmp_path)
    recalled = store.recall(TASK)

    assert repr(recalled) == repr(computed).replace("<Kind.PLAIN: ''>", "''")
    assert recalled[ENTRY][0][1].claim is ENTRY.scheme.promises[0]
    assert store.store.reused_findings == 1
    assert "and the findings of 1 tests on classes of equations" in store.store.summary()


@pytest.mark.parametrize(
    "other",
    [
        lambda folder: known(folder, "another behaviour").recall(TASK),
        lambda folder: known(folder, "").recall(TASK),
        lambda folder: known(folder, fresh=True).recall(TASK),
        lambda folder: known(folder).recall(replace(TASK, seed=1)),
        lambda folder: known(folder).recall(replace(TASK, modified=True)),
        lambda folder: known(folder).recall(replace(TASK, kind=Kind("others"))),
        lambda folder: known(folder).recall(TASK.only([Entry(ENTRY.scheme, ())])),
    ],
    ids=["behaviour", "unknown-behaviour", "fresh", "seed", "modified", "class", "measures"],
)
def test_other_ingredients_are_tested_again(tmp_path, other):
    """Findings made with other ingredients are not recalled."""
    known(tmp_path).keep(TASK, findings())

    assert known(tmp_path).recall(TASK)
    assert other(tmp_path) == {}


def test_other_code_is_tested_again(tmp_path, monkeypatch):
    """Findings made with other code are not recalled."""
    known(tmp_path).keep(TASK, findings())
    monkeypatch.setattr(class_findings, "judging_code", lambda *_: "newer")

    assert known(tmp_path).recall(TASK) == {}


def test_code_without_a_source_is_not_stored(tmp_path, monkeypatch):
    """Nothing can tell whether such code has changed."""
    monkeypatch.setattr(class_findings, "judging_code", lambda *_: "")
    known(tmp_path).keep(TASK, findings())

    assert known(tmp_path).recall(TASK) == {}


@pytest.mark.parametrize("verdict", [Verdict.ERROR, Verdict.DIVERGED, Verdict.NOT_RUN])
def test_errors_are_not_stored(tmp_path, verdict):
    """An error is tried again."""
    known(tmp_path).keep(TASK, {ENTRY: (("strong", Finding(quantity="", verdict=verdict)),)})

    assert known(tmp_path).recall(TASK) == {}


def test_other_objects_are_not_stored(tmp_path):
    """A plugin may put anything into the details, and name a claim that its scheme does not make."""
    foreign = Claim(measure="strong", value=3.0, source="another scheme")
    for more in ({"details": {"thing": object()}}, {"claim": foreign}):
        found = Finding(quantity="x", verdict=Verdict.VERIFIED, **more)
        known(tmp_path).keep(TASK, {ENTRY: (("strong", found),)})

        assert known(tmp_path).recall(TASK) == {}


@pytest.mark.parametrize(
    "content", [b"", b"no file of this kind", b"\x92\x63\x80"], ids=["empty", "other", "version"]
)
def test_damaged_files_are_replaced(tmp_path, content):
    """A file that cannot be read counts as absent."""
    file = tmp_path / "evidence" / class_findings.FILE
    file.parent.mkdir()
    file.write_bytes(content)

    assert known(tmp_path).recall(TASK) == {}
    known(tmp_path).keep(TASK, findings())
    assert known(tmp_path).recall(TASK)


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    """One line says which file, and what to do."""
    (tmp_path / "evidence").write_text("no folder")
    with pytest.raises(UsageError, match=r"cannot write .*classes\.msgpack: File exists; choose another --out"):
        known(tmp_path).keep(TASK, findings())


def run(folder, monkeypatch):
    """Run a study into a folder, and return its rows of classes and the number of tests that were made."""
    TESTED.clear()
    monkeypatch.setattr("sdaeverify.study.run.class_tests", lambda: (Counted(),))
    study = Study(plan([Moved()], [problem_spec(gbm)], [Strong()]), SETTINGS, Store(folder), orders=True)
    assert list(study.run())
    return [repr(each.findings).replace("<Kind.PLAIN: ''>", "''") for each in study.class_results], TESTED.total()


def test_a_second_run_makes_no_test_until_the_scheme_behaves_otherwise(tmp_path, monkeypatch):
    """The behaviour of a scheme on the problems of a run counts, beside its code."""
    first, tested = run(tmp_path, monkeypatch)
    assert (len(first), tested) == (1, 1)
    assert run(tmp_path, monkeypatch) == (first, 0)
    monkeypatch.setattr(Moved, "drift", 0.01)
    assert run(tmp_path, monkeypatch) == (first, 1)
    assert run(tmp_path, monkeypatch) == (first, 0)
