"""The strong measure as a whole, on sequences of paths: published intervals, verdicts on true and false claims."""

from collections.abc import Iterator

from .judged import ABOVE
from .rates import NOTHING, ExpectedRate, Rate, Trials
from .repeated import POOLED, UNIT
from .samples import Sample
from .slopes import COVERED, slopes

# Wider than nominal is allowed where a bound of a bias is added.
PUBLISHED = ExpectedRate(COVERED.low, 1.0, f"at least {COVERED.low:g}")
TIERS = ("paths alone", "with local orders")
# The confidence of a run is 99 %: no more than this share of wrong verdicts on either side.
WRONG = ExpectedRate.at_most(0.01)


def published_rates(sample: Sample) -> Iterator[Rate]:
    """Yield the coverage of the slope's and of the asymptotic order's interval, as published."""
    judged = sample.judged
    assert judged is not None
    trials = Trials("published", sample.case.label, UNIT * POOLED)
    _, truth = slopes(sample, POOLED, "L1")
    slope = (judged.low <= truth) & (truth <= judged.high)
    yield trials.rate("interval of the slope, 95 %", slope, PUBLISHED)
    order = abs(judged.asymptotic - sample.case.order) <= judged.half
    yield trials.rate("interval of the asymptotic order, 95 %", order, PUBLISHED)


def verdict_rates(sample: Sample) -> Iterator[Rate]:
    """Yield the rates of verdicts on the true order and on half an order more."""
    judged = sample.judged
    assert judged is not None
    for tier, words in enumerate(TIERS):
        for claim, above in enumerate(ABOVE):
            outcome, paths = judged.outcome[:, claim, tier], judged.paths[:, claim, tier]
            trials = Trials("verdicts", sample.case.label, float(paths.mean()))
            claimed = f"order + {above:g}" if above else "true order"
            yield trials.rate(f"{claimed} verified, {words}", outcome > 0, WRONG if above else NOTHING)
            yield trials.rate(f"{claimed} refuted, {words}", outcome < 0, NOTHING if above else WRONG)
