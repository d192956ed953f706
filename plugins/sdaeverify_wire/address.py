"""A program that listens on a local socket: it is started by its user, and this process connects to it."""

import os
import re
import socket
import weakref
from pathlib import Path

from sdaeverify import SchemeError, UsageError

from .connection import Connection
from .program import ENDING

UNIX, TCP = "unix:", "tcp:"
# Neither side identifies itself to the other, therefore only addresses of this machine are accepted.
PORT = re.compile(r"tcp:(?:localhost|127\.0\.0\.1):([0-9]{1,5})")
EXPECTED = "expected unix:PATH or tcp:localhost:PORT"


class Address(Connection):
    """A connection to a program that listens on a local socket.

    Parameters
    ----------
    address : str
        ``unix:PATH`` or ``tcp:localhost:PORT``.
    patience : float
        Seconds without any byte after which the program counts as hung.
    """

    def __init__(self, address: str, patience: float) -> None:
        try:
            self._socket = _connected(address, patience)
        except OSError as error:
            raise SchemeError(f"{address} cannot be reached: {error.strerror or error}") from error
        # Two descriptors, as of two pipes, so that waiting for one direction does not report the other.
        reading = os.dup(self._socket.fileno())
        self._finalizer = weakref.finalize(self, _close, self._socket, reading)
        super().__init__(address, (self._socket.fileno(), reading), patience)

    @property
    def runs(self) -> bool:
        """Whether neither side has closed the connection."""
        return self._finalizer.alive and not _is_closed(self._socket)

    def close(self) -> None:
        """Close the connection."""
        self._finalizer()

    def finish(self) -> int | None:
        """Close one direction and return 0 as soon as the program closes the other one, or None if it does not."""
        self._socket.shutdown(socket.SHUT_WR)
        self._socket.settimeout(ENDING)
        try:
            return None if self._socket.recv(1) else 0
        except OSError:
            return None

    def how_it_ended(self) -> str:
        """Return that the program closed the connection."""
        return "closed the connection"


def absolute_address(words: list[str], folder: Path) -> tuple[str, ...]:
    """Return an address as the only word of a command, with the absolute path of a Unix socket.

    Parameters
    ----------
    words : list of str
        The address, whose path may be relative.
    folder : Path
        Folder of relative paths.

    Raises
    ------
    UsageError
        If it is no address of this machine.
    """
    address = words[0]
    if len(words) > 1 or address == UNIX or (address.startswith(TCP) and PORT.fullmatch(address) is None):
        raise UsageError(f"cannot connect to {' '.join(words)!r:.200}: {EXPECTED}")
    return (UNIX + os.path.abspath(folder / address.removeprefix(UNIX)) if address.startswith(UNIX) else address,)


def _connected(address: str, patience: float) -> socket.socket:
    if found := PORT.fullmatch(address):
        reached = socket.create_connection(("localhost", int(found[1])), patience)
        # A step is a short conversation, in which each side waits for the other.
        reached.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    else:
        reached = socket.socket(socket.AF_UNIX)
        try:
            reached.settimeout(patience)
            reached.connect(address.removeprefix(UNIX))
        except OSError:
            reached.close()
            raise
    reached.setblocking(False)
    return reached


def _is_closed(reached: socket.socket) -> bool:
    try:
        return not reached.recv(1, socket.MSG_PEEK)
    except BlockingIOError:
        return False
    except OSError:
        return True


def _close(reached: socket.socket, reading: int) -> None:
    reached.close()
    os.close(reading)
