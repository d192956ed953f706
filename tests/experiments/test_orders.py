"""Orders from rows with a reference."""

import numpy as np
import pytest

from experiments.running import lines_of, mean_square
from facade import FineRun, MeanLine, MeanSample, Row, orders

REFERENCE = FineRun("s", 1024)


def row(steps, **other):
    return Row(**{"problem": "p", "scheme": "s", "steps": steps, "observable": "x", "reference": REFERENCE, **other})


def line(steps, values, **other):
    return MeanLine(row(steps, **other), 1.0 / steps, 1.0, MeanSample.of(np.asarray(values)))


def test_power_law():
    """Squares that fall like h^(2 p) on every path have order p, without error whatever the paths do in common."""
    common = np.random.default_rng(1).exponential(size=100)

    (found,) = orders([line(steps, common * steps**-1.5) for steps in (8, 16, 32, 64)])

    assert found.estimate.value == pytest.approx(0.75, rel=1e-12)
    assert found.estimate.se < 1e-12
    assert (found.row.scheme, found.row.observable, found.row.reference) == ("s", "x", REFERENCE)
    assert found.in_words.startswith("s on p: order 0.7500 +- 0.0000 of the root mean square of x - ref, from 4")


def test_standard_error():
    """The standard error is that of the estimates: of 200 repetitions nearly all are within three of the order."""
    rng, off = np.random.default_rng(2), []
    for _ in range(200):
        (found,) = orders([line(steps, rng.exponential(size=400) / steps) for steps in (4, 8, 16)])
        off.append((found.estimate.value - 0.5) / found.estimate.se)

    # Student's t with 19 degrees of freedom: 0.7 percent beyond 3, so that 7 or more of 200 are one in 500.
    assert sum(abs(each) > 3.0 for each in off) < 7
    assert 0.8 < np.std(off) < 1.3


def test_rows_that_belong_together():
    """Rows differ in the step size alone, and two make no order."""
    found = [line(steps, np.ones(40) / steps) for steps in (4, 8, 16)]
    others = [line(steps, np.ones(40) / steps, observable="y") for steps in (4, 8)]
    more = [line(32, np.ones(40), scheme="other"), line(32, np.ones(40), reference=None), line(32, np.zeros(40))]

    assert [(each.row.observable, each.step_sizes) for each in orders(found + others + more)] == [("x", 3)]
    assert orders(others + more) == []
    assert orders([each._replace(sample=MeanSample()) for each in found]) == []


def test_euler(planned):
    """The order of Euler's scheme is that of its mean square errors in closed form, within four standard errors."""
    sizes, finest = (8, 16, 32, 64), 512
    reference = FineRun("euler-maruyama", finest)
    rows = [
        Row(problem="gbm[b=0.3]", scheme="euler-maruyama", steps=steps, observable="x", reference=reference)
        for steps in sizes
    ]
    run = planned(*rows, paths=2000)
    list(run.run())

    (found,) = orders(lines_of(run))

    exact = [mean_square(0.5, 0.3, steps, finest // steps) for steps in sizes]
    order = np.polyfit(np.log2([1.0 / steps for steps in sizes]), np.log2(np.sqrt(exact)), 1)[0]
    assert abs(found.estimate.value - order) < 4.0 * found.estimate.se
    assert found.estimate.se < 0.02
