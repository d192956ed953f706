"""Windows between two step sizes of a scan, against the theta method's companion matrix and its Lyapunov equation."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from facade import (
    STEEPER,
    StochasticTheta,
    Window,
    crossings,
    delay_linear,
    delay_stability,
    doubtful,
    refine_scan,
    stable_windows,
)
from facade import delay_equation_UNIT as UNIT
from facade import stability as scanning
from sdaeverify import Array


class Equation(NamedTuple):
    """dx = (A x + B v) dt + (c x + d v) dW with delay 1, and the theta of its method."""

    A: float
    B: float
    c: float
    d: float
    theta: float

    @property
    def windows(self) -> list[Window]:
        """The stable windows as the program finds them."""
        scheme = StochasticTheta(theta=self.theta)
        return delay_stability(scheme, delay_linear(self.A, self.B, self.c, self.d), [0.1], UNIT).windows

    def is_stable(self, h: float) -> bool:
        """Tell whether the companion matrix F of (x_n, ..., x_{n-m}) decays, and h sum_k (g F^k e_1)^2 < 1."""
        A, B, c, d, theta = self
        m = int(np.ceil(1.0 / h - 1e-9))
        delta, unit = max(m - 1.0 / h, 0.0), np.eye(m + 2)
        lagged = delta * unit[m - 1] + (1.0 - delta) * unit[m]
        # The place left of x_n is x_{n+1}, which is on the other side.
        ahead = delta * unit[m - 2] + (1.0 - delta) * unit[m - 1]
        known, of_new = ahead * (np.arange(m + 2) < m + 1) * (m > 1) + (m == 1) * (1.0 - delta) * unit[0], 0.0
        if m == 1:
            of_new = delta
        new = 1.0 - h * theta * (A + B * of_new)
        F = np.eye(m + 1, k=-1)
        F[0] = ((1.0 + h * (1.0 - theta) * A) * unit[0] + h * B * ((1.0 - theta) * lagged + theta * known))[:-1] / new
        if np.abs(np.linalg.eigvals(F)).max() >= 1.0:
            return False
        g = np.sqrt(h) * (c * unit[0] + d * lagged)[:-1] / new
        return bool(g @ solve_discrete_lyapunov(F, np.outer(unit[0, :-1], unit[0, :-1])) @ g < 1.0)


def wrong(equation: Equation, sizes: Array) -> list[float]:
    """Return the step sizes at which the windows contradict the companion matrix."""
    windows = equation.windows
    return [h for h in sizes if any(low < h < high for low, high in windows) != equation.is_stable(h)]


def random_equations(count: int) -> list[Equation]:
    """Return equations whose mean decays."""
    rng = np.random.default_rng(20)
    rates = 10.0 ** rng.uniform([0.0, -0.5], [1.5, 1.3], (count, 2))
    B = np.minimum(rates[:, 1], 0.9 * rates[:, 0]) * rng.choice([-1.0, 1.0], count)
    noise, theta = rng.uniform(0.0, 1.5, (count, 2)), rng.choice([0.0, 0.0, 0.2, 0.4], count)
    return [Equation(*map(float, row)) for row in zip(-rates[:, 0], B, *noise.T, theta, strict=True)]


def test_a_window_between_two_step_sizes_of_the_scan_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A = -10, B = 8, c = 0, d = 1: Euler's method is stable for .225874 < h < .226883, where no scan has a place."""
    monkeypatch.setattr(scanning, "SMALLEST_M", range(4, 7))
    monkeypatch.setattr(scanning, "PER_DECADE", 2)
    monkeypatch.setattr(scanning, "LONGER", 2)
    equation = Equation(-10.0, 8.0, 0.0, 1.0, 0.0)
    ((low, high),) = [window for window in equation.windows if window[0] > 0.2]
    assert (low, high) == pytest.approx((0.225874, 0.226883), abs=1e-6)
    for boundary, inside in ((low, 1.0 + 1e-5), (high, 1.0 - 1e-5)):
        assert equation.is_stable(boundary * inside)
        assert not equation.is_stable(boundary / inside)


@pytest.mark.slow
def test_no_window_wider_than_half_a_percent_is_missed() -> None:
    """At 1200 step sizes from 1/20 to 1 of each of 25 random equations; they have more than 25 boundaries."""
    equations = random_equations(25)
    assert not any(wrong(equation, np.geomspace(1 / 20, 1.0, 1200)) for equation in equations)
    assert sum(len(equation.windows) for equation in equations) > 25


def dip(h: float) -> float:
    """Return a radius above 1 but for .2 % about h = .05, with slopes that show a hundred times as far away."""
    return float(np.exp(np.sqrt(abs(np.log(h / 0.05)) + 1e-6) - np.sqrt(1e-3)))


def test_a_dip_that_shows_by_its_slopes_is_halved_into() -> None:
    """The scan of sixty step sizes has no place in it; the refined one has, and finds both ends."""
    plain = np.geomspace(1e-3, 1e3, 60)
    assert min(dip(h) for h in plain) > 1.0

    scan = refine_scan(lambda h: (h, dip(h), 0.0, 0.0, 0.0, np.inf), plain)
    ((low, high),) = stable_windows(scan.h, scan.sign, crossings(dip, scan.h, scan.sign))
    assert (np.log(low / 0.05), np.log(high / 0.05)) == pytest.approx((-0.001, 0.001), rel=2e-3)
    assert len(scan.h) < 2 * len(plain)


def test_where_slopes_do_not_reach_1_nothing_is_halved() -> None:
    """Between radii 2 and 2.2 the slope would have to be more than four times the one beside."""
    h = np.array([1.0, 1.1, 1.2])
    assert len(doubtful(h, np.array([2.0, 2.2, 2.4]), np.ones(3))) == 0
    assert len(doubtful(h, 1.0 + np.array([0.5, 1.0, 1.5]) / (4.0 * STEEPER), np.ones(3))) > 0
    assert len(doubtful(h, np.array([np.inf, 0.0, np.nan]), np.array([1, -1, 0]))) == 0
