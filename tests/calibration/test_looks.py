"""The sequential rule at the boundary."""

import numpy as np

from facade import first_decision, look_rates, offending, studies


def test_first_decision_stands():
    """A sequence ends at its first decision, or undecided with all its paths."""
    sides = np.array([[0, 1, 0, 0], [-1, -1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, -1]])

    decided, paths = first_decision(sides)

    np.testing.assert_array_equal(decided, [-1, 1, 0, -1])
    np.testing.assert_array_equal(paths, [200, 100, 1600, 1600])


def test_looks_share_the_level(synthetic):
    """With the level shared among the looks errors stay below alpha; peeking makes several times as many."""
    rates = {rate.statistic: rate for rate in look_rates(synthetic(240))}

    assert not offending(list(rates.values()))
    for side in ("falsely verified", "falsely refuted"):
        corrected, peeking = (rates[f"{side}, {rule}"] for rule in studies.RULES)
        assert corrected.rate <= 0.05 < peeking.interval()[0]


def test_uncorrected_looks_are_reported(synthetic, monkeypatch):
    """A rule that promises what only a correction can keep is reported."""
    promised = studies.RULES["level alpha/K at each look"][1]
    monkeypatch.setattr(studies, "RULES", {"uncorrected": (1, promised)})

    assert offending(list(look_rates(synthetic(240))))
