"""The refusal of schemes for additive noise."""

from sdaeverify import SDE


def not_additive(problem: SDE) -> str:
    """Return why a problem does not have additive noise, or an empty string."""
    return "" if "additive-noise" in problem.traits else "the noise is not declared additive"
