"""The damped pendulum in its angle: Langevin dynamics without constraint."""

import numpy as np

from sdaeverify import Angle, Array, Chart, Increment, Langevin, Line, MomentEquation, Parts, hookimpl

from .. import _controls as controls
from .._known import limits, monomials, solution
from ._rotor import damped_rotor

OBSERVABLES = {
    "cos q": lambda t, s: np.cos(s["q"][0]),
    "sin q": lambda t, s: np.sin(s["q"][0]),
    "cos^2 q": lambda t, s: np.cos(s["q"][0]) ** 2,
    **monomials("p", "p^2"),
    "p sin q": lambda t, s: s["p"][0] * np.sin(s["q"][0]),
}


def angle_pendulum(
    c: float = 1.0, gamma: float = 0.5, sigma: float = 0.7, q_0: float = 1.0, horizon: float = 1.0
) -> Langevin:
    """Langevin dynamics of an angle: dq = p dt, dp = (-c sin q - gamma p) dt + sigma dW, p = 0 at the start.

    The invariant density is ~ exp((c cos q - p^2/2)/kT) with kT = sigma^2/(2 gamma).

    Parameters
    ----------
    c : float
        Gravity, unit 1/time^2.
    gamma : float
        Friction, unit 1/time, positive.
    sigma : float
        Noise amplitude, unit 1/time^(3/2), positive.
    q_0 : float
        Initial angle from the lowest point, radian.
    horizon : float
        Final time.

    Source
    ------
    Pavliotis (2014), Stochastic Processes and Applications, section 6.1, (6.1).
    """
    rotor = damped_rotor(c, gamma, sigma)
    cosine, square = rotor.cosines()
    means = {"cos q": cosine, "sin q": 0.0, "cos^2 q": square, "p": 0.0, "p^2": rotor.kT, "p sin q": 0.0}

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        return rotor.taylor(x, h, noise.dW[0], noise.time_integral(h)[0])

    def parts_of(t: float, x: Array) -> Parts:
        return {"q": x[:1], "p": x[1:]}

    pathwise = solution([q_0, 0.0], advance, "order 3/2 Ito-Taylor step", parts=parts_of, order=1.5)
    return Langevin(
        controls=controls.STATIONARY,
        force=lambda q: -c * np.sin(q),
        friction=gamma,
        strength=sigma,
        position=[q_0],
        momentum=[0.0],
        horizon=horizon,
        observables=OBSERVABLES,
        truths=(
            pathwise,
            *limits(means, "von Mises law"),
            MomentEquation(observable="p sin q", source="virial theorem"),
        ),
        chart=Chart(axes=(Angle(), Line(0.0, np.sqrt(rotor.kT))), embed=lambda z: z, read=lambda x: x),
        relaxation_time=rotor.relaxation,
        units="mass and length 1, time in units of 1/sqrt(c)",
        source="Pavliotis 2014, section 6.1",
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [angle_pendulum]
