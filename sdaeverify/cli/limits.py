"""Options that hold the code of plugins to limits."""

from typing import Any

from ..workers.limits import Limits
from ..workers.requested import SHARE, TIMEOUT, read_limits
from .options import combine_options, once

# How the code of plugins is held to limits.
limits = combine_options(
    once(
        "--timeout",
        type=float,
        metavar="SECONDS",
        help=f"What a scheme may take on a block of paths; 0 for no limit.  [default: {TIMEOUT:.0f}]",
    ),
    once(
        "--memory",
        metavar="SIZE",
        help=f"Memory of each worker, such as 2G; 0 for no limit.  [default: {SHARE:.0%} of all, shared]",
    ),
)


def options_of(options: dict[str, Any]) -> tuple[int, Limits | None]:
    """Return `read_limits` of a command's options."""
    return read_limits(options["timeout"], options["memory"], options["jobs"])
