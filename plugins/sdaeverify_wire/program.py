"""A program that speaks the wire protocol: process, pipes and time limits."""

import os
import select
import shlex
import shutil
import subprocess
import time
import weakref
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from sdaeverify import Array, SchemeError, UsageError

from .messages import LONGEST_LINE, NUMBER, Line, Shape, read_line

# Number of bytes per read, and number of last bytes of stderr that are stored.
CHUNK, KEPT = 2**16, 2**12
# Seconds for a program to exit by itself.
ENDING = 1.0
# Linux: kills the program when its parent process ends for any reason.
WITH_PARENT = ("setpriv", "--pdeathsig", "KILL")


class Program:
    """A running program with its output on stderr.

    Neither a read nor a write blocks for longer than `patience`.

    Parameters
    ----------
    command : sequence of str
        The program and its arguments.
    patience : float
        Seconds without any byte after which the program counts as hung.
    """

    def __init__(self, command: Sequence[str], patience: float) -> None:
        self.command, self.patience = tuple(command), patience
        self._rest, self._errors = b"", b""
        try:
            _note_files(self.command)
            self._process = _started(self.command)
        except OSError as error:
            raise SchemeError(f"{self.name} cannot be started: {error.strerror or error}") from error
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        self._to, self._from = self._process.stdin.fileno(), self._process.stdout.fileno()
        self._stderr = self._process.stderr.fileno()
        for pipe in (self._to, self._from, self._stderr):
            os.set_blocking(pipe, False)
        self._reading, self._writing = select.poll(), select.poll()
        for polled in (self._reading, self._writing):
            polled.register(self._from, select.POLLIN)
            polled.register(self._stderr, select.POLLIN)
        self._writing.register(self._to, select.POLLOUT)
        self._finalizer = weakref.finalize(self, _end, self._process)

    @property
    def name(self) -> str:
        """Command for messages, without the path of the program."""
        return shlex.join([Path(self.command[0]).name, *self.command[1:]])

    @property
    def runs(self) -> bool:
        """Whether the process is still running."""
        return self._process.poll() is None

    def close(self) -> None:
        """Kill the program."""
        self._finalizer()

    def finish(self) -> int | None:
        """Close its stdin and return its exit code, or None if it does not exit."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        with suppress(subprocess.TimeoutExpired):
            return self._process.wait(ENDING)
        return None

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
        while True:
            try:
                found = os.read(self._from, CHUNK)
            except BlockingIOError:
                self._wait(self._reading, self._from)
                continue
            if not found:
                raise self._ended()
            self._rest += found
            return

    def _take(self) -> None:
        with suppress(BlockingIOError):
            found = os.read(self._from, CHUNK)
            if not found:
                raise self._ended()
            self._rest += found

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

    def _ended(self, how: str = "") -> SchemeError:
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(ENDING)
        code = self._process.returncode
        if code is None:
            return self.failure(f"closed its stdout{how}")
        return self.failure(f"ended with {f'exit code {code}' if code >= 0 else f'signal {-code}'}{how}")


def split_command(command: "str | Path | Sequence[str]") -> tuple[str, ...]:
    """Return the absolute path of a program, and its arguments.

    Parameters
    ----------
    command : str, Path or sequence of str
        Command; a text is split as by a shell, a path is a program without arguments.

    Raises
    ------
    UsageError
        If `command` is malformed, or there is no such program.
    """
    try:
        words = _words(command)
        if not words:
            raise ValueError("it is empty")
        found = shutil.which(words[0])
    except (TypeError, ValueError) as error:
        raise UsageError(f"cannot read {command!r:.200} as a program with its arguments: {error}") from None
    if found is None:
        raise UsageError(f"no program {words[0]!r:.200} that can be run: expected a path, or a name in PATH")
    return (os.path.abspath(found), *words[1:])


def _words(command: "str | Path | Sequence[str]") -> list[str]:
    if isinstance(command, str):
        return shlex.split(command)
    return [os.fspath(word) for word in ([command] if isinstance(command, Path) else command)]


def _note_files(command: tuple[str, ...]) -> None:
    """Open the program and files among its arguments, so that they are recorded as inputs of the evidence."""
    for path in (command[0], *(word for word in command[1:] if os.path.isfile(word))):
        with Path(path).open("rb"):
            pass


def _started(command: tuple[str, ...]) -> "subprocess.Popen[bytes]":
    guard = shutil.which(WITH_PARENT[0])
    with_parent = (guard, *WITH_PARENT[1:], "--") if guard else ()
    pipe = subprocess.PIPE
    return subprocess.Popen([*with_parent, *command], stdin=pipe, stdout=pipe, stderr=pipe, bufsize=0)


def _end(process: "subprocess.Popen[bytes]") -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()
