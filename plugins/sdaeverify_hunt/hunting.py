"""The hunt: search for counterexamples to each claim of some schemes, among problems of each form they solve."""

from typing import TYPE_CHECKING, Any

from sdaeverify import Scheme, UsageError

from .options import Schemes, read_options

if TYPE_CHECKING:
    from .report import HuntReport


def hunt(schemes: Schemes, **options: Any) -> "HuntReport":
    """Search for problems on which claims of schemes fail.

    Problems are drawn at random and examined by one step, or by a few paths. A problem that refutes a claim, also
    from another start and with larger coefficients, is shrunk and run by `verify`, with and without evidence of one
    step.

    Parameters
    ----------
    schemes : str, Scheme or sequence of them
        As in `verify`.
    **options
        Keyword options. ``measures``: measures whose claims are attacked, by default all claimed ones. ``when``:
        required traits of the examples. ``forms``: forms of the examples, by default those that a scheme solves
        directly; ``registered`` means registered problems with other numbers. ``examples``: number of examples for
        each scheme, measure and form, by default 200. ``minutes``: time of the whole search, instead of a number;
        counterexamples are shrunk and confirmed in addition. ``shrinking``: seconds for shrinking, by default 60, at
        most the time of the search. ``seed``: by default 1, unlike the command, which uses that of runs; the same
        seed gives the same result unless time ends the search. ``database``: folder that stores examined shares; an
        interrupted hunt continues, and the next hunt begins with the counterexamples. ``tell``: function called with
        a line of text for progress. ``plugins``, ``jobs``, ``executor``: as in `verify`.

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
