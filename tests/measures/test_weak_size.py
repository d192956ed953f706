"""Weak errors have a size: constants of leading terms, and bounds that claims state at one step size."""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest

from facade import Locked, gbm
from sdaeverify import SDE, Claim, Moment, SchemeError, verify
from sdaeverify.measuring import Bound
from sdaeverify_schemes.euler_maruyama import EulerMaruyama

RUN: dict[str, Any] = {"paths": 256, "levels": "8..64", "progress": "none"}
# Of Euler's method with 12 steps on dx = x/2 dt + 3/5 x dW, x_0 = 1, T = 1.
RATE, VOLATILITY, STEPS = 0.5, 0.6, 12
MEAN = (1.0 + RATE / STEPS) ** STEPS - np.exp(RATE)
SQUARE = ((1.0 + RATE / STEPS) ** 2 + VOLATILITY**2 / STEPS) ** STEPS - np.exp(2.0 * RATE + VOLATILITY**2)


def bound(most, at=1.0 / STEPS, *quantities):
    """Return a claim of a bound of the weak error."""
    return Claim(measure="weak", value="error", bound=most, at=at, quantities=quantities, source="test")


def bounded(*bounds):
    """Return Euler-Maruyama with bounds of its weak error beside its orders."""

    class Bounded(EulerMaruyama):
        name: ClassVar[str] = "bounded"
        claims: ClassVar[tuple[Claim, ...]] = (*EulerMaruyama.claims, *bounds)

    return Bounded()


def rows(problem, *bounds, **run):
    """Return the verdicts of a scheme with some bounds, by quantity."""
    found = verify([bounded(*bounds)], problem, "weak", **{**RUN, **run}).verdicts
    return {row["quantity"]: row for _, row in found.iterrows()}


@pytest.mark.sweep
@pytest.mark.parametrize(("share", "verdict"), [(1.001, "verified"), (0.999, "refuted")])
@pytest.mark.parametrize(("quantity", "error"), [("x", MEAN), ("x^2", SQUARE)])
def test_a_bound_is_decided_without_sampling(share, verdict, quantity, error):
    """A thousandth above the error it is verified, and a thousandth below it is refuted, by 256 paths or none."""
    found = rows("gbm", bound(share * abs(error), 1.0 / STEPS, quantity))
    row = found[f"{quantity}@h=0.0833333"]

    assert (row["verdict"], row["decided_by"], row["value_of"]) == (verdict, "T2", "weak error")
    assert row["value"] == pytest.approx(error, rel=1e-9)
    # The order of the same observable is another row, as without the bound.
    assert found[quantity]["claim"] == "order >= 1.0"


def test_the_least_of_several_bounds_is_put_to_the_test():
    """Each observable and step size has one row, with the strongest claim about it."""
    found = rows("gbm", bound(1.0), bound(0.01), bound(0.02, 1.0 / 8))

    assert found["x@h=0.0833333"]["claim"] == "error at most 0.01 at h = 0.0833333"
    assert found["x@h=0.0833333"]["verdict"] == "refuted"
    assert [name for name in found if "@" in name] == [
        f"{name}@h={h}" for name in ("x", "x^2", "x^3") for h in ("0.0833333", "0.125")
    ]


def test_on_a_chart_the_operator_knows_means_that_are_not_quadratic():
    """E cos x of the Ornstein-Uhlenbeck process is known by the transition operator, the mean by moments."""
    found = rows("ou", bound(0.02, 0.125, "cos x"), bound(0.03, 0.125, "x"))

    assert {name: found[name]["verdict"] for name in found if "@" in name} == {
        "x@h=0.125": "verified",
        "cos x@h=0.125": "verified",
    }
    assert found["x@h=0.125"]["value"] == pytest.approx((1.0 - 0.125) ** 8 - np.exp(-1.0), rel=1e-9)


def nonlinear():
    """Return an equation that is not linear and has no chart."""
    return SDE(
        drift=lambda t, x: -np.sin(x),
        diffusion=lambda t, x: 0.2 + 0.0 * x[:, None],
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="test",
        observables={"x": lambda t, parts: parts["x"][0]},
    )


def test_what_is_not_known_is_left_open_and_says_what_would_decide():
    """Without moments or a chart paths decide at their own steps, if the mean of the solution is known."""
    other, same = (rows(nonlinear, bound(0.01, h))[f"x@h={h:g}"] for h in (0.1, 0.125))

    assert {row["verdict"] for row in (other, same)} == {"inconclusive"}
    assert "not 10 (--levels)" in other["reason"]
    assert "unless a Moment of x is attached" in same["reason"]


def with_truth(mean):
    """Return a function that returns the same with a mean that is said to be the solution's."""

    def told():
        return replace(nonlinear(), truths=(Moment(observable="x", value=lambda t: mean, source="test"),))

    return told


@pytest.mark.long
def test_paths_decide_where_the_mean_is_known():
    """The error at a level is compared with the bound, both ways; near the bound nothing is decided."""
    fine = verify([EulerMaruyama()], nonlinear, "weak", **{**RUN, "paths": 4096, "levels": "8..512"}).levels
    mean = float(fine[fine["h"] == fine["h"].min()]["mean"].iloc[-1])
    error = abs(float(fine[fine["h"] == 0.125]["mean"].iloc[-1]) - mean)
    found = [
        rows(with_truth(mean), bound(share * error, 0.125), paths=4096)["x@h=0.125"]["verdict"]
        for share in (2.0, 1.0, 0.5)
    ]

    assert found == ["verified", "inconclusive", "refuted"]


def test_a_step_size_that_does_not_divide_the_horizon():
    """No run has such steps, and nothing is decided."""
    row = rows("gbm", bound(0.1, 0.3, "x"))["x@h=0.3"]

    assert (row["verdict"], row["reason"]) == (
        "inconclusive",
        "The step size 0.3 does not divide the horizon 1.",
    )


def test_an_observable_that_the_problem_has_not():
    """What the problem has is told by the names of its observables, without step sizes."""
    found = rows("gbm", bound(0.1, 0.125, "x"), bound(0.1, 0.125, "y"))

    assert found["y"]["verdict"] == "out_of_scope"
    assert found["y"]["reason"].endswith("measured here: x, x^2, x^3.")


def test_a_bound_of_the_size_of_the_observable_says_nothing():
    """A claim that grants an error as large as the mean is not verified."""
    row = rows("gbm", bound(5.0, 1.0 / STEPS, "x"))["x@h=0.0833333"]

    assert row["verdict"] == "inconclusive"
    assert "no error exceeds it" in row["reason"]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"value": "error", "bound": 0.1}, "needs the one positive step size"),
        ({"value": "unbiased", "bound": 0.1, "at": 0.1}, "needs the one positive step size"),
        ({"value": "error", "bound": 0.1, "at": -0.1}, "needs the one positive step size"),
        ({"value": 1.0, "at": 0.1}, "without a bound"),
    ],
)
def test_errors_alone_are_bounded_at_a_step_size(given, says):
    """A bound of an error names its step size, and no other claim has one."""
    with pytest.raises(SchemeError, match=says):
        Claim(measure="weak", source="test", **given)


def test_a_bound_is_about_its_step_size_alone():
    """It covers the quantity with this step size behind its name; an order covers none of these."""
    own, order = bound(0.1, 0.125, "x"), Claim(measure="weak", value=1.0, source="test")

    assert [own.covers("weak", name) for name in ("x", "x@h=0.125", "x@h=0.25", "y@h=0.125")] == [
        False,
        True,
        False,
        False,
    ]
    assert [order.covers("weak", name) for name in ("x", "x@h=0.125")] == [True, False]


def test_a_locked_bound_keeps_its_step_size():
    """A smaller bound at the same step size implies it, one at another step size does not."""
    locked, smaller, other = (Locked.of(bound(most, h)) for most, h in ((0.1, 0.125), (0.05, 0.125), (0.05, 0.25)))

    assert str(locked) == str(Bound("error", 0.1, at=0.125)) == "error at most 0.1 at h = 0.125"
    assert [each.implies(locked) for each in (smaller, other)] == [True, False]


def test_constants_are_details_of_findings():
    """The leading error is told beside each quadratic observable, and beside no other one."""
    table = verify([EulerMaruyama()], "gbm", "weak", **RUN).details("weak").set_index("quantity")

    assert table["error_power"]["x"] == 1.0
    assert table["error_constant"]["x"] == pytest.approx(-0.5 * RATE**2 * gbm().horizon * np.exp(RATE), rel=1e-4)
    assert np.isnan(table["error_constant"]["x^3"])
    assert table["error_constant_known"]["x"] < 1e-4
