"""The strong error of Euler's method on the delayed martingale, derived here and sampled.

With x = 1 + d W up to tau and x = 1 before 0, the error at a time t_N up to 2 tau is

    x(t_N) - x_N = d sum_n int_{t_n}^{t_{n+1}} [x(s - tau) - xb_n] dW(s),

whose second moment is d^2 sum_n int E [x(s - tau) - xb_n]^2 ds by Ito's isometry. For tau = m h and t_n >= tau,
xb_n = x(t_n - tau): the integrand is d^2 (s - t_n), a step adds d^4 h^2/2, and all of them d^4 h (t_N - tau)/2. For
tau = (m - delta) h, xb_n = delta x_{n-m+1} + (1 - delta) x_{n-m}: with p = s - tau - t_{n-m} the difference is
W(p) - delta W(h), whose variance is p - 2 delta min(p, h) + delta^2 h; over delta h <= p <= (1 + delta) h, a step
adds d^4 h^2 (1/2 - delta^2 + delta^3). In the step in which tau lies, xb_n = 1, and the time r behind tau adds
d^4 r^2/2.
"""

import numpy as np
import pytest

from facade import StochasticTheta, Track, delay_martingale
from sdaeverify import Array, DelaySDAE, Mesh
from sdaeverify.probing import Source, brownian_steps

D, PATHS, FINEST = 0.8, 4000, 6


def mean_square(h: float, tau: float, steps: int) -> float:
    """Return E (x_N - x(t_N))^2 where t_N is in [tau, 2 tau]."""
    m, delta = Mesh.of(tau, h)
    straddling = (m * h - tau) ** 2 / 2.0
    return D**4 * (straddling + (steps - m) * h**2 * (0.5 - delta**2 + delta**3))


def squares(problem: DelaySDAE, h: float, steps: int) -> Array:
    """Return the squared differences to steps that are 2^6 times finer, on many paths.

    The finer path's own error is a martingale integral over what the difference does not hold: its second moment,
    1/64 of that of the coarse one on constrained meshes, is that of the difference less.
    """
    tracks = {level: Track(StochasticTheta(0.0), problem, level, h / 2**level, PATHS) for level in (0, FINEST)}
    noise = brownian_steps(Source(6, "martingale", steps, PATHS), 1, h, FINEST)
    for levels, _ in zip(noise, range(steps), strict=False):
        for level, track in tracks.items():
            track.advance(levels[level], ())
    coarse, fine = (track.parts()["x"][0] for track in tracks.values())
    return np.asarray((coarse - fine) ** 2)


def off(values: Array, expected: float) -> float:
    """Return how many standard errors the mean of a sample is off."""
    return float(abs(values.mean() - expected) / (values.std() / np.sqrt(len(values))))


@pytest.mark.parametrize("steps", [4, 8, 16])
def test_the_error_is_the_closed_form(steps: int) -> None:
    """It is d^4 h tau/2 at 2 tau within four standard errors, and twice that, or without a d^2, is refuted."""
    h = 2.0 / steps
    assert mean_square(h, 1.0, steps) == pytest.approx(D**4 * h / 2.0)
    expected = mean_square(h, 1.0, steps) - mean_square(h / 2**FINEST, 1.0, steps * 2**FINEST)
    values = squares(delay_martingale(D), h, steps)

    assert off(values, expected) <= 4.0
    assert off(values, 2.0 * expected) > 4.0
    assert off(values, expected / D**2) > 4.0
