"""From errors to verdicts: orders in law and bounds of a bias, on errors whose law is known."""

from typing import ClassVar

import numpy as np
import pytest

from sdaeverify import Claim, UsageError
from sdaeverify.measuring import Order
from sdaeverify.numerics import GROUPS
from sdaeverify_sealed import Sealed
from sdaeverify_sealed.judging import may_reach, p_falls, p_slower
from sdaeverify_sealed.sample import Budget
from sealed.solving import H, judged, made

ONE, TWO, WITHIN = (
    Claim(measure="weak", value=1.0, margin=0.45, source="made up"),
    Claim(measure="weak", value=2.0, margin=0.45, source="made up"),
    Claim(measure="weak", value="unbiased", bound=0.01, source="made up"),
)


def claiming(claim):
    """Return a solver with one claim."""

    class Claiming(Sealed):
        name: ClassVar[str] = "claiming"
        claims: ClassVar[tuple[Claim, ...]] = (claim,)

        def run(self, problem, h, T, paths, seed):
            raise NotImplementedError

    return Claiming()


@pytest.mark.parametrize(
    ("claim", "errors", "se", "verdict"),
    [
        (ONE, 0.8 * H, 1e-3, "verified"),
        (ONE, 0.8 * H, 3e-2, "inconclusive"),
        (TWO, 3.0 * H**2, 2e-4, "verified"),
        (TWO, 0.8 * H, 1e-3, "refuted"),
        (TWO, 0.8 * H, 3e-2, "inconclusive"),
        # A wrong limit, alone and beside an error that falls.
        (ONE, 0.1 + 0.0 * H, 1e-3, "refuted"),
        (ONE, 0.1 + 0.4 * H, 1e-3, "refuted"),
        (ONE, -0.2 + 0.4 * H, 1e-3, "refuted"),
        # A limit that is wrong by more than a quarter of the coarsest error is not verified before it shows.
        (ONE, -0.04 + 0.6 * H, 1e-4, "inconclusive"),
        # Half of the error at the finest step size is of order 1: not of order 2, though the range looks like it.
        (TWO, 0.1 * H + 1.6 * H**2, 1e-5, "inconclusive"),
        # Too coarse steps refute no right solver: local orders rise, or errors change their sign.
        (TWO, 3.0 * H**2 / (1.0 + 30.0 * H**2), 1e-4, "inconclusive"),
        (ONE, H - 4.8 * H**2, 1e-5, "inconclusive"),
        (ONE, H - 3.8 * H**2, 1e-5, "inconclusive"),
        (TWO, np.array([0.33, -0.11, -0.045]), 2e-3, "inconclusive"),
        # An order that falls below the claim at the next step size is not verified, nor one with much noise.
        (TWO, np.array([0.16, 0.02, 0.01]), 1e-4, "inconclusive"),
        (TWO, np.array([0.16, 0.02, 0.01]), 3e-3, "inconclusive"),
        (WITHIN, np.array([0.004, 0.002, 0.001]), 1e-3, "verified"),
        (WITHIN, np.array([0.02, 0.002, 0.001]), 1e-3, "refuted"),
        (WITHIN, np.array([0.009, 0.002, 0.001]), 1e-3, "inconclusive"),
    ],
)
def test_verdicts_are_those_of_the_errors(claim, errors, se, verdict):
    """A claim is verified, refuted or left open as its errors are, and as their noise allows."""
    assert judged(claiming(claim), made(errors, se)).verdict.value == verdict


def test_a_bound_as_large_as_the_spread_is_no_claim():
    """A bound no smaller than the standard deviation of the observable is not verified, whatever the bias is."""
    vacuous = Claim(measure="weak", value="unbiased", bound=2.0, source="made up")
    found = judged(claiming(vacuous), made(0.0 * H, 1e-2))

    assert found.verdict.value == "inconclusive"
    assert "not below the size of the quantity" in str(found.reason)


def test_an_error_below_the_noise_is_told():
    """A solver without a visible error is told to claim a bound in place of an order."""
    found = judged(claiming(ONE), made(0.0 * H, 1e-2))

    assert found.verdict.value == "inconclusive"
    assert "claim `unbiased`" in str(found.reason)


@pytest.mark.slow
@pytest.mark.parametrize("errors", [0.4 * H, 0.5 * H**0.55, 0.0 * H])
def test_levels_are_kept(errors):
    """Of 4000 samples a claim that holds, at its margin too, is refuted at 1 per cent in no more than that.

    The number of false refutations has the binomial law at most: 4000 p + 4 (4000 p)^(1/2) is not passed.
    """
    claimed, count, level = Order(1.0, 0.45), 4000, 0.01
    rng = np.random.default_rng(7)
    found = 0
    for _ in range(count):
        noise = 0.02 * np.sqrt(GROUPS) * rng.standard_normal((GROUPS, len(H)))
        sample = errors + noise
        found += p_slower(sample, H, claimed.floor) <= level
    assert found <= count * level + 4.0 * (count * level) ** 0.5


@pytest.mark.slow
def test_nothing_is_verified_at_the_margin():
    """Of 4000 samples whose order is exactly claim - margin, no more than 1 per cent are verified at 1 per cent."""
    claimed, count, level = Order(1.0, 0.45), 4000, 0.01
    rng = np.random.default_rng(8)
    errors = 0.5 * H**claimed.floor
    noise = 0.01 * np.sqrt(GROUPS) * rng.standard_normal((count, GROUPS, len(H)))
    found = sum(p_falls(errors + each, H, claimed) <= level for each in noise)
    assert found <= count * level + 4.0 * (count * level) ** 0.5


def test_an_order_that_rises_may_reach_the_claim():
    """Errors whose local order rises are no evidence against an order; those of a low order are."""
    constant, rising = 0.8 * H, 3.0 * H**2 / (1.0 + 30.0 * H**2)
    errors = [np.tile(each, (GROUPS, 1)) * (1.0 + 1e-4 * np.arange(GROUPS))[:, None] for each in (constant, rising)]

    assert [may_reach(each, H, Order(2.0, 0.45)) for each in errors] == [False, True]


def test_a_known_bias_of_the_reference_is_granted():
    """What the reference may be off is added to both sides: the same errors refute nothing then."""
    errors = made(0.01 + 0.0 * H, 1e-4).errors("x", 1)

    assert p_slower(errors, H, 0.25) < 1e-6
    assert p_slower(errors, H, 0.25, bias=0.02) > 0.5


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"paths": 100}, "at least 3200 for 3 looks, got 100"),
        ({"looks": 0}, "between 1 and 20, got 0"),
        ({"steps": (4, 8)}, "at least three increasing numbers of steps"),
        ({"steps": (8, 4, 16)}, "at least three increasing numbers of steps, got 8,4,16"),
        ({"seed": -1}, "between 0 and"),
    ],
)
def test_a_wrong_budget_is_refused(given, told):
    """What cannot be sampled is refused before a solver is run."""
    with pytest.raises(UsageError, match=told):
        Budget(**given)


def test_looks_double_the_paths():
    """Each look has as many new paths as all before it, but for the first."""
    assert Budget(paths=16000, looks=4).sizes == (100, 100, 200, 400)
