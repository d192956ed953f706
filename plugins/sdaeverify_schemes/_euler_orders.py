"""Claims of schemes that agree with Euler-Maruyama up to terms of order h^2 in the mean and h^(3/2) otherwise."""

from sdaeverify import Claim

from ._senses import by_growth

DRIFT = "no projection; at least the strong order, g being Lipschitz near the solution"
MILSTEIN = frozenset({"vanishing-milstein-term"})
CONVERGES = (
    Claim(measure="strong", value=0.5, source="Kloeden & Platen 1992, Theorem 10.2.2"),
    Claim(
        measure="strong", value=1.0, when=MILSTEIN, source="Kloeden & Platen 1992, section 10.3: Milstein's scheme"
    ),
    Claim(measure="weak", value=1.0, source="Kloeden & Platen 1992, section 14.1"),
)
STRONG_HALF = CONVERGES[:1]
DRIFTS = (
    Claim(measure="drift", value=0.5, source=DRIFT),
    Claim(measure="drift", value=1.0, when=MILSTEIN, source=DRIFT),
)
# For drifts of one-sided, superlinear growth, tamed and truncated schemes have moments, Euler-Maruyama has not.
ORDERS = (*CONVERGES, *DRIFTS)
EXPLICIT_ORDERS = (*by_growth(*CONVERGES), *DRIFTS)
