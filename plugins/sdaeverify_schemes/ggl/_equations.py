"""The equations of an implicit Euler step in GGL form."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, HolonomicSDAE


class Unknowns(NamedTuple):
    """Unknowns of a step of size h from (r_0, v_0).

    Attributes
    ----------
    xi, v : ndarray, shape (n, P)
        Displacement r - r_0, because r itself loses the last digits of h v; and new velocity.
    lam, nu : ndarray, shape (m, P)
        Multipliers h lambda and h nu.
    """

    xi: Array
    v: Array
    lam: Array
    nu: Array

    def moved(self, s: Array | float, update: "Unknowns") -> "Unknowns":
        """Return the unknowns plus s times an update, s of shape (P,)."""
        return Unknowns(*(part + s * change for part, change in zip(self, update, strict=True)))


class Defects(NamedTuple):
    """Residuals of the four equations.

    Attributes
    ----------
    position, velocity : ndarray, shape (n, P)
    constraint, hidden : ndarray, shape (m, P)
    shift, moving, pulling, kicking : ndarray, shape (n, P)
        M^{-1} times grad g h nu, h a, grad g h lambda and B dw, the terms that cancel in the first two residuals.
    square : ndarray, shape (P,)
        Squared norm |F|^2.
    """

    position: Array
    velocity: Array
    constraint: Array
    hidden: Array
    shift: Array
    moving: Array
    pulling: Array
    kicking: Array
    square: Array

    @property
    def parts(self) -> tuple[Array, ...]:
        """Residuals of each equation, those of the constraint first."""
        return self.constraint, self.hidden, self.position, self.velocity


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
        Old position r_0, old velocity v_0 and noise B dw.
    """

    problem: HolonomicSDAE
    t: float
    h: float
    r: Array
    v: Array
    kick: Array

    def of(self, paths: Array) -> "Equations":
        """Return the equations of a subset of the paths."""
        return self._replace(r=self.r[:, paths], v=self.v[:, paths], kick=self.kick[:, paths])

    def defects(self, x: Unknowns) -> Defects:
        """Return the four residuals of a step at values of its unknowns, their sum of squares, and the terms in them.

        The residuals are those of positions, of velocities, of the constraint g(r) = 0 and of J(r) v = 0 at the new
        positions r.
        """
        problem, r = self.problem, self.r + x.xi
        J = problem.linearised(r)
        shift = problem.push(J, x.nu)
        # The force may be a single vector for all paths.
        force = np.multiply(self.h, problem.force(self.t, r, x.v), out=np.empty_like(r))
        forces = (force, J.transposed(x.lam), self.kick)
        moving, pulling, kicking = (problem.inverse_mass(each) for each in forces)
        parts = (
            x.xi - self.h * x.v - shift,
            x.v - self.v - (moving + pulling + kicking),
            problem.constraint(r),
            J.times(x.v),
        )
        F = np.concatenate(parts)
        return Defects(*parts, shift, moving, pulling, kicking, np.add.reduce(F * F))
