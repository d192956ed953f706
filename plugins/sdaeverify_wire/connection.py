"""A connection to a program that speaks the wire protocol: messages, and time limits of each read and write."""

import os
import select
import time
from contextlib import suppress

import numpy as np

from sdaeverify import Array, SchemeError

from .messages import LONGEST_LINE, NUMBER, Line, Shape, read_line

# Number of bytes per read, and number of last bytes of stderr that are stored.
CHUNK, KEPT = 2**16, 2**12


class Connection:
    """A connection over file descriptors; a subclass opens and closes it.

    Neither a read nor a write blocks for longer than `patience`.

    Parameters
    ----------
    name : str
        Name of the program for messages.
    descriptors : tuple of int
        Different descriptors: to write to, to read from, and that of the stderr, if there is one.
    patience : float
        Seconds without any byte after which the program counts as hung.
    """

    def __init__(self, name: str, descriptors: tuple[int, ...], patience: float) -> None:
        self.name, self.patience = name, patience
        self._rest, self._errors = b"", b""
        self._to, self._from, *others = descriptors
        self._stderr = others[0] if others else -1
        self._reading, self._writing = select.poll(), select.poll()
        for descriptor in descriptors:
            os.set_blocking(descriptor, False)
        for descriptor in (self._from, *others):
            self._reading.register(descriptor, select.POLLIN)
            self._writing.register(descriptor, select.POLLIN)
        self._writing.register(self._to, select.POLLOUT)

    @property
    def runs(self) -> bool:
        """Whether the program is still running, as far as is known."""
        raise NotImplementedError

    def close(self) -> None:
        """End the connection, and the program if this process started it."""
        raise NotImplementedError

    def finish(self) -> int | None:
        """Tell the program that no further message follows; return its exit code, or None if it does not end."""
        raise NotImplementedError

    def how_it_ended(self) -> str:
        """Return how the program ended, after its output has ended."""
        raise NotImplementedError

    def send(self, message: bytes) -> None:
        """Write a message.

        Raises
        ------
        SchemeError
            If the program has sent unrequested output, does not read, or has ended.
        """
        if self._rest or self._ready():
            self._take()
            raise self.failure(f"sent {self._begun!r} after its answer or before its request was whole")
        left = memoryview(message)
        while left:
            try:
                left = left[os.write(self._to, left) :]
            except BlockingIOError:
                if self._wait(self._writing, self._to) == self._from:
                    self._take()
                    raise self.failure(f"sent {self._begun!r} before it had read its request") from None
            except OSError:
                raise self._ended() from None

    def line(self) -> Line:
        """Read the line of the next message.

        Raises
        ------
        SchemeError
            If there is no valid line.
        """
        text = self.text()
        try:
            return read_line(text)
        except SchemeError as error:
            raise self.failure(str(error)) from None

    def text(self) -> str:
        """Read a line.

        Raises
        ------
        SchemeError
            If the line is too long or not ASCII, or the program has ended.
        """
        while (end := self._rest.find(b"\n")) < 0:
            if len(self._rest) > LONGEST_LINE:
                raise self.failure(f"sent {len(self._rest)} bytes without end of line: {self._rest[:60]!r}")
            self._fill()
        line, self._rest = self._rest[:end], self._rest[end + 1 :]
        if len(line) > LONGEST_LINE or not (line.isascii() and line.decode("ascii").isprintable()):
            raise self.failure(f"sent {line[:60]!r}, expected a line of at most {LONGEST_LINE} printable letters")
        return line.decode("ascii")

    def array(self, shape: Shape) -> Array:
        """Read an array.

        Raises
        ------
        SchemeError
            If the program ends or stalls before the array is complete.
        """
        found = np.empty(shape, NUMBER)
        if found.size:
            self._read_into(memoryview(found.reshape(-1)).cast("B"))
        return found

    def content(self, size: int) -> bytes:
        """Read a number of bytes; raises as `array`."""
        found = bytearray(size)
        self._read_into(memoryview(found))
        return bytes(found)

    def _read_into(self, left: memoryview) -> None:
        size = len(left)
        known = min(size, len(self._rest))
        left[:known], self._rest = self._rest[:known], self._rest[known:]
        left = left[known:]
        while left:
            try:
                count = os.readv(self._from, [left])
            except BlockingIOError:
                self._wait(self._reading, self._from)
                continue
            except OSError:
                count = 0
            if not count:
                raise self._ended(f" with {len(left)} of {size} bytes missing")
            left = left[count:]

    def failure(self, what: str) -> SchemeError:
        """Kill the program, and return the error with the end of its stderr."""
        self._hear()
        said = b" | ".join(line.strip() for line in self._errors.strip().splitlines()[-3:])
        told = f"; its stderr ends: {said[-300:].decode('utf-8', 'replace')}" if said else ""
        self.close()
        return SchemeError(f"{self.name} {what}{told}")

    @property
    def _begun(self) -> bytes:
        return self._rest.partition(b"\n")[0][:60]

    def _ready(self) -> bool:
        return any(fd == self._from for fd, _ in self._reading.poll(0))

    def _fill(self) -> None:
        while not self._take():
            self._wait(self._reading, self._from)

    def _take(self) -> bool:
        """Read the bytes that have arrived; return whether there were any."""
        try:
            found = os.read(self._from, CHUNK)
        except BlockingIOError:
            return False
        except OSError:
            # A socket is reset by a program that ends before it has read all.
            found = b""
        if not found:
            raise self._ended()
        self._rest += found
        return True

    def _wait(self, polled: select.poll, wanted: int) -> int:
        """Wait until a pipe is ready and return it: the wanted one, or that from the program."""
        until = time.monotonic() + self.patience
        while True:
            ready = [fd for fd, _ in polled.poll(max(0.0, 1e3 * (until - time.monotonic())))]
            if self._stderr in ready and not self._hear():
                self._reading.unregister(self._stderr)
                self._writing.unregister(self._stderr)
            for fd in (self._from, wanted):
                if fd in ready:
                    return fd
            if time.monotonic() >= until:
                does = "has not answered" if wanted == self._from else "has not read its request"
                raise self.failure(f"{does} for {self.patience:g} s (patience)")

    def _hear(self) -> bool:
        """Read stderr and store its end; return whether there may be more."""
        with suppress(BlockingIOError, OSError):
            found = os.read(self._stderr, CHUNK)
            self._errors = (self._errors + found)[-KEPT:]
            return bool(found)
        return True

    def _ended(self, missing: str = "") -> SchemeError:
        return self.failure(f"{self.how_it_ended()}{missing}")
