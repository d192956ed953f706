"""SRI1W1 against the Ito-Taylor expansion of strong order 3/2, written out by hand."""

from collections.abc import Callable

import numpy as np
import pytest

from sdaeverify import SDE, Increment, verify
from sdaeverify.arrays import Array
from sdaeverify_planted.sri1w1 import WithoutTripleIntegral
from sdaeverify_problems.growing_volatility import growing_volatility
from sdaeverify_problems.hyperbolic import hyperbolic
from sdaeverify_schemes.sri1w1 import SRI1W1

NODES = np.random.default_rng(3).standard_normal((2, 1, 200))


def taylor(x: Array, h: float, noise: Increment, operators: dict[str, Array]) -> Array:
    """Return x + a h + b I_1 + L1b I_11 + L1a I_10 + L0b I_01 + L0a h^2/2 + L1L1b I_111: Kloeden & Platen 10.4.1."""
    dW, I10 = noise.dW, noise.time_integral(h)
    integrals = {
        "a": h,
        "b": dW,
        "L1b": 0.5 * (dW**2 - h),
        "L1a": I10,
        "L0b": h * dW - I10,
        "L0a": 0.5 * h * h,
        "L1L1b": (dW**3 - 3.0 * h * dW) / 6.0,
    }
    return np.asarray(x + sum(operators[name] * integral for name, integral in integrals.items()))


def on_growth(t: float, x: Array) -> dict[str, Array]:
    """Return the operators of dx = a x dt + b (1 + t) x dW with a = 1/2, b = 2/5."""
    a, b, slope = 0.5, 0.4 * (1.0 + t), 0.4
    return {
        "a": a * x,
        "b": b * x,
        "L1b": b**2 * x,
        "L1a": a * b * x,
        "L0b": (slope + a * b) * x,
        "L0a": a**2 * x,
        "L1L1b": b**3 * x,
    }


def on_the_hyperbolic_sine(t: float, x: Array) -> dict[str, Array]:
    """Return the operators of dx = (a r + b^2 x/2) dt + b r dW with r = sqrt(1 + x^2), a = 1/2, b = 3/5."""
    a, b, r = 0.5, 0.6, np.sqrt(1.0 + x * x)
    f, f1, f2 = a * r + 0.5 * b * b * x, a * x / r + 0.5 * b * b, a / r**3
    g, g1, g2 = b * r, b * x / r, b / r**3
    return {
        "a": f,
        "b": g,
        "L1b": g * g1,
        "L1a": g * f1,
        "L0b": f * g1 + 0.5 * g**2 * g2,
        "L0a": f * f1 + 0.5 * g**2 * f2,
        "L1L1b": g * (g1**2 + g * g2),
    }


@pytest.mark.parametrize(
    ("problem", "operators"), [(growing_volatility(), on_growth), (hyperbolic(), on_the_hyperbolic_sine)]
)
def test_a_step_is_the_ito_taylor_step_up_to_h_squared(
    problem: SDE, operators: Callable[[float, Array], dict[str, Array]]
) -> None:
    """The difference falls like h^2 at each noise, in units of its size: every term of the expansion is larger."""
    t, x = 0.3, np.full((1, NODES.shape[-1]), 0.7)

    def off(h: float) -> float:
        noise = Increment(np.sqrt(h) * NODES[0], np.sqrt(h / 12.0) * NODES[1])
        new = SRI1W1().step(problem, x, t, h, noise).state
        return float(np.sqrt(np.mean((new - taylor(x, h, noise, operators(t, x))) ** 2)))

    coarse, fine = off(2.0**-10), off(2.0**-14)

    assert np.log2(coarse / fine) / 4.0 == pytest.approx(2.0, abs=0.05)


SLOWER = [pytest.param(name, marks=pytest.mark.slow) for name in ("hyperbolic", "hyperbolic-pair")]


@pytest.mark.parametrize("problem", ["spiral", "growing-volatility", *SLOWER])
def test_strong_order_three_halves_is_verified_and_refuted(problem: str) -> None:
    """On problems with multiplicative noise and H, controls let 3/2 pass; without I_111 the order is 1."""
    found = verify([SRI1W1(), WithoutTripleIntegral()], problem, "strong", paths=256, looks=1).verdicts
    right = found["scheme"] == "sri1w1"

    assert set(found[right]["verdict"]) == {"verified"}
    assert set(found[~right]["verdict"]) == {"refuted"}
