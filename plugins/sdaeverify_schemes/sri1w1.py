"""Roessler's stochastic Runge-Kutta scheme SRI1W1 of strong order 3/2 for scalar and for diagonal noise."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl

from ._senses import by_growth
from ._small_steps import STABLE


class SRI1W1(Scheme):
    """Four evaluations of the diffusion b, two of the drift f, and Z = int_t^{t+h} (W(s) - W(t)) ds.

    With s = sqrt(h), f and b_1 at (t, x), and componentwise for diagonal noise,

        b_2 = b(t + h/4, x + (h/4) f + (s/2) b_1),
        b_3 = b(t + h,   x + h f - s b_1),
        b_4 = b(t + h/4, x + (h/4) f + s (-5 b_1 + 3 b_2 + b_3/2)),
        y   = x + (3/4) h f + (3/2) b_1 Z/h,
        x+  = x + (h/3) [f + 2 f(t + 3h/4, y)]
                + (-b_1 + (4/3) b_2 + (2/3) b_3) dW + (-b_1 + (4/3) b_2 - (1/3) b_3) (dW^2 - h)/(2 s)
                + (2 b_1 - (4/3) b_2 - (2/3) b_3) Z/h
                + (-2 b_1 + (5/3) b_2 - (2/3) b_3 + b_4) (dW^3 - 3 h dW)/(6 h).
    """

    name: ClassVar[str] = "sri1w1"
    form: ClassVar[type[SDE]] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    claims: ClassVar[tuple[Claim, ...]] = (
        *by_growth(
            Claim(measure="strong", value=1.5, source="Roessler 2010, section 6"),
            Claim(measure="weak", value=1.5, source="at least the strong order"),
        ),
        Claim(measure="drift", value=1.5, source="no projection; at least the strong order, g being Lipschitz"),
        STABLE,
    )
    source: ClassVar[str] = "Roessler 2010, section 6, SRI1W1"

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that needs iterated integrals of several Brownian motions."""
        if problem.traits & {"scalar-noise", "diagonal-noise"}:
            return ""
        return f"noise in {problem.noise_dim} dimensions is neither scalar nor diagonal"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x, dW, mean, f = state, noise.dW, noise.time_integral(h) / h, problem.drift(t, state)
        b_1, once, twice, thrice = stages(problem, x, t, h, f)
        later = problem.drift(t + 0.75 * h, x + 0.75 * h * f + 1.5 * mean * b_1)
        kick = once * dW + (b_1 - once) * mean + twice * (dW**2 - h) / (2.0 * np.sqrt(h))
        return Step(x + h / 3.0 * (f + 2.0 * later) + kick + thrice * (dW * dW * dW - 3.0 * h * dW) / (6.0 * h))


def stages(problem: SDE, x: Array, t: float, h: float, f: Array) -> tuple[Array, Array, Array, Array]:
    """Return b_1 and the combinations that multiply dW, (dW^2 - h)/(2 s) and (dW^3 - 3 h dW)/(6 h), shape (d, P).

    Parameters
    ----------
    problem : SDE
    x : ndarray, shape (d, P)
    t, h : float
        Start and size of the step.
    f : ndarray, shape (d, P)
        Drift at the start of the step.
    """
    s, b_1 = np.sqrt(h), own_noise(problem, t, x)
    b_2 = own_noise(problem, t + 0.25 * h, x + 0.25 * h * f + 0.5 * s * b_1)
    b_3 = own_noise(problem, t + h, x + h * f - s * b_1)
    b_4 = own_noise(problem, t + 0.25 * h, x + 0.25 * h * f + s * (-5.0 * b_1 + 3.0 * b_2 + 0.5 * b_3))
    once, twice = (4.0 * b_2 + 2.0 * b_3) / 3.0 - b_1, (4.0 * b_2 - b_3) / 3.0 - b_1
    return b_1, once, twice, (5.0 * b_2 - 2.0 * b_3) / 3.0 - 2.0 * b_1 + b_4


def own_noise(problem: SDE, t: float, x: Array) -> Array:
    """Return the single column of scalar noise, or the diagonal of diagonal noise, shape (d, P) or (d, 1).

    Parameters
    ----------
    problem : SDE
        Problem with scalar or diagonal noise.
    t : float
    x : ndarray, shape (d, P)
    """
    B = problem.diffusion(t, x)
    return np.asarray(B[:, 0] if problem.noise_dim == 1 else np.einsum("jjp->jp", B))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [SRI1W1()]
