"""The equations of an implicit Euler step in GGL form."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, HolonomicSDAE
from sdaeverify.numerics import largest


class Unknowns(NamedTuple):
    """What a step of size h from (r_0, v_0) asks for.

    Attributes
    ----------
    xi, v : ndarray, shape (n, P)
        Displacement r - r_0, as r itself has lost the last digits of h v; new velocity.
    lam, nu : ndarray, shape (m, P)
        h lambda and h nu.
    """

    xi: Array
    v: Array
    lam: Array
    nu: Array

    def moved(self, s: Array, update: "Unknowns") -> "Unknowns":
        """Return the point s of the way along an update, s of shape (P,)."""
        return Unknowns(*(part + s * change for part, change in zip(self, update, strict=True)))


class Defects(NamedTuple):
    """What is left of the four equations.

    Attributes
    ----------
    position, velocity : ndarray, shape (n, P)
    constraint, hidden : ndarray, shape (m, P)
    terms : ndarray, shape (4, P)
        Size of known and of added terms in each equation.
    """

    position: Array
    velocity: Array
    constraint: Array
    hidden: Array
    terms: Array

    @property
    def parts(self) -> tuple[Array, ...]:
        """What is left of each equation."""
        return self[:4]

    @property
    def largest(self) -> Array:
        """Largest component of each equation, shape (4, P)."""
        return np.stack([largest(part) for part in self.parts])

    @property
    def square(self) -> Array:
        """|F|^2, shape (P,)."""
        return np.asarray(sum((part * part).sum(axis=0) for part in self.parts))


class Equations(NamedTuple):
    """An implicit Euler step in GGL form, with r = r_0 + xi and B dw at the old time and state.

        xi - h v - M^{-1} grad g(r) h nu = 0
        v - v_0 - M^{-1} { h a(t, r, v) + grad g(r) h lambda + B dw } = 0
        g(r) = 0,   Dg(r) v = 0

    Attributes
    ----------
    problem : HolonomicSDAE
    t, h : float
        New time and step size.
    r, v, kick : ndarray, shape (n, P)
        r_0, v_0 and B dw.
    """

    problem: HolonomicSDAE
    t: float
    h: float
    r: Array
    v: Array
    kick: Array

    def of(self, paths: Array) -> "Equations":
        """Return those of some paths."""
        return self._replace(r=self.r[:, paths], v=self.v[:, paths], kick=self.kick[:, paths])

    def defects(self, x: Unknowns) -> Defects:
        """Return what is left of the equations at some point."""
        problem, r = self.problem, self.r + x.xi
        J = problem.linearised(r)
        shift = problem.push(J, x.nu)
        forces = (self.h * problem.force(self.t, r, x.v), J.transposed(x.lam), self.kick)
        pushed = [problem.inverse_mass(force) for force in forces]
        added = largest(self.v) + sum(largest(part) for part in pushed)
        terms = (largest(x.xi) + largest(shift), added, np.zeros_like(added), np.zeros_like(added))
        return Defects(
            position=x.xi - self.h * x.v - shift,
            velocity=x.v - self.v - sum(pushed),
            constraint=problem.constraint(r),
            hidden=J.times(x.v),
            terms=np.stack(terms),
        )
