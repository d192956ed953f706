"""The sequential rule with the bound exactly at the true slope, where every decision is an error.

Looks at n = UNIT 2^k paths, k < K; at each a test on either side, and the first decision stands. With level alpha/K
at each look the probability of an error on one side is at most alpha; with level alpha, peeking, it is not.
"""

from collections.abc import Iterator

import numpy as np

from ...arrays import Array
from .judged import LOOKS
from .rates import NOTHING, ExpectedRate, Rate, Trials
from .repeated import POOLED, UNIT
from .samples import Sample
from .slopes import slopes

ALPHA = 0.05
RULES = {
    "level alpha/K at each look": (len(LOOKS), ExpectedRate.at_most(ALPHA)),
    "peeking at level alpha": (1, ExpectedRate(ALPHA, 1.0, f"more than {ALPHA:g}")),
}


def look_rates(sample: Sample) -> Iterator[Rate]:
    """Yield the rates of false decisions on either side, with the correction for looks and without."""
    found = [slopes(sample, count, "L1", POOLED) for count in LOOKS]
    for rule, (looks, expected) in RULES.items():
        sides = []
        for estimate, truth in found:
            low, high = estimate.interval(1.0 - 2.0 * ALPHA / looks)
            sides.append(np.where(low > truth, 1, np.where(high < truth, -1, 0)))
        decided, paths = first_decision(np.array(sides))
        # Below the sample size from which a heavy tail is judged at all, the rule is shown and not used.
        promised = NOTHING if sample.case.heavy else expected
        trials = Trials("looks", sample.case.label, float(paths.mean()))
        yield trials.rate(f"falsely verified, {rule}", decided > 0, promised)
        yield trials.rate(f"falsely refuted, {rule}", decided < 0, promised)


def first_decision(sides: Array) -> tuple[Array, Array]:
    """Return the first decision that is not 0 of each sequence, and the paths it took.

    Parameters
    ----------
    sides : ndarray, shape (K, S)

    Returns
    -------
    ndarray, shape (S,)
    ndarray, shape (S,)
    """
    # The last look ends the sequence whatever it says.
    ends = np.concatenate([sides[:-1] != 0, np.ones_like(sides[-1:], dtype=bool)]).argmax(axis=0)
    return sides[ends, np.arange(sides.shape[1])], UNIT * np.array(LOOKS)[ends]
