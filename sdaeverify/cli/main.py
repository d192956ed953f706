"""The program from its start to its end: supervised, so that its exit code is its own."""

import sys
from typing import NoReturn

from ..workers.garbage import lasting
from ..workers.room import why_no_room
from ..workers.supervision import NOT_MEASURED, supervise

INTERRUPTED = 130


def run() -> NoReturn:
    """Run the command line of this process and end it."""
    sys.exit(supervise(_program))


def _program() -> int:
    if why := why_no_room(0):
        sys.stderr.write(f"sdaeverify: error: {why}\n")
        return NOT_MEASURED
    try:
        # Loaded here, after the process has been made that it is for: libraries start threads.
        with lasting():
            from .program import conclude  # noqa: PLC0415
    except KeyboardInterrupt:
        # An interrupt while the libraries are loading ends the program like a later one.
        return INTERRUPTED
    return conclude(sys.argv[1:])
