"""Counts of the reference run, which pages quote as ``{{ name }}``."""

from collections import Counter
from pathlib import Path

from sdaeverify.registry.load import load_registry
from sdaeverify.report.folders import read_verdicts
from sdaeverify.testing import checks

KINDS = ("verified", "refuted", "inconclusive", "error", "diverged", "out_of_scope")


def counts(folder: Path) -> dict[str, str]:
    """Return the number of findings of each verdict, and of what is registered."""
    verdicts = Counter(row["verdict"] for row in read_verdicts(folder).verdicts)
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
