"""A program in a process of its own: its exit code is what it says, not how its process ends.

The code of a plugin can end a process at any moment, with any status, even as the interpreter shuts down: such a
status must not pass for the outcome of a run. Where processes cannot be forked, the program runs unsupervised.
"""

import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress

# Signals of the user or the system that end the program; they are passed on to it.
PASSED_ON = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
# An interrupt that comes again so soon is the same one: a terminal sends it to both processes.
SAME = 1.0
# What a program may take to shut down after it has told its code.
SHUTDOWN = 10.0
NOT_MEASURED = 3


def supervise(program: Callable[[], int]) -> int:
    """Run a program in a process of its own and return its exit code.

    Parameters
    ----------
    program : callable
        Returns its exit code, below 256.

    Returns
    -------
    int
        3, with a line on stderr, if its process ended before it returned, whatever the status.
    """
    if not hasattr(os, "fork"):
        return program()
    told, tell = os.pipe()
    ended, alive = os.pipe()
    signal.pthread_sigmask(signal.SIG_BLOCK, PASSED_ON)
    child = os.fork()
    if child == 0:
        os.close(told)
        os.close(alive)
        _perform(program, tell, ended)
    os.close(tell)
    os.close(ended)
    for number in PASSED_ON:
        signal.signal(number, lambda number, _: _forward_signal(child, number))
    signal.pthread_sigmask(signal.SIG_UNBLOCK, PASSED_ON)
    return _outcome(child, told)


def _perform(program: Callable[[], int], tell: int, ended: int) -> None:
    """Run the program, tell its code and end this process."""
    threading.Thread(target=_end_with_parent, args=(ended,), daemon=True).start()
    last = [-SAME]

    def interrupt(*_: object) -> None:
        now = time.monotonic()
        if now - last[0] >= SAME:
            last[0] = now
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, PASSED_ON)
    code = program()
    os.write(tell, bytes([code]))
    sys.exit(code)


def _end_with_parent(ended: int) -> None:
    # Nothing is ever written: reading ends with the process at the other end.
    os.read(ended, 1)
    os._exit(NOT_MEASURED)


def _forward_signal(child: int, number: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(child, number)


def _outcome(child: int, told: int) -> int:
    """Wait for the code that is told, or for the end of the process that would have told it."""
    status = None
    while status is None and not select.select([told], [], [], 1.0)[0]:
        # What it has forked may hold the pipe open.
        status = _status(child)
    os.set_blocking(told, False)
    try:
        code = os.read(told, 1)
    except BlockingIOError:
        code = b""
    if code:
        _reap(child)
        return code[0]
    return _code_of_status(os.waitpid(child, 0)[1] if status is None else status)


def _status(child: int) -> int | None:
    process, status = os.waitpid(child, os.WNOHANG)
    return status if process else None


def _reap(child: int) -> None:
    """Let a process shut down that has told its code, and end it where it does not."""
    until = time.monotonic() + SHUTDOWN
    while _status(child) is None:
        if time.monotonic() > until:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return
        time.sleep(0.002)


def _code_of_status(status: int) -> int:
    code = os.waitstatus_to_exitcode(status)
    if -code in PASSED_ON:
        # This process ends as the other one did.
        signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    how = f"with status {code}" if code >= 0 else f"by {signal.Signals(-code).name}"
    if sys.stderr is not None:
        sys.stderr.write(
            f"sdaeverify: error: the program was ended {how} before it was done, by a plugin or a library\n"
        )
    return NOT_MEASURED
