"""The program from its start to its end."""

import sys
from typing import NoReturn

from ..workers.room import why_no_room
from .exit_codes import ExitCode


def run() -> NoReturn:
    """Run the command line of this process and end it."""
    sys.exit(_program())


def _program() -> int:
    if why := why_no_room(0):
        sys.stderr.write(f"sdaeverify: error: {why}\n")
        return ExitCode.NOT_MEASURED
    try:
        # Libraries are loaded where there is room for them, and where an interrupt ends the program like a later one.
        from .program import conclude  # noqa: PLC0415
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED
    return conclude(sys.argv[1:])
