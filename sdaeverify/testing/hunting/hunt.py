"""The hunt: each claim of some schemes is attacked by examples of each form that they solve."""

from typing import TYPE_CHECKING, Any

from ...api import Schemes
from ...contracts.scheme import Scheme
from ...errors import UsageError
from .options import read_options

if TYPE_CHECKING:
    from .report import HuntReport


def hunt(schemes: Schemes, **options: Any) -> "HuntReport":
    """Look for problems on which schemes break their claims.

    Problems are drawn at random, and each is looked at by what one step tells. One that refutes a claim, also from
    another start and with larger coefficients, is shrunk and put to `verify`, with and without what one step tells.

    Parameters
    ----------
    schemes : str, Scheme or sequence of them
        As `verify` takes them.
    **options
        ``measures``, ``when`` (traits), ``forms``, ``examples`` (200), ``minutes``, ``seed`` (1), ``shrinking`` (60),
        ``plugins``, ``database`` (a folder), ``jobs`` (1), ``executor`` and ``tell`` (a function of a line), as
        `HuntOptions` explains them.

    Returns
    -------
    HuntReport

    Raises
    ------
    UsageError
        If a name is unknown, a value out of its range, or nothing is claimed.
    MissingLibraryError
        If hypothesis is not installed.
    """
    if schemes is None or (not isinstance(schemes, str | Scheme) and not schemes):
        raise UsageError(f"hunt expects the schemes that are hunted, such as 'milstein', got {schemes!r:.200}")
    asked = read_options(options)
    from .attacks import attack_all  # noqa: PLC0415 - optional: it needs hypothesis

    return attack_all(schemes, asked)
