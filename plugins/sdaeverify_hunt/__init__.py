"""Hunts: problems are drawn at random, tested by one step, shrunk, and confirmed by a run.

::

    from sdaeverify_hunt import hunt, parametrize_with_hunts

    report = hunt("milstein", measures=["strong"], examples=50)

    @parametrize_with_hunts([MyScheme()])
    def test_no_counterexample(subject, check):
        check(subject)

The strategies that draw problems are in `sdaeverify_hunt.strategies`, for property tests of schemes.
"""

from .hunting import hunt
from .hunts import parametrize_with_hunts

__all__ = ["hunt", "parametrize_with_hunts"]
