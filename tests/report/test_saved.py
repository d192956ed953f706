"""A run as its folder tells, whoever wrote it."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facade import RUN
from sdaeverify import Settings, UsageError
from sdaeverify.report.saved import SavedRun, read_run

NUMBERS = {name: getattr(Settings(), name) for name in Settings.__dataclass_fields__}
SAVED = {
    "settings": NUMBERS,
    "selection": {"schemes": ["milstein"], "problems": ["gbm", "ou"], "measures": ["strong"]},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder."""
    return tmp_path_factory.mktemp("run")


def read(folder, saved):
    """Read what was saved, text or not."""
    (folder / RUN).write_text(saved if isinstance(saved, str) else json.dumps(saved), encoding="utf-8")
    return read_run(folder)


def test_what_a_run_was_about(folder):
    """Settings and selection are read; whatever else is there is nobody's business."""
    run = read(folder, {**SAVED, "versions": {"numpy": "1"}})

    assert run == SavedRun(folder, Settings(), ("milstein",), ("gbm", "ou"), ("strong",))


def test_runs_of_earlier_versions_had_all_paths_on_all_levels(folder):
    """What a run without guards has saved is read as one that had as many levels for them as for the rest."""
    earlier = {name: value for name, value in NUMBERS.items() if name != "first_levels"}

    settings = read(folder, {**SAVED, "settings": earlier}).settings

    assert settings.guards is settings


def test_numbers_keep_their_kind(folder):
    """Whole ones are whole, and a level is none."""
    settings = read(folder, SAVED).settings

    assert {name for name in NUMBERS if type(getattr(settings, name)) is not int} == {"confidence"}


def test_no_run(tmp_path):
    """A folder that holds no run is told in one line."""
    with pytest.raises(UsageError, match=r"holds no run: cannot read .*No such file"):
        read_run(tmp_path)
    with pytest.raises(UsageError, match="holds no run"):
        read_run(tmp_path / "missing")
    (tmp_path / RUN).mkdir()
    with pytest.raises(UsageError, match="holds no run"):
        read_run(tmp_path)


@pytest.mark.parametrize(
    "text",
    ["", "{", "\x00", "[" * 200_000, '{"settings": ' + "9" * 5000 + "}"],
    ids=["", "cut", "0", "deep", "digits"],
)
def test_no_json(folder, text):
    """Text that is not valid JSON, or too deep for any, is told in one line."""
    with pytest.raises(UsageError, match="is not valid JSON") as error:
        read(folder, text)
    assert "\n" not in str(error.value)


def test_no_text(folder):
    """Bytes that are no text are told in one line."""
    (folder / RUN).write_bytes(b"\xff\xfe\x00")

    with pytest.raises(UsageError, match="is not valid JSON"):
        read_run(folder)


BAD = {
    "list": [],
    "nothing": {},
    "no selection": {"settings": NUMBERS},
    "settings missing": {**SAVED, "settings": {}},
    "text": {**SAVED, "settings": {**NUMBERS, "paths": "8192"}},
    "truth value": {**SAVED, "settings": {**NUMBERS, "max_looks": True}},
    "nan": {**SAVED, "settings": {**NUMBERS, "paths": float("nan")}},
    "infinite": {**SAVED, "settings": {**NUMBERS, "paths": float("inf")}},
    "infinite level": {**SAVED, "settings": {**NUMBERS, "confidence": float("inf")}},
    "large level": {**SAVED, "settings": {**NUMBERS, "confidence": 10**400}},
    "many paths": {**SAVED, "settings": {**NUMBERS, "paths": 10**18}},
    "half a path": {**SAVED, "settings": {**NUMBERS, "paths": 80.5}},
    "few paths": {**SAVED, "settings": {**NUMBERS, "paths": 0}},
    "many levels": {**SAVED, "settings": {**NUMBERS, "levels": 10**300}},
    "negative": {**SAVED, "settings": {**NUMBERS, "seed": -1}},
    "no list": {**SAVED, "selection": {**SAVED["selection"], "schemes": "milstein"}},
    "no names": {**SAVED, "selection": {**SAVED["selection"], "problems": [1]}},
    "nested": {**SAVED, "selection": {**SAVED["selection"], "measures": [["strong"]]}},
}


@pytest.mark.parametrize("saved", BAD.values(), ids=BAD)
def test_what_no_run_writes(folder, saved):
    """Wrong types and numbers out of range are refused in one line."""
    with pytest.raises(UsageError, match="does not describe a run in the format of this program") as error:
        read(folder, saved)
    assert "\n" not in str(error.value)


VALUES = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4) | st.lists(st.text(max_size=2))
WHERE = st.sampled_from([(), *((name,) for name in SAVED), *((a, b) for a in SAVED for b in SAVED[a])])


@settings(max_examples=100)
@given(where=WHERE, value=VALUES)
def test_anything(folder, where, value):
    """Whatever stands in place of what belongs there, a run is read or refused in words."""
    whole = {"whole": json.loads(json.dumps(SAVED))}
    inside = whole
    for name in ("whole", *where)[:-1]:
        inside = inside[name]
    inside[("whole", *where)[-1]] = value

    try:
        run = read(folder, json.dumps(whole["whole"]))
    except UsageError:
        return
    assert isinstance(run, SavedRun)
    assert all(isinstance(name, str) for name in (*run.schemes, *run.problems, *run.measures))
