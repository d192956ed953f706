"""Observables of a fibre: its energy, and the speed of its tip."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Array, Parts

from ..spheres._unit_sphere import squared_norm
from ._fibre import Fibre

Observable = Callable[[float, Parts], Array]


def observables(fibre: Fibre) -> dict[str, Observable]:
    """Return the squared speed of the tip, and energies.

    Parameters
    ----------
    fibre : Fibre

    Returns
    -------
    dict of str to callable
        ``tip speed^2`` = |v_N|^2, ``kinetic`` = (ds/2) sum |v_i|^2, and ``energy``, which adds `potential`. Positions
        are omitted, because detecting their weak errors takes ten times as many paths.
    """

    def kinetic(t: float, s: Parts) -> Array:
        return squared_norm(s["v"]) * (0.5 * fibre.chain.ds)

    return {
        "tip speed^2": lambda t, s: squared_norm(s["v"][-fibre.chain.d :]),
        "kinetic": kinetic,
        "energy": lambda t, s: kinetic(t, s) + potential(fibre, s["r"]),
    }


def potential(fibre: Fibre, r: Array) -> Array:
    """Return the energy of bending and gravity, shape (P,).

    The energy is alpha^{-2} ds^{-3} sum |r_{i+1} - 2 r_i + r_{i-1}|^2/2 + ds Fr^{-2} sum <r_i, e_2>; its negative
    gradient is ds times the force on points without drag.
    """
    chain = fibre.chain
    bends = chain.bends(chain.positions(r))
    bending = 0.5 / (fibre.alpha**2 * chain.ds**3) * np.einsum("idp,idp->p", bends, bends)
    energy: Array = bending + chain.ds / fibre.Fr**2 * chain.points(r)[:, 1].sum(axis=0)
    return energy
