"""A particle with friction and noise in a double well: underdamped Langevin dynamics whose law is not normal."""

import numpy as np

from sdaeverify import Array, Chart, Increment, Langevin, Line, MomentEquation, ParameterError, Parts, hookimpl

from .. import _controls as controls
from .._arguments import check_positive
from .._known import limits, monomials, solution

OBSERVABLES = {**monomials("q", "q^2", "q p", "p^2"), "cos q": lambda t, s: np.cos(s["q"][0])}
# Largest m^2/kT, at which the force has a slope of 2 on the hill between the wells.
STEEPEST = 3.0


def double_well_langevin(
    m: float = 1.0, gamma: float = 1.0, kT: float = 0.5, q_0: float = 0.5, horizon: float = 1.0
) -> Langevin:
    """Langevin dynamics in a double well: dq = p dt, dp = (-q + m tanh(m q/kT) - gamma p) dt + sigma dW, p(0) = 0.

    The potential is q^2/2 - kT log cosh(m q/kT), and sigma^2 = 2 gamma kT. Under the invariant law q is a mixture of
    two normal laws with means -m and m and variance kT, with two maxima if m^2 > kT; p is normal, of variance kT.
    The force is globally Lipschitz, so that moments of explicit schemes are bounded.

    Parameters
    ----------
    m : float
        Distance of the two means from 0; m^2 is at most 3 kT, because transitions between the wells are rare above.
    gamma : float
        Friction, unit 1/time, positive.
    kT : float
        Temperature times Boltzmann's constant, positive.
    q_0 : float
        Initial position.
    horizon : float
        Final time.

    Source
    ------
    Pavliotis (2014), Stochastic Processes and Applications, section 6.1, (6.1).
    """
    check_positive(gamma=gamma, kT=kT)
    steep = m * m / kT
    if not 0.0 <= steep <= STEEPEST:
        raise ParameterError(f"m^2/kT must be at most {STEEPEST:g}, got {steep:g}")
    sigma = float(np.sqrt(2.0 * gamma * kT))
    means = {"q": 0.0, "q^2": kT + m * m, "cos q": float(np.exp(-0.5 * kT) * np.cos(m)), "q p": 0.0, "p^2": kT}

    def force(q: Array) -> Array:
        return np.asarray(m * np.tanh(m / kT * q) - q)

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        """Return (q, p) after one Ito-Taylor step of strong order 3/2."""
        q, p = x
        dW, integral = noise.dW[0], noise.time_integral(h)[0]
        a, slope = force(q) - gamma * p, steep * (1.0 - np.tanh(m / kT * q) ** 2) - 1.0
        moved = q + p * h + 0.5 * a * h**2 + sigma * integral
        return np.stack([moved, p + a * h + sigma * (dW - gamma * integral) + 0.5 * h**2 * (slope * p - gamma * a)])

    def parts_of(t: float, x: Array) -> Parts:
        return {"q": x[:1], "p": x[1:]}

    return Langevin(
        controls=controls.STATIONARY,
        force=force,
        friction=gamma,
        strength=sigma,
        position=[q_0],
        momentum=[0.0],
        horizon=horizon,
        observables=OBSERVABLES,
        truths=(
            solution([q_0, 0.0], advance, "order 3/2 Ito-Taylor step", parts=parts_of, order=1.5),
            *limits(means, "mixture of two normal laws"),
            MomentEquation(observable="q p", source="virial theorem"),
        ),
        # The width of each of the two laws of q, and of that of p.
        chart=Chart(axes=(Line(0.0, float(np.sqrt(kT))),) * 2, embed=lambda z: z, read=lambda x: x),
        # The first term estimates the motion at small friction. The second one is that of the overdamped equation,
        # whose gap is at most kT/E q^2 by its Rayleigh quotient with the function q.
        relaxation_time=2.0 / gamma + gamma * (1.0 + steep),
        units="mass 1, time in units of the inverse frequency far from the wells",
        source="Pavliotis 2014, section 6.1",
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [double_well_langevin]
