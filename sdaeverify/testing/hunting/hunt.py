"""The hunt: each claim of some schemes is attacked by examples of each form that they solve."""

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
    """Look for problems on which schemes break their claims.

    Problems are drawn at random, and each is looked at by what one step tells. One that refutes a claim, also from
    another start and with larger coefficients, is shrunk and put to `verify`, with and without what one step tells.

    Parameters
    ----------
    schemes : str, Scheme or sequence of them
        As `verify` takes them.
    **options
        By name. ``measures``: whose claims are attacked, all that the schemes claim if left out. ``when``: traits
        that each example has. ``forms``: of the examples, those that a scheme solves itself if left out;
        ``registered`` are the registered problems with other numbers. ``examples``: how many are looked at for each
        scheme, measure and form, 200 without ``minutes``: the time of the search of all together, in place of a
        number; what is found is shrunk and confirmed on top. ``shrinking``: seconds for it, 60 by default, and at
        most as long as may be searched. ``seed``: 1 by default, not that of runs as for the command; the same finds
        the same, where no time ends the search. ``database``: a folder that remembers what was looked at; an
        interrupted hunt goes on, and the next begins with what was found. ``tell``: a function that is given a line
        of text now and then. ``plugins``, ``jobs``, ``executor``: as `verify` has them.

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
