"""The form M dv = a dt + B dw + grad g dmu, dr = v dt, g(r) = 0: constrained stochastic mechanics.

Symbols as in Lindner & Stroot (2017), section 2.1: positions r and velocities v in R^n, Brownian motion w
in R^l, constraint g : R^n -> R^m with Jacobian Dg (m x n) and grad g = Dg^T, multiplier mu in R^m, mu(0) = 0.
"""

from collections.abc import Callable, Collection, Mapping
from copy import copy
from dataclasses import dataclass
from functools import cached_property, partial
from typing import ClassVar, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array, Parts
from ...errors import ProblemError
from ...numerics.derivatives import directional, is_analytic, second_directional
from ...numerics.linalg import apply, norm
from ..chart import without_rows
from ..checks import (
    PROBES,
    check_analytic,
    check_derivative,
    check_known,
    check_product,
    check_shape,
    check_vanishes,
    columns,
    format_value,
    numbers,
    vector,
)
from ..features import Feature
from ..generic import GenericClass
from ..manifold import onto_manifold
from ..problem import Problem, Residual, briefly_signed
from ..sde.sde import SDE, zero_columns
from ..trivial import Trivials
from .generic import FEATURES, draw_mechanics
from .jacobian import ConstraintJacobian, DenseJacobian, check_linearisation
from .mistakes import MOTION_MISTAKES
from .motion_features import motion_features
from .multiplied import Mechanics, Multiplied
from .structure import Structure, Unstructured, check_structure
from .trivial_motions import trivial_motions

# Traits of noise that are lost when it is projected.
NOT_PROJECTED = {"additive-noise", "diagonal-noise", "commutative-noise"}
K = TypeVar("K")


class HolonomicState(NamedTuple):
    """State of a scheme that includes the multiplier.

    Attributes
    ----------
    r, v : ndarray, shape (n, P)
        Position and velocity.
    mu : ndarray, shape (m, P)
        Sum of the multiplier's increments.
    """

    r: Array
    v: Array
    mu: Array


@briefly_signed
@dataclass(frozen=True, kw_only=True, eq=False)
class HolonomicSDAE(Mechanics):
    """Mechanics with a holonomic constraint: dr = v dt, M dv = a dt + B dw + grad g(r) dmu, g(r) = 0 (Ito).

    Attributes
    ----------
    force : callable, (t, r, v) -> ndarray, shape (n, P) or (n, 1)
        a.
    diffusion : callable, (t, r, v) -> ndarray, shape (n, l, P) or (n, l, 1)
        B.
    constraint : callable, r -> ndarray, shape (m, P)
        g.
    position, velocity : array_like, shape (n,)
        Initial data, with g(r) = 0 and Dg(r) v = 0.
    mass : array_like, shape (n, n), optional
        M, symmetric positive definite; the identity if omitted. A diagonal entry may be infinite if all others of its
        row and column are 0: such a position moves at its initial velocity, whatever the force. With the
        velocity 1 it is the time, and g(r) a moving constraint.
    jacobian : callable, r -> ndarray, shape (m, n, P), optional
        Dg; by complex step if omitted, and g must then be analytic.
    curvature : callable, (r, y, z) -> ndarray, shape (m, P), optional
        D^2 g(r)(y, z); by complex step of Dg if omitted, and a given Dg must then be analytic.
    diffusion_product : callable, (t, r, v, w) -> ndarray, shape (n, P), optional
        B(t, r, v) w for w of shape (l, P), if it is cheaper than the product with the matrix.
    linearisation : callable, r -> ConstraintJacobian, optional
        Dg(r) with operations that exploit its structure, without a mass matrix; the dense matrix if omitted.
    force_derivatives : callable, (t, r, v) -> two of ndarray, shape (n, n, P) or (n, n, 1), optional
        Derivatives of a by r and by v; if omitted, by complex step where they are needed.
    structure : Structure, optional
        Coupling structure of the positions; all are coupled if omitted.
    constraint_bound : float, optional
        C_g of Lindner & Stroot (2.7), finite and at least 1.
    horizon, noise_dim, source, units, traits, noise, observables, truths
        As for any `Problem`.
    controls, chart, domain, relaxation_time, fastest_time
        As for any `Problem`, and seen_as, which only views set.

    Raises
    ------
    ProblemError
        If shapes, the mass matrix or the initial data are inconsistent, or if a derivative is neither given nor
        available by complex step.
    """

    force: Callable[[float, Array, Array], Array]
    diffusion: Callable[[float, Array, Array], Array]
    constraint: Callable[[Array], Array]
    position: ArrayLike
    velocity: ArrayLike
    mass: ArrayLike | None = None
    jacobian: Callable[[Array], Array] | None = None
    curvature: Callable[[Array, Array, Array], Array] | None = None
    diffusion_product: Callable[[float, Array, Array, Array], Array] | None = None
    linearisation: Callable[[Array], ConstraintJacobian] | None = None
    force_derivatives: Callable[[float, Array, Array], tuple[Array, Array]] | None = None
    structure: Structure | None = None
    constraint_bound: float | None = None

    # Whether mu is a component of the solution; False for schemes that give only r and v.
    _has_multiplier: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("position", "velocity"):
            object.__setattr__(self, name, vector(name, getattr(self, name)))
        _inverse_mass(self.mass, self.dimension)
        self._check_functions()
        self._check_start()

    @property
    def dimension(self) -> int:
        """Number n of positions."""
        return len(cast("Array", self.position))

    @property
    def constraints(self) -> int:
        """Number m of constraints."""
        return len(self.constraint(columns(cast("Array", self.position), 1)))

    @property
    def has_constraints(self) -> bool:
        """Whether there are constraints; always True."""
        return True

    def initial(self, paths: int) -> HolonomicState:
        """Return consistent initial data with mu = 0 on every path."""
        r, v = cast("Array", self.position), cast("Array", self.velocity)
        return HolonomicState(columns(r, paths), columns(v, paths), np.zeros((self.constraints, paths)))

    def parts(self, state: HolonomicState) -> Parts:
        """Return the named components of a state."""
        parts: Parts = state._asdict()
        return parts if self._has_multiplier else {name: part for name, part in parts.items() if name != "mu"}

    def giving(self, names: Collection[str]) -> "HolonomicSDAE":
        """Return the problem of r and v for schemes that give only these; mu is an output of such schemes."""
        return self._without_multiplier if {*names} == {"r", "v"} else self

    def capability(self, kind: type[K]) -> K | None:
        """Return the problem as a capability; it is `Multiplied` only if mu is a component."""
        return None if kind is Multiplied and not self._has_multiplier else super().capability(kind)

    def inverse_mass(self, y: Array) -> Array:
        """Return M^{-1} y for y of shape (n, P) or (n, l, P)."""
        return y if self._inverse is None else np.einsum("ij,j...->i...", self._inverse, y)

    def d2g(self, r: Array, y: Array, z: Array) -> Array:
        """Return D^2 g(r)(y, z), shape (m, P).

        Parameters
        ----------
        r : ndarray, shape (n, P)
        y, z : ndarray, shape (n, P)
            Directions.
        """
        if self.curvature is not None:
            return self.curvature(r, y, z)
        if self.jacobian is not None:
            return apply(directional(self.jacobian, r, z), y)
        return second_directional(self.constraint, r, y, z)

    def linearised(self, r: Array) -> ConstraintJacobian:
        """Return Dg(r) as an object with the operations that schemes need."""
        if self.linearisation is not None:
            return self.linearisation(r)
        return DenseJacobian(self.dg(r), self._inverse)

    def push(self, J: ConstraintJacobian, c: Array) -> Array:
        """Return M^{-1} grad g c, shape (n, P): the change of r or v by multipliers c of shape (m, P)."""
        return self.inverse_mass(J.transposed(c))

    def diffused(self, t: float, r: Array, v: Array, w: Array) -> Array:
        """Return B(t, r, v) w, shape (n, P), for w of shape (l, P).

        Parameters
        ----------
        t : float
        r, v : ndarray, shape (n, P)
            Positions and velocities.
        w : ndarray, shape (l, P)
        """
        if self.diffusion_product is not None:
            return self.diffusion_product(t, r, v, w)
        return apply(self.diffusion(t, r, v), w)

    def inherent_multiplier(self, J: ConstraintJacobian, r: Array, v: Array, impulse: Array) -> Array:
        """Return -G_M^{-1} { Dg M^{-1} impulse + D^2 g(v, v) }, shape (m, P): the integrand of (2.8); J at r.

        Parameters
        ----------
        J : ConstraintJacobian
            Dg at r, computed once.
        r, v : ndarray, shape (n, P)
        impulse : ndarray, shape (n, P) or (n, l, P)
            Force, or the columns of the noise, that the constraint force balances.
        """
        return -J.gram(J).solve(J.times(self.inverse_mass(impulse)) + self.d2g(r, v, v))

    def tangent(self, J: ConstraintJacobian, v: Array) -> tuple[Array, Array]:
        """Return Q v = v - M^{-1} grad g G_M^{-1} Dg v, and the multipliers of this projection; J at the position."""
        c = -J.gram(J).solve(J.times(v))
        return v + self.push(J, c), c

    @property
    def blocks(self) -> Structure:
        """The coupling structure; a single node of all positions if none is given."""
        return self.structure or Unstructured(nodes=1, owners=(0,) * self.constraints)

    def why_not_derivative_of_force(self) -> str:
        """Return why the force has no derivatives, from the author or by complex step, or an empty string."""
        n, x = self.dimension, np.concatenate(self.initial(1)[:2])
        known = self.force_derivatives is not None or self.blocks.differentiates_force
        if known or is_analytic(lambda z: self.force(0.0, z[:n], z[n:]), x):
            return ""
        text = "force is not analytic (abs or a real array?), so that its derivatives cannot be taken"
        return f"{text} by complex step; give force_derivatives"

    def residuals(self, parts: Parts) -> Mapping[str, Residual]:
        """Return the defects g(r) and Dg(r) v."""
        r, v = parts["r"], parts["v"]
        J = self.linearised(r)
        size = J.size()
        return {"g": Residual(self.constraint(r), size * norm(r)), "Dg v": Residual(J.times(v), size * norm(v))}

    def admissible(self, x: Array) -> Array:
        """Return states (r, v, mu) with g(r) = 0 and Dg(r) v = 0 near the columns of x."""
        r, v, mu = self.state(x)
        r = onto_manifold(self.constraint, self, r)
        return np.concatenate([r, self.tangent(self.linearised(r), v)[0], mu])[: len(x)]

    def view(self, form: type[Problem]) -> Problem | None:
        """Return the problem itself, or its inherent SDE (2.9) if an `SDE` is requested."""
        return self._sde if form is SDE else super().view(form)

    @classmethod
    def trivial_problems(cls) -> Trivials:
        """Return the problems that every scheme for the form solves exactly."""
        return trivial_motions(HolonomicSDAE)

    @classmethod
    def features(cls) -> tuple[Feature, ...]:
        """Return the features of the form: masses, several and curved constraints, and kinds of force and noise."""
        return motion_features()

    @classmethod
    def generic_classes(cls) -> tuple[GenericClass, ...]:
        """Return the class of all polynomial problems of the form with a full mass matrix."""
        return (GenericClass("HolonomicSDAE", partial(draw_mechanics, HolonomicSDAE), FEATURES, MOTION_MISTAKES),)

    def ito(self) -> SDE:
        """Return the inherent SDE of r, v and, if it is a component, mu."""
        return self._inherent if self._has_multiplier else self._sde

    def state(self, x: Array, t: float = 0.0) -> HolonomicState:  # noqa: ARG002 - the constraint knows no time
        """Return the state whose components r, v and mu are the rows of x; mu is 0 if it is not a component."""
        n = self.dimension
        mu = x[2 * n :] if self._has_multiplier else np.zeros((self.constraints, x.shape[1]))
        return HolonomicState(x[:n], x[n : 2 * n], mu)

    def multiplier_scales(self, t: float, x: Array, h: float) -> tuple[Array, Array]:
        """Return |G_M^{-1}| |Dg| times |r|, and times |v + h a + B w|."""
        (r, v, _), m = self.state(x), self.constraints
        J = self.linearised(r)
        identity = np.broadcast_to(np.eye(m)[..., None], (m, m, x.shape[1]))
        inverse = J.gram(J).solve(np.ascontiguousarray(identity)).reshape(-1, x.shape[1])
        a, B = self.inverse_mass(self.force(t, r, v)), self.inverse_mass(self.diffusion(t, r, v))
        moved = norm(v) + h * norm(a) + np.sqrt(h) * norm(B.reshape(-1, B.shape[-1]))
        size = norm(inverse) * J.size()
        return size * norm(r), size * moved

    @property
    def norm_parts(self) -> tuple[str, ...]:
        """Positions and velocities, without the multiplier."""
        return "r", "v"

    def own_diffusion(self, t: float, x: Array) -> Array:
        """Return B before projection."""
        return self.diffusion(t, x[: self.dimension], x[self.dimension : 2 * self.dimension])

    def squared_norm(self, parts: Parts) -> Array:
        """Return |r|^2 + |M^{1/2} v|^2."""
        r, v = parts["r"], parts["v"]
        M = None if self.mass is None else np.asarray(self.mass)
        Mv = v if M is None else np.einsum("ij,jp->ip", np.where(np.isinf(M), 0.0, M), v)
        return np.asarray((r * r).sum(axis=0) + (v * Mv).sum(axis=0))

    @property
    def free_rows(self) -> slice:
        """Rows of the velocities, which may be scaled because they stay tangent."""
        return slice(self.dimension, 2 * self.dimension)

    def _make_sde(self) -> SDE:
        return inherent_sde(self)

    @cached_property
    def _inherent(self) -> SDE:
        return inherent_sde(self, with_multiplier=True)

    @cached_property
    def _without_multiplier(self) -> "HolonomicSDAE":
        other = copy(self)
        object.__setattr__(other, "_has_multiplier", False)
        if self.chart is not None:
            object.__setattr__(other, "chart", without_rows(self.chart, self.constraints))
        return other

    @cached_property
    def _inverse(self) -> Array | None:
        return _inverse_mass(self.mass, self.dimension)

    def _check_functions(self) -> None:
        n, l, m = self.dimension, self.noise_dim, self.constraints
        r, v, _ = self.initial(PROBES)
        if v.shape != r.shape:
            raise ProblemError(f"velocity has {len(v)} components, position has {n}")
        if not 0 < m < n:
            raise ProblemError(f"constraint(r) has {m} components, expected between 1 and {n - 1}")
        check_shape("constraint(r)", self.constraint(r), (m, PROBES))
        check_shape("force(t, r, v)", self.force(0.0, r, v), (n, PROBES))
        check_shape("diffusion(t, r, v)", self.diffusion(0.0, r, v), (n, l, PROBES))
        self._check_complex_steps(r)
        check_shape("jacobian(r)", self.dg(r), (m, n, PROBES))
        check_shape("curvature(r, y, z)", self.d2g(r, v, v), (m, PROBES))
        self._check_derivatives(r)
        check_product(self, r, v)
        if self.linearisation is not None and self.mass is not None:
            raise ProblemError("linearisation cannot be combined with a mass matrix; leave one of the two out")
        if self.linearisation is not None:
            check_linearisation(self.linearisation(r), DenseJacobian(self.dg(r)), n, m)
        check_structure(self.blocks, self, r, v)
        check_known(self, self.initial(PROBES)._asdict())

    def _check_derivatives(self, r: Array) -> None:
        y = np.sin(np.arange(1.0, len(r) + 1))[:, None] + np.zeros_like(r)
        if self.jacobian is not None:
            check_derivative("jacobian", self.constraint, lambda x, z: apply(self.dg(x), z), r)
        if self.curvature is not None:
            check_derivative("curvature", lambda x: apply(self.dg(x), y), lambda x, z: self.d2g(x, y, z), r)

    def _check_complex_steps(self, r: Array) -> None:
        taken = ", so that {} cannot be taken by complex step; give {}"
        if self.jacobian is None:
            check_analytic("constraint", self.constraint, r, taken.format("Dg", "jacobian"))
        elif self.curvature is None:
            # A Jacobian written into a real buffer would be mistaken for one with zero derivative.
            check_analytic("jacobian", self.jacobian, r, taken.format("D^2 g", "curvature"))

    def _check_start(self) -> None:
        r, v, _ = self.initial(1)
        Dg = self.dg(r)
        if np.linalg.matrix_rank(Dg[..., 0]) < self.constraints:
            raise ProblemError(f"Dg does not have full rank at the initial position {r[:, 0].tolist()}")
        for name, (value, scale) in self.residuals({"r": r, "v": v}).items():
            check_vanishes("initial data violate", name, value, scale)
        if self.constraint_bound is not None and not 1.0 <= self.constraint_bound < np.inf:
            raise ProblemError(f"constraint_bound C_g must be finite and at least 1, got {self.constraint_bound!r}")


def _inverse_mass(mass: ArrayLike | None, n: int) -> Array | None:
    if mass is None:
        return None
    M, inverse = numbers(mass), np.zeros((n, n))
    # A position with infinite mass moves at its initial velocity, independent of forces: a clock.
    moved = np.ones(n, dtype=bool) if M is None or M.shape != (n, n) else ~np.isposinf(np.diag(M))
    if M is None or M.shape != (n, n) or not np.isfinite(M[moved][:, moved]).all() or not _is_uncoupled(M, ~moved):
        raise ProblemError(f"mass must be a finite matrix of shape ({n}, {n}), got {format_value(mass)}")
    if not moved.any():
        raise ProblemError(f"mass must be finite in at least one direction, got {M.tolist()}")
    M = M[moved][:, moved]
    if not np.allclose(M, M.T, rtol=0.0, atol=1e-14 * np.abs(M).max()):
        raise ProblemError(f"mass must be symmetric, got {M.tolist()}")
    eigenvalues = np.linalg.eigvalsh(M)
    if not eigenvalues[0] > n * np.finfo(float).eps * eigenvalues[-1]:
        text = "mass must be positive definite beyond rounding"
        raise ProblemError(f"{text}, its eigenvalues are {eigenvalues.tolist()}")
    inverse[np.ix_(moved, moved)] = np.linalg.inv(M)
    return inverse


def _is_uncoupled(M: Array, clocks: Array) -> bool:
    """Return whether the rows and columns of the given positions vanish off the diagonal."""
    others = ~np.eye(len(M), dtype=bool) & (clocks[:, None] | clocks)
    return not M[others].any()


def inherent_sde(problem: "HolonomicSDAE", *, with_multiplier: bool = False) -> SDE:
    """Return the equation with the multiplier eliminated.

    With the Gram matrix G_M = Dg M^{-1} grad g and the projector P_M = Id - grad g G_M^{-1} Dg M^{-1},

        dr   = v dt
        M dv = [ P_M a - grad g G_M^{-1} D^2 g(v, v) ] dt + P_M B dw                                   (2.9)
        dmu  = -G_M^{-1} { [ Dg M^{-1} a + D^2 g(v, v) ] dt + Dg M^{-1} B dw }                         (2.8)

    evaluated with the actual Dg(r) and G_M(r) off the manifold as well. The state is (r, v), shape (2 n, P).

    Parameters
    ----------
    problem : HolonomicSDAE
    with_multiplier : bool
        Whether mu is a component, too, of a state (r, v, mu), shape (2 n + m, P).

    Returns
    -------
    SDE
    """
    n, m = problem.dimension, problem.constraints if with_multiplier else 0

    def drift(t: float, x: Array) -> Array:
        r, v = x[:n], x[n : 2 * n]
        J = problem.linearised(r)
        a = problem.force(t, r, v)
        if a.shape != r.shape:
            a = np.broadcast_to(a, r.shape)
        lam = problem.inherent_multiplier(J, r, v, a)
        return np.concatenate([v, problem.inverse_mass(a + J.transposed(lam)), lam[:m]])

    def diffusion(t: float, x: Array) -> Array:
        r, v = x[:n], x[n : 2 * n]
        PB, Lam = project(problem, problem.linearised(r), problem.diffusion(t, r, v))
        return zero_columns(np.concatenate([problem.inverse_mass(PB), Lam[:m]]), n)

    def diffusion_product(t: float, x: Array, w: Array) -> Array:
        r, v = x[:n], x[n : 2 * n]
        Pw, lam = project(problem, problem.linearised(r), problem.diffused(t, r, v, w))
        return np.concatenate([0.0 * r, problem.inverse_mass(Pw), lam[:m]])

    start = [np.asarray(problem.position), np.asarray(problem.velocity), np.zeros(m)]
    names = {"r": slice(0, n), "v": slice(n, 2 * n), "mu": slice(2 * n, None)}
    return SDE(
        drift=drift,
        diffusion=diffusion,
        diffusion_product=diffusion_product,
        start=np.concatenate(start),
        names=names if with_multiplier else {name: names[name] for name in ("r", "v")},
        **{**problem.shared_fields, "traits": problem.traits - NOT_PROJECTED, "controls": (), "chart": None},
        source=f"inherent SDE (Lindner & Stroot 2017, (2.9)) of: {problem.source}",
        seen_as="inherent SDE",
    )


def project(problem: "HolonomicSDAE", J: "ConstraintJacobian", y: Array) -> tuple[Array, Array]:
    """Return P_M y and the multipliers -G_M^{-1} Dg M^{-1} y of this projection, y of shape (n, P) or (n, l, P).

    Parameters
    ----------
    problem : HolonomicSDAE
    J : ConstraintJacobian
        At the positions of the projection.
    y : ndarray, shape (n, P) or (n, l, P)
        Velocities, or columns of noise.
    """
    # y may be constant over all paths; its normal part is not.
    lam = -J.gram(J).solve(J.times(problem.inverse_mass(y)))
    return y + J.transposed(lam), lam
