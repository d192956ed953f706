"""Shipped schemes that problems of several components are crossed with in the matrix: all would take minutes.

Schemes of other authors meet each of these problems, because such a list binds only schemes that it could name.
"""

# (A), (B) and (B') of Lindner et al. (2018), and the half-explicit scheme without truncation, which ends all motion.
PROJECTED = (
    "implicit-euler-ggl",
    "explicit-projection-euler",
    "semi-implicit-projection-euler",
    "half-explicit-euler[truncation=none]",
)
# Variants of these for one further problem with a mass matrix and two constraints.
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
