"""The strong error of Euler's method on the delayed martingale, derived here and sampled.

With x = 1 + d W up to tau and x = 1 before 0, the error at a time t_N up to 2 tau is

    x(t_N) - x_N = d sum_n int_{t_n}^{t_{n+1}} [x(s - tau) - x(t_n - tau)] dW(s),    tau = m h,

whose second moment is d^2 sum_n int E [.]^2 ds by Ito's isometry. For t_n >= tau the integrand is d^2 (s - t_n): a
step adds d^4 h^2/2, and all of them up to 2 tau d^4 h tau/2.
"""

import numpy as np
import pytest

from facade import StochasticTheta, Track, delay_martingale
from sdaeverify import Array
from sdaeverify.studying import Brownian, Source

D, PATHS, FINEST = 0.8, 4000, 6


def squares(h: float, steps: int) -> Array:
    """Return the squared differences to steps that are 2^6 times finer, on many paths."""
    problem = delay_martingale(D)
    tracks = {level: Track(StochasticTheta(0.0), problem, level, h / 2**level, PATHS) for level in (0, FINEST)}
    noise = Brownian(Source(6, "martingale", steps, PATHS), 1, h, FINEST).steps()
    for levels, _ in zip(noise, range(steps), strict=False):
        for level, track in tracks.items():
            track.advance(levels[level], ())
    coarse, fine = (track.parts()["x"][0] for track in tracks.values())
    return np.asarray((coarse - fine) ** 2)


@pytest.mark.parametrize("steps", [4, 8])
def test_the_error_is_the_closed_form(steps: int) -> None:
    """It is d^4 h tau/2 at 2 tau within four standard errors, and twice that, or without a d^2, is refuted.

    The finer path's own error is a martingale integral over what the difference does not hold: its second moment,
    1/64 of that of the coarse one, is that of the difference less.
    """
    h = 2.0 / steps
    expected, values = D**4 * h * (1.0 - 0.5**FINEST) / 2.0, squares(h, steps)

    off = np.abs(values.mean() - expected * np.array([1.0, 2.0, 1.0 / D**2])) / (values.std() / np.sqrt(PATHS))
    assert (off > 4.0).tolist() == [False, True, True]
