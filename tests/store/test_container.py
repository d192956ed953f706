"""Files of evidence: many write and read at once, and what a file is not costs neither a traceback nor a command."""

import os
import signal
import sqlite3
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing

import pytest

from facade import Behaviour, StoredLane, all_lanes, containers, read_lanes, write_lanes
from facade import container_TABLE as TABLE
from sdaeverify.measuring import Tally


def lane(seconds=0.5):
    """Return evidence on nothing."""
    return StoredLane({"scheme": "milstein"}, Behaviour("a", "b"), Tally(), seconds, 40, {})


def seconds_in(container):
    """Return how long each lane took."""
    return {name: one if one is None else one.seconds for name, one in all_lanes(container)}


def write(container, **seconds):
    """Write lanes that took so long."""
    write_lanes(container, {name: lambda _, taken=taken: lane(taken) for name, taken in seconds.items()})


@pytest.fixture
def container(tmp_path):
    """Return a file that is not there yet."""
    return tmp_path / "evidence" / "gbm.sqlite"


def test_what_was_written_last_counts(container):
    """A lane is replaced by what is made of it; others stay as they are."""
    write(container, a=1.0, b=2.0)
    write_lanes(container, {"a": lambda before: lane(before.seconds + 2.0)})

    assert seconds_in(container) == {"a": 3.0, "b": 2.0}
    assert {name: one.seconds for name, one in read_lanes(container, "ac").items()} == {"a": 3.0}


def test_many_write_at_once(container):
    """Writers wait for each other, readers read on, and nothing is lost."""
    with ThreadPoolExecutor(8) as pool:
        done = [pool.submit(write, container, **{f"{n:02d}": float(n)}) for n in range(40)]
        read = [pool.submit(seconds_in, container) for _ in range(10)]

    assert all(each.exception() is None for each in done)
    assert all(seconds == float(name) for each in read for name, seconds in each.result().items() if name)
    assert sorted(seconds_in(container).values()) == [float(n) for n in range(40)]


KILLED = """
import os, signal, sqlite3, sys
rows = sqlite3.connect(sys.argv[1], isolation_level=None)
rows.execute("PRAGMA cache_size = 1")
rows.execute("BEGIN IMMEDIATE")
rows.execute("UPDATE lanes SET content = zeroblob(300000)")
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="a process is killed")
def test_a_writer_that_is_killed(container):
    """What a process was writing when it was killed is undone: what was there before is there."""
    write(container, a=1.0)
    killed = subprocess.run([sys.executable, "-c", KILLED, str(container)], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert container.with_name("gbm.sqlite-journal").exists()

    assert seconds_in(container) == {"a": 1.0}
    write(container, b=2.0)
    assert seconds_in(container) == {"a": 1.0, "b": 2.0}
    assert list(container.parent.iterdir()) == [container]


def test_writing_that_fails_leaves_what_is_there(container):
    """Where evidence cannot be made, the old one stays, and nothing of what was to be written with it is there."""
    write(container, a=1.0)

    with pytest.raises(ZeroDivisionError):
        write_lanes(container, {"b": lambda _: lane(), "a": lambda before: lane(before.seconds / 0)})

    assert seconds_in(container) == {"a": 1.0}


FOREIGN = {
    "view": "CREATE VIEW lanes AS SELECT 'a' AS name, zeroblob(900000000) AS content",
    "trigger": f"{TABLE}; CREATE TABLE more (x); "
    "CREATE TRIGGER t AFTER INSERT ON lanes BEGIN INSERT INTO more VALUES (zeroblob(900000000)); END",
    "columns": "CREATE TABLE lanes (name TEXT PRIMARY KEY)",
}


@pytest.mark.parametrize("script", FOREIGN.values(), ids=FOREIGN)
def test_databases_from_elsewhere(container, script):
    """Of a database that is not this program's nothing is read, and it is replaced by what is computed."""
    container.parent.mkdir()
    with closing(sqlite3.connect(container)) as rows:
        rows.executescript(script)

    assert seconds_in(container) == {"": None}
    assert read_lanes(container, "ab") == {"a": None, "b": None}
    write(container, a=1.0)
    assert seconds_in(container) == {"a": 1.0}


def test_content_of_any_kind(container):
    """A lane that is a number, a text or nothing much is damaged."""
    write(container, a=0.5)
    for content in (1, 0.5, "text", b"", b"PK"):
        with closing(sqlite3.connect(container)) as rows, rows:
            rows.execute("UPDATE lanes SET content = ?", (content,))
        assert seconds_in(container) == {"a": None}


def test_what_is_no_database(container):
    """Any other file, a pipe, a folder and nothing at all are read as damaged without being opened for long."""
    container.parent.mkdir()
    container.write_bytes(b"no database")
    pipe, folder, missing = (container.with_name(f"{name}.sqlite") for name in ("pipe", "folder", "missing"))
    folder.mkdir()
    if hasattr(os, "mkfifo"):
        os.mkfifo(pipe)

    assert [seconds_in(path) for path in (container, pipe, folder, missing)] == [{"": None}] * 4
    assert container in containers(container.parent)


@pytest.mark.skipif(sys.platform == "win32", reason="permissions are a matter of POSIX")
def test_others_may_read_what_was_written(container):
    """A file of evidence can be read by whoever can read the tables beside it."""
    write(container, a=0.5)

    assert container.stat().st_mode & 0o777 == 0o644
