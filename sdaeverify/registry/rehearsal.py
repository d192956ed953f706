"""What might end the process is done in a copy of it first, where it can do no harm.

Loading a plugin runs code that nobody has seen: it may exit, crash, hang or raise what ends a program. Where
processes cannot be forked nothing is rehearsed.
"""

import ctypes
import faulthandler
import os
import select
import signal
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn

from ..errors import FAULTS, one_line

# A loaded library may take long to begin with; no more than this.
SECONDS = 60.0
CAME_BACK = b"\n"
LONGEST = 2000
PERIOD = 0.5
# The number of an option of prctl: which signal a process gets when its parent dies.
DEATH_SIGNAL = 1


def rehearse(deed: Callable[[], object], seconds: float = SECONDS) -> str:
    """Return in which way a deed would end or stop the process; empty if it comes back or raises an ordinary error.

    Parameters
    ----------
    deed : callable
        What it changes is lost; what it prints is not shown.
    seconds : float
        That it may take.
    """
    if not hasattr(os, "fork"):
        return ""
    told, tell = os.pipe()
    for stream in (sys.stdout, sys.stderr):
        # What waits to be written would be written by the copy, too.
        if stream is not None:
            stream.flush()
    with warnings.catch_warnings():
        # Other threads may hold locks: the copy would wait for them in vain, and be ended.
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        _perform(deed, tell)
    os.close(tell)
    try:
        return _outcome(child, told, seconds)
    finally:
        os.close(told)


def _perform(deed: Callable[[], object], tell: int) -> NoReturn:
    words = ""
    try:
        # All that it starts can be ended with it.
        os.setsid()
        _die_with_parent()
        _close_streams()
        deed()
    except FAULTS:
        # It is an error outside of the rehearsal, too.
        pass
    except BaseException as error:
        words = f"raises {one_line(error)}"
    finally:
        os.write(tell, CAME_BACK + words.encode(errors="replace")[:LONGEST])
        os._exit(0)


def _die_with_parent() -> None:
    # Nobody else ends it where the program is ended meanwhile; code that hangs hears of nothing but a signal.
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)


def _close_streams() -> None:
    # It would write of a crash into a stream of its own.
    faulthandler.disable()
    nothing = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1, 2):
        os.dup2(nothing, number)
    # In a notebook or a test they have no number.
    sys.stdout = sys.stderr = os.fdopen(nothing, "w")


def _outcome(child: int, told: int, seconds: float) -> str:
    until, dead, status = time.monotonic() + seconds, 0, 0
    try:
        # It may be dead while what it has forked holds the pipe open.
        while not dead and not (said := select.select([told], [], [], PERIOD)[0]) and time.monotonic() < until:
            dead, status = os.waitpid(child, os.WNOHANG)
        answer = os.read(told, 2 * LONGEST) if said else b""
    finally:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(child, signal.SIGKILL)
        if not dead:
            with suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
            _, status = os.waitpid(child, 0)
    if answer:
        return answer.removeprefix(CAME_BACK).decode()
    return _end(status) if dead or said else f"does not come back within {seconds:g} s"


def _end(status: int) -> str:
    code = os.waitstatus_to_exitcode(status)
    return (
        f"ends the process with status {code}" if code >= 0 else f"ends the process by {signal.Signals(-code).name}"
    )
