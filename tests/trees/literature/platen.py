"""Platen's explicit strong schemes: Kloeden & Platen (1992), (11.1.3) and (11.2.1), with time as a component."""

from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step

from .scalar import own_noise


class PlatenTableau(NamedTuple):
    """Places of the supporting values, weights of the drift, weights of the noise's differences.

    The supporting values are u = x + p_1 h f +- p_2 sqrt(h) b and v = u_+ +- p_3 sqrt(h) b(u_+).
    """

    places: Array
    drift: Array
    noise: Array


class Platen1(Scheme):
    """x+ = x + f h + b dW + w [b(u_+) - b] (dW^2 - h)/sqrt(h)."""

    name: ClassVar[str] = "platen-strong-1"
    form: ClassVar[type] = SDE
    source: ClassVar[str] = "Kloeden & Platen 1992, (11.1.3)"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, source="Kloeden & Platen 1992, section 11.1"),
    )
    tableau: ClassVar[PlatenTableau] = PlatenTableau(np.array([1.0, 1.0]), np.array([1.0]), np.array([1 / 2]))

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is neither scalar nor diagonal."""
        separate = problem.traits & {"scalar-noise", "diagonal-noise"}
        return "" if separate else "the noise is neither scalar nor diagonal"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        (along, across), (of_f,), (weight,) = self.tableau
        x, s, f, b = state, np.sqrt(h), problem.drift(t, state), own_noise(problem, t, state)
        up = own_noise(problem, t + along * h, x + along * h * f + across * s * b)
        return Step(x + of_f * h * f + b * noise.dW + weight * (up - b) * (noise.dW**2 - h) / s)


class Platen15(Scheme):
    """The scheme of strong order 3/2 for one Brownian motion.

    x+ = x + h [w_1 f(u_+) + w_2 f + w_3 f(u_-)] + w_4 [f(u_+) - f(u_-)] Z/sqrt(h) + b dW
           + w_5 [b(u_+) - b(u_-)] (dW^2 - h)/sqrt(h) + w_6 [b(u_+) - 2 b + b(u_-)] (h dW - Z)/h
           + w_7 [b(v_+) - b(v_-) - b(u_+) + b(u_-)] (dW^2/3 - h) dW/h.
    """

    name: ClassVar[str] = "platen-strong-1.5"
    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    source: ClassVar[str] = "Kloeden & Platen 1992, (11.2.1)"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.5, source="Kloeden & Platen 1992, section 11.2"),
    )
    tableau: ClassVar[PlatenTableau] = PlatenTableau(
        places=np.array([1.0, 1.0, 1.0]),
        drift=np.array([1 / 4, 1 / 2, 1 / 4, 1 / 2]),
        noise=np.array([1 / 4, 1 / 2, 1 / 4]),
    )

    def refuses(self, problem: SDE) -> str:
        """Refuse more than one Brownian motion."""
        return "" if problem.noise_dim == 1 else "there is more than one Brownian motion"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        (along, p_2, p_3), (w_1, w_2, w_3, w_4), (w_5, w_6, w_7) = self.tableau
        x, s, dW, Z, late = state, np.sqrt(h), noise.dW, noise.time_integral(h), t + along * h
        f, b = problem.drift(t, x), own_noise(problem, t, x)
        up, down = (x + along * h * f + sign * p_2 * s * b for sign in (1.0, -1.0))
        f_up, f_down = problem.drift(late, up), problem.drift(late, down)
        b_up, b_down = own_noise(problem, late, up), own_noise(problem, late, down)
        v_up, v_down = (own_noise(problem, late, up + sign * p_3 * s * b_up) for sign in (1.0, -1.0))
        drift = h * (w_1 * f_up + w_2 * f + w_3 * f_down) + w_4 * (f_up - f_down) * Z / s
        kick = b * dW + w_5 * (b_up - b_down) * (dW**2 - h) / s + w_6 * (b_up - 2.0 * b + b_down) * (dW - Z / h)
        third = w_7 * (v_up - v_down - b_up + b_down) * (dW**2 / 3.0 - h) * dW / h
        return Step(x + drift + kick + third)


SCHEMES = (Platen1(), Platen15())
