"""How small an error of the limit would have shown, on errors whose limit is known, without any simulation."""

from dataclasses import replace
from math import inf, isinf, isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from cells import claimant
from facade import (
    LAW,
    ErrorObserver,
    LawResolution,
    MeanObserver,
    bound_limit_error,
    gbm,
    means_of,
    quantities_of,
    stationary_resolution,
    step_resolution,
    strong_resolution,
    weak_resolution,
)
from sdaeverify import SDE, Claim, Settings
from sdaeverify.measuring import Evidence, Snapshot, Tally, packed

PATHS = 400
SETTINGS = Settings(paths=PATHS)
H = np.array([1.0 / n for n in SETTINGS.steps])
FINEST = len(H) - 1
CLAIM = Claim(measure="strong", value=1.0, source="test")


def evidence_of(observer, problem=None):
    """Return evidence of nothing but what an observer noted."""
    seen = problem or gbm()
    return Evidence(claimant(), seen, seen, SETTINGS, observer.tally(), Tally())


def strong(order, limit, claim=CLAIM):
    """Return the resolution of errors z h^order + limit of a solution that moves by 2."""
    z = np.random.default_rng(5).normal(size=PATHS)
    observer = ErrorObserver({"x": np.zeros((1, PATHS))}, SETTINGS)
    truth = {"x": np.full((1, PATHS), 2.0)}
    observer.after_coarsest_step(Snapshot([{"x": 2.0 + (z * h**order + limit)[None]} for h in H], truth, None))
    evidence = evidence_of(observer)
    quantity = {each.name: each for each in quantities_of(evidence)}["x@T"]
    return strong_resolution(evidence, quantity, FINEST, claim)


def weak(order, limit, spread=0.01):
    """Return the resolution of means 3 + h^order + limit, of which the mean 3 is known."""
    z = spread * np.random.default_rng(6).normal(size=PATHS)
    levels = [{"x": (3.0 + z + h**order + limit)[None]} for h in H]
    problem = gbm()
    observer = MeanObserver(problem, levels[0], SETTINGS)
    observer.after_coarsest_step(Snapshot(levels, {"x": (3.0 + z)[None]}, None))
    evidence = evidence_of(observer, problem)
    return weak_resolution(evidence, means_of(evidence)["x"], None, CLAIM)


@given(order=some.floats(0.8, 2.0), limit=some.floats(0.0, 1.0))
def test_no_error_of_the_limit_is_larger_than_the_resolution_of_paths(order, limit):
    """Whatever the order above the granted one, the error of the limit is no larger than what would have shown."""
    assert strong(order, limit) >= limit / 2.0


@given(order=some.floats(0.8, 2.0), limit=some.floats(-1.0, 1.0))
def test_no_error_of_the_limit_is_larger_than_the_resolution_of_means(order, limit):
    """The same of expectations, whose errors have a sign."""
    assert weak(order, limit) * (3.0 + limit + H[-1] ** order) >= abs(limit) - 1e-3


def test_resolution_is_as_sharp_as_the_finest_errors():
    """Without an error of the limit, what would have shown is the error that is left and what is still to come."""
    left = np.sqrt(2.0 / np.pi) * H[-1]
    assert left / 2.0 < strong(1.0, 0.0) < 3.0 * left / 2.0


def test_nothing_is_said_without_a_claim_and_nothing_shows_without_a_reference():
    """Without a claim there is no resolution; a scheme that is its own reference shows no error of its limit."""
    assert isnan(strong(1.0, 0.0, claim=None))
    observer = ErrorObserver({"x": np.zeros((1, PATHS))}, SETTINGS)
    observer.after_coarsest_step(Snapshot([{"x": np.ones((1, PATHS))}] * len(H), {"x": np.ones((1, PATHS))}, None))
    own = SDE(
        drift=lambda t, x: x, diffusion=lambda t, x: x[:, None], start=[1.0], noise_dim=1, horizon=1.0, source="t"
    )
    evidence = evidence_of(observer, own)
    assert isinf(strong_resolution(evidence, quantities_of(evidence)[0], FINEST, CLAIM))


def test_an_error_that_is_not_finite_shows_nothing():
    """Where errors are infinite, any limit is possible."""
    assert bound_limit_error(inf, 0.0, 1.0) == inf


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_what_is_still_to_come_is_a_geometric_series(order):
    """Differences c h^p from one level to the next add up to the last one over 2^p - 1."""
    levels = 2.0 ** -np.arange(60)
    errors = levels**order
    assert bound_limit_error(0.0, errors[4] - errors[5], order) == pytest.approx(errors[5])


@given(order=some.floats(0.8, 2.0), limit=some.floats(-1.0, 1.0))
def test_no_error_of_a_stationary_limit_is_larger_than_its_resolution(order, limit):
    """Biases h^order + limit are known to rounding: the limit is no larger than what would have shown."""
    rounding = 1e-12
    assert stationary_resolution(H**order + limit, np.zeros(len(H)), 2.0, CLAIM) >= abs(limit) / 2.0 - rounding


def test_a_bias_without_order_is_bounded_where_it_is_largest():
    """What is claimed to be unbiased at each step size is so to the far end of the largest interval."""
    unbiased = Claim(measure="invariant", value="unbiased", bound=0.1, source="test")
    errors, off = np.array([0.01, -0.04, 0.02]), np.array([0.01, 0.01, 0.02])
    assert stationary_resolution(errors, off, 0.5, unbiased) == pytest.approx(0.1)
    assert stationary_resolution(errors, off, 1e-17, unbiased) == pytest.approx(0.05)


def test_where_only_the_scheme_knows_the_limit_single_steps_tell():
    """A share of a run that n times miss with a probability of 1 per cent may be wrong by all of its motion."""
    problem, seen = gbm(), packed(LAW, LawResolution(32.0, 1e-3))
    evidence = Evidence(claimant(), problem, problem, SETTINGS, seen, Tally())
    assert step_resolution(evidence) == pytest.approx(-np.log(0.01) / 32.0)
    assert step_resolution(replace(evidence, tally=packed(LAW, LawResolution(32.0, 0.2)))) == 0.2
    assert isinf(step_resolution(replace(evidence, tally=Tally())))
