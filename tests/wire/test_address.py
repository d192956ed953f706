"""Programs that listen on a local socket: the same answers and the same faults as by pipes."""

import os
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest

from facade import gbm
from sdaeverify import SchemeError, UsageError
from sdaeverify_wire.calling import Calling
from sdaeverify_wire.check import checked
from sdaeverify_wire.scheme import scheme_of, session_of
from wire import faulty, listening
from wire.compiling import built_c, with_python
from wire.test_faults import PATIENCE, SHORT, made, waiting_late
from wire.test_same_bits import rows, run

SILENT = "has not answered for 0.8 s"
# The line of each fault, where the program is not a child of this process.
FAULTS = {
    "silent": SILENT,
    "ends": "closed the connection",
    "dies": "closed the connection",
    "big-endian": "its numbers are big-endian",
    "line without end": "bytes without end of line",
    "half a number": "closed the connection with 4 of 8 bytes missing",
    "a row too many": "sent 'done x=2x3', expected 'x=1x3' first",
    "ends in an array": "closed the connection with 14 of 24 bytes missing",
    "dies in an array": "closed the connection with 14 of 24 bytes missing",
    "stops in an array": SILENT,
    "more than its answer": "sent b'more' after its answer",
    "asks and ends": "closed the connection",
    "silent in a step": SILENT,
    "dies in a step": "closed the connection",
    "floods": "after its answer",
}


def free_port():
    """Return a port that nothing listens on."""
    with socket.create_server(("localhost", 0)) as one:
        return one.getsockname()[1]


@pytest.fixture
def served(tmp_path):
    """Return a function that starts a server of a program, and returns its address."""
    servers = []

    def serve(command, *, tcp=False):
        address = f"tcp:localhost:{free_port()}" if tcp else f"unix:{tmp_path}/solver-{len(servers)}"
        server = subprocess.Popen(
            [sys.executable, "-I", "-S", listening.__file__, address, *command],
            stdout=subprocess.PIPE,
            process_group=0,
        )
        servers.append(server)
        assert server.stdout.readline() == b"ready\n"
        return address

    yield serve
    for server in servers:
        # The programs of its connections are in its group; some of them sleep on purpose.
        os.killpg(server.pid, signal.SIGKILL)
        server.wait()
        server.stdout.close()


def with_fault(fault=""):
    """Return the command of a program with a fault."""
    return [sys.executable, "-I", "-S", faulty.__file__, *([fault] if fault else [])]


@pytest.mark.parametrize("tcp", [False, True], ids=["unix", "tcp"])
def test_client_answers_as_the_transcript_over_a_socket(served, tmp_path, tcp):
    """The transcript, the end of input and the steps are those of pipes."""
    address = served(with_python(tmp_path), tcp=tcp)

    assert "steps: equal with 1, 3, 5000 paths" in list(checked(Calling.of(address, PATIENCE), golden=True))


@pytest.mark.sweep
@pytest.mark.parametrize("fault", waiting_late(FAULTS, {"silent", "silent in a step"}))
def test_fault_over_a_socket_is_one_line(served, fault):
    """A server that breaks off, stops or answers something else costs one line, within its time."""
    address = served(with_fault(fault))
    patience, begun = SHORT if SILENT in FAULTS[fault] else PATIENCE, time.monotonic()

    with pytest.raises(SchemeError) as error:
        made(scheme_of(address, patience))

    assert FAULTS[fault] in str(error.value)
    assert str(error.value).startswith(address)
    assert "\n" not in str(error.value)
    assert time.monotonic() - begun < PATIENCE


def test_request_that_is_not_read_ends_with_its_time(served):
    """A request that fills the socket waits no longer than the program's time."""
    scheme = scheme_of(served(with_fault("stdin is never read")), SHORT)

    with pytest.raises(SchemeError, match=r"has not read its request for 0\.8 s"):
        made(scheme, paths=10**6)


def test_server_that_does_not_accept_is_one_line(tmp_path):
    """A server that accepts no connection does not answer the hello."""
    with listening.listening(f"unix:{tmp_path}/busy") as listener:
        assert listener is not None
        with pytest.raises(SchemeError, match=r"busy has not answered for 0\.8 s"):
            scheme_of(f"unix:{tmp_path}/busy", SHORT)


def test_connection_that_was_closed_between_steps_is_made_again(served):
    """A server that was started again between two steps fails no step, and one that is gone fails it in one line."""
    address = served(with_fault())
    scheme = scheme_of(address, PATIENCE)
    made(scheme)
    session = session_of(scheme.calling)
    session._program._socket.shutdown(socket.SHUT_WR)
    time.sleep(0.3)

    np.testing.assert_array_equal(made(scheme), gbm().initial(3))
    session.drop()


@pytest.mark.parametrize(
    "address", ["unix:", "tcp:5000", "tcp:example.org:80", "tcp:localhost:port", ["unix:/tmp/s", "more"]]
)
def test_address_of_another_kind_is_one_line(address):
    """Only addresses of this machine are accepted, and nothing follows them."""
    with pytest.raises(UsageError, match=r"expected unix:PATH or tcp:localhost:PORT"):
        scheme_of(address)


def test_address_without_server_is_one_line(tmp_path):
    """An address on which nothing listens is named, with the reason of the system."""
    with pytest.raises(SchemeError, match=r"nobody cannot be reached: No such file or directory"):
        scheme_of(f"unix:{tmp_path}/nobody")
    with pytest.raises(SchemeError, match=r"cannot be reached: Connection refused"):
        scheme_of(f"tcp:localhost:{free_port()}")


@pytest.mark.long
def test_run_over_a_socket_has_the_rows_of_pipes(served, tmp_path):
    """Two workers, each with a connection of its own, come to the same numbers as with a process each."""
    command = built_c(tmp_path, "wired_milstein")
    given = ("-p", "gbm", "--paths", "512", "-j", "2", "--progress", "none")
    for folder, program in {"socket": served(command), "pipes": command[0]}.items():
        done = run(tmp_path, None, "matrix", "--wire", program, *given, "--out", folder)
        assert done.returncode == 0, done.stderr

    assert rows(tmp_path / "socket" / "levels.csv") == rows(tmp_path / "pipes" / "levels.csv")


def test_evidence_of_an_address_is_never_reused(served):
    """What listens on an address may be another program tomorrow: its build is unknown."""
    assert scheme_of(served(with_fault())).build is None
