"""What constrained mechanics of several components is crossed with in the matrix: all else would take minutes."""

# (A), (B) and (B') of Lindner et al. (2018), and the half-explicit scheme without truncation, which ends all motion.
PROJECTED = (
    "implicit-euler-ggl",
    "explicit-projection-euler",
    "semi-implicit-projection-euler",
    "half-explicit-euler[truncation=none]",
)
BRIEF = ("drift", "strong", "weak")
