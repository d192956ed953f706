"""A counterexample is confirmed by a run of the whole program on its plugin file, and by paths alone."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ...api import verify
from ...contracts.finding import Verdict
from ...contracts.measure import Measure
from ...contracts.scheme import Scheme
from ...contracts.tally import Tally
from ..strategies.example import NAME, Example

# The chance of a false alarm that all confirmations of a hunt share.
CHANCE = 0.01


def confirm(scheme: Scheme, example: Example, measure: Measure, found: int) -> tuple[bool, str]:
    """Return whether a run refutes a claim on an example, and the verdict of its paths where one step tells nothing.

    A claim that paths alone verify is not refuted, whatever one step says.

    Parameters
    ----------
    scheme : Scheme
    example : Example
    measure : Measure
    found : int
        How many counterexamples are confirmed: 1 - 1/100/found is the confidence.
    """
    confidence = 1.0 - CHANCE / max(found, 1)
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{NAME}.py"
        file.write_text(example.source, encoding="utf-8")

        def verdicts(of: Measure) -> set[Verdict]:
            rows: Any = verify([scheme], NAME, [of], plugins=[file], confidence=confidence).verdicts
            return {Verdict(verdict) for verdict in rows[rows.scheme == scheme.label].verdict}

        whole, paths = verdicts(measure), verdicts(_unprobed(measure))
    against = Verdict.REFUTED in paths
    alone = "refuted" if against else "verified" if paths == {Verdict.VERIFIED} else "undecided"
    return Verdict.REFUTED in whole and (against or paths != {Verdict.VERIFIED}), alone


def _unprobed(measure: Measure) -> Measure:
    """Return the measure without what one step tells."""

    def probe(*_: object) -> Tally:
        return Tally()

    kind: type[Measure] = type(f"Unprobed{type(measure).__name__}", (type(measure),), {"probe": probe})
    return kind()
