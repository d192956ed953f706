"""The program from its start to its end."""

import os
import sys
from contextlib import suppress
from typing import NoReturn

from ..workers.room import why_no_room
from .exit_codes import ExitCode


def run() -> NoReturn:
    """Run the command line of this process and end it."""
    sys.exit(_program())


def _find_modules_here() -> None:
    """Let the console script find modules of the current folder, as ``python -m`` does; they hide no others."""
    # There may be no such folder any more.
    with suppress(OSError):
        if not sys.flags.safe_path and (here := os.getcwd()) not in sys.path:
            sys.path.append(here)


def _program() -> int:
    _find_modules_here()
    if why := why_no_room(0):
        sys.stderr.write(f"sdaeverify: error: {why}\n")
        return ExitCode.NOT_MEASURED
    try:
        # Libraries are loaded where there is room for them, and where an interrupt ends the program like a later one.
        from .program import conclude  # noqa: PLC0415
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED
    return conclude(sys.argv[1:])
