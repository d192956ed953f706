"""Planted wrong schemes are refuted, and the right ones beside them are not."""

import pytest

import faulty
from sdaeverify import verify

PATHS = 2048

PLANTED = [
    (faulty.MissingItoCorrection(), "gbm", {"strong"}),
    (faulty.NoiseScaledByH(), "gbm", {"strong"}),
    (faulty.NoiseTooStrong(), "gbm", {"strong"}),
    (faulty.MilsteinSign(), "gbm", {"strong"}),
    (faulty.FixedDirection(), "pendulum[horizon=0.1]", {"strong"}),
    (faulty.FixedDirection(), "pendulum", {"drift"}),
    (faulty.VelocityNotProjected(), "pendulum", {"strong", "drift"}),
]


@pytest.mark.parametrize(("scheme", "problem", "measures"), PLANTED)
def test_planted_scheme_is_refuted(scheme, problem, measures):
    """A planted wrong scheme is refuted by the measure that can see it."""
    verdicts = verify([scheme], [problem], sorted(measures), paths=PATHS).verdicts

    assert set(verdicts.loc[verdicts.verdict == "refuted", "measure"]) == measures


def test_right_schemes_are_not_refuted():
    """The schemes the planted ones were made from are verified on the same paths."""
    right = ["euler-maruyama", "milstein", "half-explicit-euler[truncation=none]"]

    verdicts = verify(right, ["gbm", "pendulum"], ["strong", "weak", "drift"], paths=PATHS).verdicts

    assert set(verdicts.verdict) == {"verified"}
