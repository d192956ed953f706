"""Forces and noise of the semi-discrete inextensible fibre in a turbulent flow, Lindner et al. (2018), (2.8)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, ParameterError

from .._arguments import function, instance, number
from ._chain import Chain


class Edges(NamedTuple):
    """Values on the edges i - 1/2 of a chain, including those beyond a free end.

    Attributes
    ----------
    r, v, tau : ndarray, shape (d, edges, P)
        Mean position and velocity of both adjacent points, and d_s r = (r_i - r_{i-1})/ds.
    """

    r: Array
    v: Array
    tau: Array


Flow = Callable[[Array, float], Array]


def rotation(strength: float) -> Flow:
    """Return the flow u(x, t) = strength (x_2, -x_1), or (x_2, -x_1, 0)."""

    def u(x: Array, t: float) -> Array:
        return strength * np.stack([x[1], -x[0], *(0.0 * x[2:])])

    return u


# Flow of section 4.2.
ROTATION = rotation(1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fibre:
    """Forces on the points of a chain, computed by fluxes and sources on its edges in O(N) operations per path.

    With f = Fr^{-2} e_g + Dr^{-2} C (u(r, t) - v) and A = Dr^{-2} beta C D on edges, e_g = -e_2, point i has

        a_i = -alpha^{-2} ds^{-4} (r_{i+2} - 4 r_{i+1} + 6 r_i - 4 r_{i-1} + r_{i-2}) + (f_{i+1/2} + f_{i-1/2})/2,
        (B dw)_i = ds^{-1/2} (A_{i+1/2} + A_{i-1/2})/2 dw_i.

    u, C and D take and return arrays whose last axes are edges and paths; returned arrays may have length 1 along an
    axis on which they do not depend. They must be analytic, because the force is differentiated by complex steps.

    Attributes
    ----------
    chain : Chain
    alpha : float
        Bending number, positive; small values mean a stiff fibre. The defaults are the values of section 4.2.
    Fr, Dr : float
        Froude and drag number, positive; an infinite Fr means no gravity.
    beta : float
        Strength of the turbulence, not negative.
    flow : callable, (r, t) -> ndarray, shape (d, edges, P)
        The flow u.
    C : callable, (r, tau, t) -> ndarray, shape (d, d, edges, P), optional
        The identity if left out.
    D : callable, (r, v, tau, t) -> ndarray, shape (d, d, edges, P), optional
        The identity if left out.

    Raises
    ------
    ParameterError
        If alpha, Fr or Dr are not positive, beta is negative, or an argument has a wrong type.
    """

    chain: Chain
    alpha: float = 0.4
    Fr: float = 3.0
    Dr: float = 0.1
    beta: float = 0.1
    flow: Flow = ROTATION
    C: Callable[[Array, Array, float], Array] | None = None
    D: Callable[[Array, Array, Array, float], Array] | None = None

    def __post_init__(self) -> None:
        # Fr may be infinite, which means no gravity.
        instance("chain", self.chain, Chain)
        for name, most in (("alpha", 1e100), ("Fr", np.inf), ("Dr", 1e100)):
            if not 1e-100 < number(name, getattr(self, name)) <= most:
                what = "positive" if most == np.inf else "positive and finite"
                raise ParameterError(f"{name} must be {what}, got {getattr(self, name)!r}")
        if not 0.0 <= number("beta", self.beta) < np.inf:
            raise ParameterError(f"beta must be finite and not negative, got {self.beta!r}")
        for name in ("flow", "C", "D"):
            if name == "flow" or getattr(self, name) is not None:
                function(name, getattr(self, name))

    def edges(self, x: Array, y: Array) -> Edges:
        """Return the edge values, given x = positions(r) and y = velocities(v) of the chain."""
        means, tau = (0.5 * (z[1:] + z[:-1]) for z in (x, y)), (x[1:] - x[:-1]) / self.chain.ds
        return Edges(*(np.moveaxis(z, 1, 0) for z in (*means, tau)))

    def force(self, t: float, r: Array, v: Array) -> Array:
        """Return the acceleration a, shape (n, P)."""
        x, y = self.chain.positions(r), self.chain.velocities(v)
        bends = self.chain.bends(x)
        third = bends[1:] - bends[:-1]
        drag = self._drag(t, x, y)
        a = (third[1:] - third[:-1]) * (-(self.alpha**-2) / self.chain.ds**4)
        a = a + (drag[1:] + drag[:-1]) * (0.5 / self.Dr**2)
        a[:, 1] -= self.Fr**-2
        return a.reshape(-1, a.shape[-1])

    def _drag(self, t: float, x: Array, y: Array) -> Array:
        # Drag C (u - v) with edges on the first axis.
        if self.C is None:
            u = self.flow(np.moveaxis(0.5 * (x[1:] + x[:-1]), 1, 0), t)
            return np.moveaxis(u, 0, 1) - 0.5 * (y[1:] + y[:-1])
        r, v, tau = self.edges(x, y)
        return np.einsum("abep,bep->eap", self.C(r, tau, t), self.flow(r, t) - v)
