"""What schemes for additive noise refuse."""

from sdaeverify import SDE


def not_additive(problem: SDE) -> str:
    """Return why a problem is none with additive noise, or an empty string."""
    return "" if "additive-noise" in problem.traits else "the noise is not declared additive"
