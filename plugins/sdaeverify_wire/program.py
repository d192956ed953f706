"""A program that this process starts: its pipes are the connection."""

import os
import shlex
import shutil
import signal
import subprocess
import weakref
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from sdaeverify import SchemeError

from .connection import Connection

# Seconds for a program to exit by itself.
ENDING = 1.0
# Linux: kills the program when its parent process ends for any reason.
WITH_PARENT = ("setpriv", "--pdeathsig", "KILL")


class Program(Connection):
    """A running program with its output on stderr.

    Parameters
    ----------
    command : sequence of str
        The program and its arguments.
    patience : float
        Seconds without any byte after which the program counts as hung.
    """

    def __init__(self, command: Sequence[str], patience: float) -> None:
        name = shlex.join([Path(command[0]).name, *command[1:]])
        try:
            # The process that starts it would report a missing file on stderr.
            os.stat(command[0])
            self._process = _started(tuple(command))
        except OSError as error:
            raise SchemeError(f"{name} cannot be started: {error.strerror or error}") from error
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        pipes = self._process.stdin, self._process.stdout, self._process.stderr
        super().__init__(name, tuple(pipe.fileno() for pipe in pipes), patience)
        self._finalizer = weakref.finalize(self, _end, self._process)

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

    def how_it_ended(self) -> str:
        """Return the exit code or signal with which the program ended, or that it only closed its stdout."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(ENDING)
        code = self._process.returncode
        if code is None:
            return "closed its stdout"
        return f"ended with {f'exit code {code}' if code >= 0 else f'signal {-code}'}"


def _started(command: tuple[str, ...]) -> "subprocess.Popen[bytes]":
    guard = shutil.which(WITH_PARENT[0])
    with_parent = (guard, *WITH_PARENT[1:], "--") if guard else ()
    pipe = subprocess.PIPE
    # A group of its own: a script in a shell is ended with the programs that it has started.
    return subprocess.Popen(
        [*with_parent, *command], stdin=pipe, stdout=pipe, stderr=pipe, bufsize=0, process_group=0
    )


def _end(process: "subprocess.Popen[bytes]") -> None:
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    for pipe in (process.stdin, process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()
