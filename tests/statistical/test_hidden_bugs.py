"""No claim is verified that is false: by the limit, by the order, or by what another line of the same run says."""

from functools import partial
from typing import Any, NamedTuple

import pytest

from sdaeverify import Scheme, verify
from statistical import hidden_bugs as bugs
from statistical import lattice
from wrong.draws import _problem

STRONG, WEAK, BOTH = ("strong",), ("weak",), ("strong", "weak")


class Cell(NamedTuple):
    """A scheme on a problem, and what of it is false.

    Attributes
    ----------
    scheme : Scheme or str
    problem : object
        As `verify` takes it.
    measures : tuple of str
        All claims of these measures are false.
    quantities : tuple of str
        Unless only those of some quantities are.
    options : tuple of (str, object)
        Of `verify`.
    """

    scheme: Scheme | str
    problem: Any
    measures: tuple[str, ...]
    quantities: tuple[str, ...] = ()
    options: tuple[tuple[str, object], ...] = (("paths", 4096),)


CHAIN, LONG_CHAIN = (partial(_problem, label) for label in ("chain", "chain[motions=24]"))
LEVELS = (("paths", 4096), ("levels", "8..1024"))
FOUND = {
    # 1: paths that contradict.
    "window": Cell(bugs.Moved(0.5, 0.5, 0.02, 0.06), "gbm", STRONG),
    "counter": Cell(bugs.Moved(0.5, since=131), "gbm", STRONG, options=LEVELS),
    "Euler below -3/2": Cell(bugs.EulerBelow(), bugs.far_sine, STRONG),
    "Milstein on |x|": Cell("milstein", bugs.kinked_noise, STRONG),
    "Euler on sqrt(x)": Cell("euler-maruyama", bugs.square_root_noise, STRONG),
    "SRA1 on x^+": Cell("sra1", bugs.kinked_drift, STRONG),
    # 2: one line of evidence against a claim.
    "clipped": Cell(bugs.Clipped(), "double-well", (*BOTH, "invariant"), ("x", "x@T", "x^2", "x^4")),
    "h < 1e-5": Cell(bugs.Moved(0.5, below=1e-5), "gbm", BOTH),
    "noise at 1.001 x": Cell(bugs.Loud(), "gbm", STRONG),
    "noise at 1.0003 x": Cell(bugs.Loud(1.0003), "gbm", STRONG),
    # 4: time.
    "early window of a long run": Cell(bugs.quiet(0.005, 0.055), "gbm[horizon=16]", STRONG),
    "second window of a long run": Cell(bugs.quiet(0.07, 0.12), "gbm[horizon=16]", STRONG),
    "two thirds of a long run": Cell(bugs.quiet(0.26, 0.93), "ou[horizon=16]", STRONG),
    "early window": Cell(bugs.quiet(0.005, 0.055), "ou", STRONG),
    # 5: declarations.
    "jumps, noise at 1.003 x": Cell(bugs.Jumping(1.0, 1.003), "gbm", STRONG),
    "jumps, drift at 0.98 x": Cell(bugs.Jumping(0.98), "gbm", BOTH),
    "areas, noise at 1.003 x": Cell(bugs.WithAreas(1.0, 1.003), "levy-area", STRONG),
    "areas, drift at 0.98 x": Cell(bugs.WithAreas(0.98), "levy-area", STRONG),
    "a tenth of the area lost": Cell(bugs.LESS_AREA, "levy-area", STRONG),
    # 6: many noises.
    "drift at 0.997 x with 12 noises": Cell(bugs.Moved(0.997), CHAIN, BOTH, ("x", "x@T", "|x|^2")),
    "drift at 0.999 x with 24 noises": Cell(bugs.Moved(0.999), LONG_CHAIN, BOTH, ("x", "x@T", "|x|^2")),
    # 7: memory.
    "memory far out": Cell(bugs.stale(1.3, 10.0), "ou[horizon=4]", BOTH),
    "memory far out in a double well": Cell(bugs.stale(1.3, 10.0), "double-well", BOTH),
    "y far out, theta": Cell(bugs.UNSOLVED[0](), "gbm-algebraic", BOTH),
    "y far out, lagged": Cell(bugs.UNSOLVED[1](), "gbm-algebraic", BOTH),
    # 8: a jump of an observable, seen by increments with few values.
    "Platen on a lattice": Cell(lattice.PlatenAbove(), lattice.gbm_above, WEAK),
    "coins on a lattice": Cell(lattice.CoinEuler(), lattice.gbm_above, WEAK),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(name, id=name.replace(" ", "-")) for name in FOUND])
def test_what_is_false_is_not_verified(name: str) -> None:
    """None of the false claims of a cell is verified, and there are some."""
    cell = FOUND[name]
    problem = cell.problem() if isinstance(cell.problem, partial) else cell.problem
    table = verify([cell.scheme], [problem], cell.measures, **dict(cell.options)).verdicts
    label = cell.scheme if isinstance(cell.scheme, str) else cell.scheme.label
    false = table[(table.scheme == label) & (table.claim != "")]
    if cell.quantities:
        false = false[false.quantity.isin(("", *cell.quantities))]

    assert len(false)
    assert false[false.verdict == "verified"].empty, false[["measure", "quantity", "verdict", "reason"]].to_string()
