"""Claims of schemes for delay equations that solve the constraint at every mesh point."""

from sdaeverify import Claim

FIRST = ("x up to tau", "y up to tau", "state up to tau")
DELAYED = (
    Claim(measure="intervals", value=0.5, source="Qu, Huang & Liu 2010, Theorems 3.2 and 3.3"),
    Claim(
        measure="intervals",
        value=1.0,
        quantities=FIRST,
        when=frozenset({"delayed-noise"}),
        source="measured; noise that depends on a deterministic history is additive",
    ),
    Claim(
        measure="strong",
        value=1.0,
        quantities=("x",),
        when=frozenset({"additive-noise"}),
        source="measured; additive noise has no term of Milstein's, and a delay brings none",
    ),
    Claim(
        measure="drift",
        value="round-off",
        when=frozenset({"algebraic"}),
        source="Qu, Huang & Liu 2010, (2.10): the constraint is solved at every mesh point",
    ),
)
