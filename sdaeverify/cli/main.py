"""Entry point of the console script."""

import os
import sys
from contextlib import suppress
from typing import NoReturn

from ..workers.room import why_no_room
from .exit_codes import ExitCode


def run() -> NoReturn:
    """Run the command line of this process and exit."""
    sys.exit(_program())


def _find_modules_here() -> None:
    """Append the current folder to `sys.path`, as ``python -m`` prepends it, for the console script."""
    # The current folder may have been removed.
    with suppress(OSError):
        if not sys.flags.safe_path and (here := os.getcwd()) not in sys.path:
            sys.path.append(here)


def _program() -> int:
    _find_modules_here()
    if why := why_no_room(0):
        sys.stderr.write(f"sdaeverify: error: {why}\n")
        return ExitCode.NOT_MEASURED
    try:
        # Imported here, once there is enough memory, and where an interrupt is handled as during a run.
        from .program import conclude  # noqa: PLC0415
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED
    return conclude(sys.argv[1:])
