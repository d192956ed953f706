"""Senses of convergence of explicit schemes, whose mean-square theorems need coefficients of linear growth."""

from dataclasses import replace

from sdaeverify import Claim

LINEAR_GROWTH = frozenset({"linear-growth"})
ALONG_PATHS = "Gyongy 1998; Jentzen, Kloeden & Neuenkirch 2009: local conditions"
REJECTED = "Milstein & Tretyakov 2005: means without exploding paths"


def in_probability(*claims: Claim) -> tuple[Claim, ...]:
    """Return the claims in probability, for coefficients of any growth."""
    sources = {claim.measure: REJECTED if claim.measure == "weak" else ALONG_PATHS for claim in claims}
    return tuple(replace(claim, sense="in probability", source=sources[claim.measure]) for claim in claims)


def by_growth(*claims: Claim) -> tuple[Claim, ...]:
    """Return the claims in mean square for coefficients of linear growth, and in probability for all others."""
    bounded = (replace(claim, when=claim.when | LINEAR_GROWTH) for claim in claims)
    return (*bounded, *in_probability(*claims))
