"""What the reference run found, counted: pieces that pages include."""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from markup import table

from sdaeverify.report.folders import read_verdicts

TIERS = {
    "T0": "contract and exactness",
    "T1": "defects of one step",
    "T2": "moments, operators",
    "T3": "paths",
}


def finding_pages(reference: Path) -> dict[str, str]:
    """Return the pieces by name."""
    rows = list(read_verdicts(reference).verdicts)
    return {"pieces/verdict-counts.md": _verdicts(rows), "pieces/tiers.md": _tiers(rows)}


def _verdicts(rows: list[Mapping[str, str]]) -> str:
    """Return the number of findings by measure and verdict."""
    found = Counter((row["measure"], row["verdict"]) for row in rows)
    measures, verdicts = (
        sorted({m for m, _ in found}),
        [v for v, _ in Counter(v for _, v in found.elements()).most_common()],
    )
    lines = ([measure, *(str(found[measure, verdict]) for verdict in verdicts)] for measure in measures)
    total = ["all", *(str(sum(found[measure, verdict] for measure in measures)) for verdict in verdicts)]
    return table(["measure", *verdicts], [*lines, total])


def _tiers(rows: list[Mapping[str, str]]) -> str:
    """Return the number of decided claims by the tier that decided."""
    found = Counter(row["decided_by"] for row in rows if row["claim"] and row["verdict"] in {"verified", "refuted"})
    return table(["tier", "by", "claims"], ([tier, TIERS.get(tier, ""), str(n)] for tier, n in sorted(found.items())))
