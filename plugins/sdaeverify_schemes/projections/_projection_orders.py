"""Claims of Euler schemes that project positions and velocities along normals at the new position."""

from sdaeverify import Claim

MEASURED = "measured; Lindner et al. 2018, section 4.2, report order about 1"
ORDERS = (
    Claim(measure="strong", value=0.5, source=MEASURED),
    Claim(measure="strong", value=1.0, when=frozenset({"vanishing-milstein-term"}), source=MEASURED),
    Claim(measure="weak", value=1.0, source="measured"),
)
EXACT = Claim(measure="drift", value="round-off", source="g(r+) = 0 and Dg(r+) v+ = 0 are solved")
