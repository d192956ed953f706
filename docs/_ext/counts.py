"""Counts of the reference run, and constants of the code, which pages quote as ``{{ name }}``."""

from collections import Counter
from pathlib import Path

from sdaeverify import Settings
from sdaeverify.contracts.claimed import MARGIN
from sdaeverify.measures.strong.findings import TOLERANCE as STRONG_TOLERANCE
from sdaeverify.measures.weak.probe import TOLERANCE
from sdaeverify.registry.load import load_registry
from sdaeverify.report.folders import read_verdicts
from sdaeverify.testing import checks
from sdaeverify.verdicts.path_tests import DEEP_PATHS

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
        **{name: str(value) for name, value in constants().items()},
    }


def constants() -> dict[str, float]:
    """Return what verdicts are held to."""
    return {
        "margin": MARGIN,
        "strong_tolerance": STRONG_TOLERANCE,
        "weak_tolerance": TOLERANCE,
        "deep_paths": DEEP_PATHS,
        "first_levels": Settings().first_levels,
    }
