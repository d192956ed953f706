"""Counts of the reference run, which pages quote as ``{{ name }}``."""

import csv
from collections import Counter
from pathlib import Path

from sdaeverify.registry.load import load_registry
from sdaeverify.testing import checks

KINDS = ("verified", "refuted", "inconclusive", "error", "diverged", "out_of_scope")


def counts(folder: Path) -> dict[str, str]:
    """Return the number of findings of each verdict, and of what is registered."""
    with (folder / "verdicts.csv").open(newline="") as file:
        verdicts = Counter(row["verdict"] for row in csv.DictReader(file))
    registry = load_registry(environ={})
    return {
        **{kind: str(verdicts[kind]) for kind in KINDS},
        "quantities": str(verdicts.total()),
        "schemes": str(len(registry.schemes)),
        "problems": str(len(registry.problems)),
        "measures": str(len(registry.measures)),
        "scheme_checks": str(len(checks("scheme"))),
        "problem_checks": str(len(checks("problem"))),
    }
