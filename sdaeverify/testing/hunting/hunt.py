"""The hunt: search for counterexamples to each claim of some schemes, among problems of each form they solve."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...api import Schemes
from ...contracts.scheme import Scheme
from ...contracts.spelling import counted
from ...errors import UsageError
from ...gate.gate_plan import gated_schemes
from ...gate.gated import Hunted
from ...gate.policy import Policy
from ...registry.load import Registry
from ...report.saved import SavedAttack
from .options import read_options

if TYPE_CHECKING:
    from .report import HuntReport

# What a hunt remembers, and where it writes what it finds.
MEMORY, COUNTEREXAMPLE = "hunt", "counterexample.py"


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


def hunt_of_gate(registry: Registry, policy: Policy, folder: Path) -> Hunted:
    """Return what a hunt for counterexamples to the gated claims came to, or why there was none.

    Parameters
    ----------
    registry : Registry
    policy : Policy
    folder : Path
        Of the gate.
    """
    asked = {"measures": policy.measures, "seed": policy.seed, "plugins": registry.files}
    seconds, schemes = policy.hunt_seconds, gated_schemes(registry, policy)
    try:
        report = hunt(schemes, **asked, minutes=seconds / 60.0, shrinking=seconds, database=folder / MEMORY)
    except UsageError as error:
        # Schemes of forms of which no example is drawn are gated all the same.
        return Hunted(notes=(f"hunt of {policy.hunt}: {error}",))
    found = report.write(folder / COUNTEREXAMPLE)
    files = [f"written: {', '.join(map(str, found))}: keep them with the tests of the project"] if found else []
    tried, refuted = counted(report.looked_at, "example"), counted(len(report.found), "claim")
    told = f"hunt of {policy.hunt}: {tried}, {refuted} refuted"
    return Hunted(tuple(attack.outcome for attack in report.found), (told, *files), _attacks(report))


def _attacks(report: "HuntReport") -> tuple[SavedAttack, ...]:
    named = ((each.scheme, each.measure, each.form, dict(each.claims)) for each in report.attacks)
    refuted = (each.claim if each in report.found else "" for each in report.attacks)
    return tuple(SavedAttack(*names, claim) for names, claim in zip(named, refuted, strict=True))
