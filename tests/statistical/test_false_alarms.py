"""Right schemes are not refuted, also on problems that make their steps look coarse."""

from itertools import product

import pytest

from sdaeverify import verify

PROBLEMS = [
    *(f"gbm[a={a},b={b}]" for a, b in product((-8, -2, 0.5, 2, 4), (0.02, 0.1, 0.3, 1))),
    *(f"ou[a={a},sigma={sigma}]" for a, sigma in product((0.2, 1, 4, 8), (0.02, 0.1, 0.7))),
    "pendulum[horizon=2]",
    "pendulum[omega_0=3,horizon=1]",
    "pendulum[c_g=20]",
    "pendulum-tangential[horizon=2]",
    "pendulum-velocity-noise[horizon=1]",
    "pendulum-velocity-noise[sigma=0.1,gamma=2,horizon=1]",
    "pendulum-velocity-noise[sigma=0.2]",
]


@pytest.mark.slow
def test_shipped_claims_hold_on_other_parameters():
    """Over 39 parameter sets, stiff, noisy and nearly noise-free ones among them, no shipped claim is refuted."""
    verdicts = verify(problems=PROBLEMS, paths=4096).verdicts

    assert verdicts[verdicts.verdict.isin(["refuted", "error"])].empty
    assert (verdicts.verdict == "verified").sum() > 300
