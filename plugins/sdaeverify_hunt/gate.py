"""The hunt of a gate."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sdaeverify import Scheme, UsageError

from .hunting import hunt

if TYPE_CHECKING:
    from .report import HuntReport

# Folder of stored shares, and file of the first counterexample, in the folder of the gate.
SHARES, COUNTEREXAMPLE = "hunt", "counterexample.py"


def hunt_of_gate(schemes: Sequence[Scheme], *, seconds: float, folder: Path, **asked: Any) -> Mapping[str, Any]:
    """Search counterexamples to the gated claims, and return the result as a gate reports it.

    Parameters
    ----------
    schemes : sequence of Scheme
    seconds : float
        Time of the search.
    folder : Path
        Folder of the gate.
    **asked
        Options of `hunt`: measures, seed, plugins.

    Returns
    -------
    dict
        ``refuted``, a line for each refuted claim; ``notes``; and ``attacks``, the result for each scheme, measure
        and form.
    """
    asked |= {"minutes": seconds / 60.0, "shrinking": seconds, "database": folder / SHARES}
    try:
        report = hunt(schemes, **asked)
    except UsageError as error:
        # Schemes of forms without random examples are gated all the same.
        return {"notes": [f"hunt of {seconds:g} s: {error}"]}
    found = report.write(folder / COUNTEREXAMPLE)
    files = [f"written: {', '.join(map(str, found))}: keep them with the tests of the project"] if found else []
    return {
        "refuted": [attack.outcome for attack in report.found],
        "notes": [f"hunt of {seconds:g} s: {report.summary}", *files],
        "attacks": [*_attacks(report)],
    }


def _attacks(report: "HuntReport") -> list[dict[str, Any]]:
    return [
        {
            "scheme": each.scheme,
            "measure": each.measure,
            "form": each.form,
            "claims": dict(each.claims),
            "refuted": each.claim if each in report.found else "",
        }
        for each in report.attacks
    ]
