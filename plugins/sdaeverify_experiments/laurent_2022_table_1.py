"""Table 1 of Laurent (2022): the mean trace of matrices near the orthogonal group."""

from collections.abc import Iterator

from sdaeverify import Experiment, MeanTable, Printed, Row, hookimpl

PATHS = 10**6
# With the noise (2.3) of the paper.
UNIFORM, EULER = "uniformly-accurate[xi=three-point]", "constrained-euler[xi=three-point]"
# By m: J(m) from the reference, UA with h = 2^-9, then J_UA and J_EC with h = 2^-7.
TABLE = {
    2: ("2.00934", "2.00619", "1.99165"),
    3: ("3.01458", "3.00821", "2.97460"),
    4: ("4.02050", "4.00972", "3.94846"),
    5: ("5.02669", "5.00842", "4.91298"),
}
NOTES = (
    "The printed references J(m) have the error of their step size: the exact values are those of the invariant law.",
    "The time of the drift is 1/100, so that at T = 1 the law is invariant to all digits.",
)


def rows(m: int) -> Iterator[Row]:
    """Yield the rows of O(m)."""
    problem = f"orthogonal-group[eps=0.005,m={m},stiffness=100,horizon=1]"
    reference, uniform, euler = (Printed(digits, PATHS) for digits in TABLE[m])
    for scheme, k, printed in (
        (UNIFORM, 7, uniform),
        (UNIFORM, 8, None),
        (UNIFORM, 9, reference),
        (UNIFORM, 10, None),
        (EULER, 7, euler),
    ):
        yield Row(problem=problem, scheme=scheme, steps=2**k, observable="tr x", printed=printed, costly=k > 8)


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the table."""
    return [
        MeanTable(
            name="laurent-2022-table-1",
            title="E tr x near O(m), m = 2..5, eps = 0.005: uniformly accurate and constrained Euler at T = 1",
            source="Laurent 2022, Table 1",
            rows=tuple(row for m in TABLE for row in rows(m)),
            equilibrium=True,
            notes=NOTES,
        )
    ]
