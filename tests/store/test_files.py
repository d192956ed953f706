"""Files of evidence: what was written is read, and nothing that anybody else wrote does harm."""

import io
import json
import os
import pickle
import sys
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from sdaeverify.contracts.tally import Tally
from sdaeverify.simulate.behaviour import Behaviour
from sdaeverify.store.files import (
    HEADER,
    MeasureRecord,
    StoredLane,
    read_ingredients,
    read_lane,
    write_lane,
)

KINDS = st.sampled_from([np.float64, np.float32, np.int64, np.uint8, np.bool_])
ARRAYS = npst.arrays(dtype=KINDS, shape=npst.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3))
# Half of a surrogate pair is no text that any file can hold.
NAMES = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
TALLIES = st.builds(Tally, *(st.dictionaries(NAMES, ARRAYS, max_size=3) for _ in range(3)))
TEXTS = st.dictionaries(NAMES, NAMES, max_size=3)
LANES = st.builds(
    StoredLane,
    TEXTS,
    st.builds(Behaviour, st.text(), st.text()),
    TALLIES,
    st.floats(0.0, 1e9),
    st.integers(0, 2**60),
    st.dictionaries(NAMES, st.builds(MeasureRecord, TEXTS, TALLIES, TALLIES), max_size=3),
)
INGREDIENTS = {"scheme": "milstein", "problem": "gbm", "index": "3"}


def lane():
    """Return some evidence."""
    tally = Tally({"paths": np.arange(4.0)}, {"x": np.array(np.nan)}, {"y": np.array([3.0, 1.0])})
    record = MeasureRecord({"measure": "strong"}, tally, Tally())
    return StoredLane(INGREDIENTS, Behaviour("a", "b"), tally, 0.5, 40, {"strong": record})


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Return the place of a file."""
    return tmp_path_factory.mktemp("files") / "lane.npz"


def same_tally(a, b):
    """Tell whether two tallies are the same, kinds of numbers and shapes too."""
    return all(
        one.keys() == other.keys()
        and all(
            value.dtype == other[name].dtype
            and value.shape == other[name].shape
            and value.tobytes() == other[name].tobytes()
            for name, value in one.items()
        )
        for one, other in ((a.sums, b.sums), (a.maxima, b.maxima), (a.largest, b.largest))
    )


@settings(max_examples=40)
@given(written=LANES)
def test_what_is_read_is_what_was_written(place, written):
    """Numbers of any kind, shape and value come back bit by bit, names of any letters too."""
    write_lane(written, place)
    read = read_lane(place)

    assert (read.ingredients, read.seconds, read.paths) == (written.ingredients, written.seconds, written.paths)
    assert same_tally(read.health, written.health)
    assert read.measures.keys() == written.measures.keys()
    for name, record in read.measures.items():
        assert record.ingredients == written.measures[name].ingredients
        assert same_tally(record.sampled, written.measures[name].sampled)
        assert same_tally(record.probed, written.measures[name].probed)
    assert read_ingredients(place) == written.ingredients


def test_what_a_file_is_about(place):
    """Scheme, problem and block are read from the ingredients."""
    write_lane(lane(), place)

    read = read_lane(place)

    assert (read.scheme, read.problem, read.block) == ("milstein", "gbm", 3)


def test_a_file_cut_short_is_damaged(place, tmp_path):
    """A file that was cut anywhere is not read at all."""
    write_lane(lane(), place)
    whole, cut = place.read_bytes(), tmp_path / "cut.npz"

    for length in (*range(0, len(whole), 5), len(whole) - 1):
        cut.write_bytes(whole[:length])
        assert read_lane(cut) is None
        assert read_ingredients(cut) is None


def test_a_flipped_bit_in_the_numbers_is_noticed(place, tmp_path):
    """Numbers that changed on the disk are not read."""
    write_lane(lane(), place)
    whole, number = place.read_bytes(), np.arange(4.0).tobytes()
    where = whole.index(number) + len(number) - 1
    (tmp_path / "flipped.npz").write_bytes(whole[:where] + bytes([whole[where] ^ 1]) + whole[where + 1 :])

    assert read_lane(tmp_path / "flipped.npz") is None


def test_no_file(tmp_path):
    """There is nothing to read in what does not exist, in a folder, and in a pipe that nobody writes."""
    (tmp_path / "folder.npz").mkdir()

    assert read_lane(tmp_path / "missing.npz") is None
    assert read_lane(tmp_path / "folder.npz") is None
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.npz")
        assert read_lane(tmp_path / "pipe.npz") is None


def test_damaged_files_are_left_out(tmp_path):
    """Of a folder, what can be read is."""
    write_lane(lane(), tmp_path / "a" / "good.npz")
    (tmp_path / "bad.npz").write_bytes(b"PK")

    assert sum(read_lane(path) is not None for path in tmp_path.rglob("*.npz")) == 1


def test_a_file_is_written_as_a_whole_or_not_at_all(tmp_path, monkeypatch):
    """Where writing fails the old file stays, and nothing else is left."""
    place = tmp_path / "lane.npz"
    write_lane(lane(), place)
    before = place.read_bytes()
    monkeypatch.setattr(np, "savez", lambda *_, **__: (_ for _ in ()).throw(OSError("disk full")))

    with pytest.raises(OSError, match="disk full"):
        write_lane(lane()._replace(paths=80), place)

    assert place.read_bytes() == before
    assert list(tmp_path.iterdir()) == [place]


def test_a_packed_file_is_refused(place, tmp_path):
    """A small file that would fill the memory is not unpacked."""
    write_lane(lane(), place)
    with (
        zipfile.ZipFile(place) as old,
        zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as new,
    ):
        for name in old.namelist():
            new.writestr(name, old.read(name))

    assert read_lane(tmp_path / "bomb.npz") is None


class Planted:
    """What runs a command as it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        """Make a folder."""
        return os.mkdir, (str(self.path),)


@pytest.mark.parametrize("planted", ["header", "0"])
def test_objects_are_never_unpickled(place, tmp_path, planted):
    """A file with an object in place of numbers is refused, and nothing in it is executed."""
    marker, hostile = tmp_path / "executed", io.BytesIO()
    np.save(hostile, np.array([Planted(marker)], dtype=object), allow_pickle=True)
    copied(place, tmp_path / "object.npz", f"{planted}.npy", hostile.getvalue())

    assert read_lane(tmp_path / "object.npz") is None
    assert read_ingredients(tmp_path / "object.npz") is None or planted != "header"
    assert not marker.exists()


def test_a_file_that_is_a_pickle_is_refused(tmp_path):
    """A pickle under the name of a file of evidence is not loaded."""
    (tmp_path / "pickle.npz").write_bytes(pickle.dumps(Planted(tmp_path / "executed")))

    assert read_lane(tmp_path / "pickle.npz") is None
    assert not (tmp_path / "executed").exists()


def copied(place, target, changed, content):
    """Copy a file of evidence with other content of one member, stored as it is."""
    write_lane(lane(), place)
    with zipfile.ZipFile(place) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            new.writestr(name, content if name == changed else old.read(name))


def numpy_header(shape, kind="<f8"):
    """Return the beginning of an array that claims to have this shape."""
    text = f"{{'descr': {kind!r}, 'fortran_order': False, 'shape': {shape}}}\n".encode()
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text


@pytest.mark.parametrize(
    "content",
    [
        numpy_header("(10**15,)"),
        numpy_header("(1000000000000000,)"),
        numpy_header("(1000000000000000000000000000000,)"),
        numpy_header("(-1,)"),
        numpy_header("(2,)", "<U3") + b"\0" * 24,
        numpy_header("(2,)", "<c16") + b"\0" * 32,
        numpy_header("(2,)", "<M8[s]") + b"\0" * 16,
        numpy_header("-" * 9000 + "1"),
        numpy_header("[" * 9000),
        numpy_header("__import__('os').mkdir('executed')"),
        b"",
        b"no array",
    ],
    ids=[
        "expression",
        "huge",
        "enormous",
        "negative",
        "text",
        "complex",
        "dates",
        "signs",
        "nested",
        "code",
        "empty",
        "other",
    ],
)
def test_arrays_that_are_none_are_refused(place, tmp_path, monkeypatch, content):
    """What claims to be an array and is none, or none of numbers, costs neither memory nor a traceback."""
    monkeypatch.chdir(tmp_path)
    copied(place, tmp_path / "odd.npz", "0.npy", content)

    assert read_lane(tmp_path / "odd.npz") is None
    assert not (tmp_path / "executed").exists()


def header_of(place):
    """Return the header of some evidence as a dict."""
    write_lane(lane(), place)
    with np.load(place) as file:
        return json.loads(file[HEADER].tobytes())


def with_header(place, target, text):
    """Copy a file of evidence with another header."""
    content = io.BytesIO()
    np.save(content, np.frombuffer(text, dtype=np.uint8))
    copied(place, target, f"{HEADER}.npy", content.getvalue())


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=4,
)
WHERE = st.sampled_from(
    [
        (),
        ("format",),
        ("ingredients",),
        ("seconds",),
        ("paths",),
        ("health",),
        ("health", "sums"),
        ("health", "sums", "paths"),
        ("measures",),
        ("measures", "strong"),
        ("measures", "strong", "ingredients"),
        ("measures", "strong", "sampled"),
        ("measures", "strong", "sampled", "largest"),
    ]
)


@settings(max_examples=60)
@given(where=WHERE, value=JSON)
def test_headers_from_elsewhere(place, where, value):
    """Whatever a header holds in place of what belongs there, the file is read or refused without an error."""
    header, target = header_of(place), place.with_name("foreign.npz")
    inside = {"whole": header}
    for key in ("whole", *where)[:-1]:
        inside = inside[key]
    inside[("whole", *where)[-1]] = value
    with_header(place, target, json.dumps(header if where else value).encode())

    read = read_lane(target)

    assert read is None or isinstance(read, StoredLane)
    assert where != () or read is None


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"\xff\xfe",
        b"{",
        b"[" * 200_000,
        b'{"format": 1}',
        b'{"format": 2}',
        b'{"format": ' + b"9" * 5000 + b"}",
        b'{"format": 1e999}',
    ],
    ids=["empty", "bytes", "cut", "deep", "bare", "format", "digits", "infinite"],
)
def test_headers_that_are_none(place, tmp_path, text):
    """A header that is no header is no reason for a traceback."""
    with_header(place, tmp_path / "odd.npz", text)

    assert read_lane(tmp_path / "odd.npz") is None
    assert read_ingredients(tmp_path / "odd.npz") is None


def test_a_protected_archive_is_refused(place, tmp_path):
    """A member that asks for a password is not read."""
    write_lane(lane(), place)
    content = bytearray(place.read_bytes())
    # The flag of the first member, in its own header and in the list of members.
    content[6] |= 1
    content[content.index(b"PK\x01\x02") + 8] |= 1
    (tmp_path / "locked.npz").write_bytes(content)

    assert read_lane(tmp_path / "locked.npz") is None


@pytest.mark.skipif(sys.platform == "win32", reason="permissions are a matter of POSIX")
def test_others_may_read_what_was_written(place):
    """A file of evidence can be read by whoever can read the tables beside it."""
    write_lane(lane(), place)

    assert place.stat().st_mode & 0o777 == 0o644
