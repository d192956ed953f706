"""The strong study of Euler-Maruyama on geometric Brownian motion against other packages, on one core.

Same levels, same number of paths, double precision; a rival's compilation is not counted. The rivals come with
``pip install .[rivals]``.
"""

import pytest

from benchmarks.pairs import run_pairs
from benchmarks.study import Means, ours

# The rivals' own warnings are no concern here.
pytestmark = [pytest.mark.benchmark, pytest.mark.filterwarnings("ignore")]

PATHS = 20480
INTERVALS = {
    "W, default cache": {},
    "W, all cached": {"cache_size": None},
    "W and H, all cached": {"cache_size": None, "levy_area_approximation": "space-time"},
}


def test_strong_study_against_diffrax(benchmark, report, one_core):
    """It is faster than diffrax with a virtual Brownian tree, and both find the same errors."""
    pytest.importorskip("diffrax", reason="needs the extra: pip install .[rivals]")
    from benchmarks.rival_diffrax import compiled  # noqa: PLC0415 - an optional extra

    rival = compiled(PATHS)
    _require_agreement(ours(PATHS), rival())
    ratio = run_pairs(benchmark, lambda: ours(PATHS), rival, rounds=5).speed_up
    report(f"strong study on {PATHS} paths, diffrax / sdaeverify", ratio, "at least 10")


@pytest.mark.parametrize("interval", INTERVALS)
def test_strong_study_against_torchsde(interval, benchmark, report, one_core):
    """It is faster than torchsde, whichever way its Brownian interval is set up, and both find the same errors."""
    pytest.importorskip("torchsde", reason="needs the extra: pip install .[rivals]")
    from benchmarks.rival_torchsde import prepared  # noqa: PLC0415 - an optional extra

    rival = prepared(PATHS, INTERVALS[interval])
    _require_agreement(ours(PATHS), rival())
    ratio = run_pairs(benchmark, lambda: ours(PATHS), rival, rounds=15).speed_up
    report(f"strong study on {PATHS} paths, torchsde ({interval}) / sdaeverify", ratio, "at least 5")


def _require_agreement(mine: Means, theirs: Means) -> None:
    assert mine.agree(theirs), f"errors differ: {mine} and {theirs}"
