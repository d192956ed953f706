"""Evidence as bytes: what was packed is unpacked, and nothing that anybody else wrote does harm."""

import json
import os
import pickle
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from facade import Behaviour, MeasureRecord, StoredLane, lanes, pack_lane, unpack_lane
from sdaeverify.measuring import Tally

ARRAYS = npst.arrays(dtype=np.float64, shape=npst.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3))
# Half of a surrogate pair is no text that any file can hold.
NAMES = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
TALLIES = st.builds(Tally, *(st.dictionaries(NAMES, ARRAYS, max_size=3) for _ in range(3)))
TEXTS = st.dictionaries(NAMES, NAMES, max_size=3)
LANES = st.builds(
    StoredLane,
    st.builds(lambda given: {**given, **INGREDIENTS}, TEXTS),
    st.builds(Behaviour, st.text(), st.text()),
    TALLIES,
    st.floats(0.0, 1e9),
    st.integers(0, 2**60),
    st.dictionaries(NAMES, st.builds(MeasureRecord, TEXTS, TALLIES, TALLIES), max_size=3),
)
FIELDS = StoredLane._fields
HEALTH, MEASURES = FIELDS.index("health"), FIELDS.index("measures")
INGREDIENTS = {"scheme": "milstein", "problem": "gbm", "index": "3"}


def lane():
    """Return some evidence."""
    tally = Tally({"paths": np.arange(4.0)}, {"x": np.array(np.nan)}, {"y": np.array([3.0, 1.0])})
    record = MeasureRecord({"measure": "strong"}, tally, Tally())
    return StoredLane(INGREDIENTS, Behaviour("a", "b"), tally, 0.5, 40, {"strong": record})


def numbers(*tallies):
    """Return what tallies hold, kinds of numbers and shapes too."""
    kinds = (kind for tally in tallies for kind in (tally.sums, tally.maxima, tally.largest))
    return [{name: (value.dtype, value.shape, value.tobytes()) for name, value in kind.items()} for kind in kinds]


@settings(max_examples=40)
@given(written=LANES)
def test_what_is_unpacked_is_what_was_packed(written):
    """Numbers of any shape and value come back bit by bit, names of any letters too."""
    read = unpack_lane(pack_lane(written))

    assert (read.behaviour, read.seconds, read.paths) == (written.behaviour, written.seconds, written.paths)
    assert (read.scheme, read.problem, read.block) == ("milstein", "gbm", 3)
    assert numbers(read.health) == numbers(written.health)
    assert read.measures.keys() == written.measures.keys()
    for name, record in read.measures.items():
        same = written.measures[name]
        assert record.ingredients == same.ingredients
        assert numbers(record.sampled, record.probed) == numbers(same.sampled, same.probed)


def test_evidence_cut_short_is_damaged():
    """What was cut anywhere is not read at all."""
    whole = pack_lane(lane())

    assert all(unpack_lane(whole[:length]) is None for length in range(len(whole)))


def test_a_flipped_bit_is_noticed():
    """What changed on the disk anywhere is not read, or is what it was."""
    whole = pack_lane(lane())
    flipped = (whole[:n] + bytes([whole[n] ^ 16]) + whole[n + 1 :] for n in range(len(whole)))

    read = [unpack_lane(content) for content in flipped]

    assert all(one is None or pack_lane(one) == whole for one in read)


def test_what_fills_the_memory_is_refused(monkeypatch):
    """Little that unpacks to more than evidence may take is not unpacked, nor is so much evidence packed."""
    large = pack_lane(lane()._replace(health=Tally({"zeros": np.zeros(10_000)})))
    monkeypatch.setattr(lanes, "LARGEST", 50_000)

    assert len(large) < 2000
    assert unpack_lane(large) is None
    with pytest.raises(OSError, match=r"evidence of .* bytes on milstein"):
        pack_lane(lane()._replace(health=Tally({"zeros": np.zeros(10_000)})))


class Planted:
    """What runs a command as it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        """Make a folder."""
        return os.mkdir, (str(self.path),)


def test_objects_are_never_unpickled(tmp_path):
    """A pickle, as it is or packed, is not loaded."""
    planted = pickle.dumps(Planted(tmp_path / "executed"))

    assert unpack_lane(planted) is None
    assert unpack_lane(saved(header=np.array([Planted(tmp_path / "executed")]), numbers=np.zeros(1))) is None
    assert not (tmp_path / "executed").exists()


def saved(**arrays):
    """Return arrays as numpy saves them."""
    file = BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


def read_arrays():
    """Return the header of some evidence, and its numbers."""
    with np.load(BytesIO(pack_lane(lane()))) as arrays:
        return json.loads(arrays["header"].tobytes()), arrays["numbers"]


def with_header(text, numbers=None):
    """Return some evidence with another header, or with other numbers."""
    return saved(header=np.frombuffer(text, dtype=np.uint8), numbers=read_arrays()[1] if numbers is None else numbers)


@pytest.mark.parametrize("shape", [[10**15], [10**30], [-1], [-1, -4], ["four"], [4.5, 4.5], [], None, "4"], ids=str)
def test_shapes_that_are_none_are_refused(shape):
    """What claims to be the shape of an array and is none costs neither memory nor a traceback."""
    hostile, _ = read_arrays()
    hostile[1][HEALTH]["sums"]["paths"] = shape

    assert unpack_lane(with_header(json.dumps(hostile).encode())) is None


KINDS = [np.zeros(7, dtype=kind) for kind in ("<U3", "<c16", "<M8[s]", "V8", "f8,f8", "<f4")]


@pytest.mark.parametrize("numbers", [*KINDS, np.zeros(10**4), np.zeros(2)], ids=lambda given: str(given.dtype))
def test_numbers_that_are_none_are_refused(numbers):
    """Evidence with other numbers than its arrays have was not written by this program."""
    header, own = read_arrays()

    assert unpack_lane(with_header(json.dumps(header).encode(), own)) is not None
    assert unpack_lane(with_header(json.dumps(header).encode(), numbers)) is None


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=4,
)
WHERE = st.sampled_from(
    [
        (),
        (0,),
        (1,),
        *((1, place) for place in range(len(FIELDS))),
        (1, HEALTH, "sums"),
        (1, HEALTH, "sums", "paths"),
        (1, MEASURES, "strong"),
        *((1, MEASURES, "strong", place) for place in range(3)),
        (1, MEASURES, "strong", 1, "largest"),
    ]
)


@settings(max_examples=60)
@given(where=WHERE, value=JSON)
def test_headers_from_elsewhere(where, value):
    """Whatever a header holds in place of what belongs there, evidence is read or refused without an error."""
    inside = whole = {"whole": read_arrays()[0]}
    for key in ("whole", *where)[:-1]:
        inside = inside[key]
    inside[("whole", *where)[-1]] = value

    read = unpack_lane(with_header(json.dumps(whole["whole"]).encode()))

    assert read is None or isinstance(read, StoredLane)
    assert where != () or read is None


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"\xff\xfe",
        b"{",
        b"[" * 200_000,
        b"[6]",
        b"[" + b"9" * 5000 + b"]",
        b"[1e999]",
    ],
    ids=["empty", "bytes", "cut", "deep", "bare", "digits", "infinite"],
)
def test_headers_that_are_none(text):
    """A header that is no header is no reason for a traceback."""
    assert unpack_lane(with_header(text)) is None
