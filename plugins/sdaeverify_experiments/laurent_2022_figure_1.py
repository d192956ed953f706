"""Figure 1 of Laurent (2022): errors of E |x|^2 on the torus against the stiffness parameter."""

from collections.abc import Iterator

from sdaeverify import Experiment, MeanTable, Row, hookimpl

# The values of eps of which the invariant mean is known, from fast to slow penalties, and the limit.
STIFFNESSES = ("0", "1e-06", "0.0001", "0.001", "0.01", "0.1", "1.0", "10.0")
# With the noise (2.3) of the paper.
LEFT = tuple(f"{name}[xi=three-point]" for name in ("constrained-euler", "penalised-euler", "uniformly-accurate"))
# h = T/2^9 and shorter: with T = 10 the steps T/2^8 and longer often have no root.
FIRST, LAST = 9, 12
NOTES = (
    "The figure is a plot without numbers; what is compared here is the error against the exact mean.",
    "Explicit Euler is stable for h (1/eps + 25) < 2 only, so that its paths are lost for small eps.",
)


def rows(eps: str) -> Iterator[Row]:
    """Yield the rows of one value of eps: the three schemes of the left half, and shorter steps of the right one."""
    problem = f"torus[eps={eps},horizon=10]"
    for scheme in LEFT if eps != "0" else LEFT[::2]:
        yield Row(problem=problem, scheme=scheme, steps=2**FIRST, observable="|x|^2")
    for k in range(FIRST + 1, LAST + 1):
        yield Row(problem=problem, scheme=LEFT[-1], steps=2**k, observable="|x|^2", costly=k > FIRST + 1)


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the figure."""
    return [
        MeanTable(
            name="laurent-2022-figure-1",
            title="errors of E |x|^2 on the torus for eps from 0 to 10 and h = T/2^9, T/2^10, ..., T = 10",
            source="Laurent 2022, Figure 1",
            rows=tuple(row for eps in STIFFNESSES for row in rows(eps)),
            equilibrium=True,
            notes=NOTES,
        )
    ]
