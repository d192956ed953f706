"""Shipped schemes that the matrix combines with problems of several components; all schemes would take minutes.

Schemes of other authors are combined with all of these problems, because such a list restricts only shipped schemes.
"""

# (A), (B) and (B') of Lindner et al. (2018), and the half-explicit scheme without truncation, which would stop all
# motion.
PROJECTED = (
    "implicit-euler-ggl",
    "explicit-projection-euler",
    "semi-implicit-projection-euler",
    "half-explicit-euler[truncation=none]",
)
# Variants of these schemes for an additional problem with a mass matrix and two constraints.
VARIANTS = ("explicit-projection-euler[skip=3]", "semi-implicit-projection-euler[noise_projector=new]")
# The schemes for overdamped dynamics with eps > 0, and in the limit.
PENALISED = ("penalised-euler", "uniform-expansion", "uniformly-accurate")
LIMIT = (
    "constrained-euler",
    "constrained-euler[direction=new]",
    "uniformly-accurate",
    "uniformly-accurate[xi=three-point]",
    "uniformly-accurate[theta=1]",
)
# The scheme for delay equations that claims a weak order.
DELAYED = ("stochastic-theta",)
BRIEF = ("drift", "strong", "weak")
