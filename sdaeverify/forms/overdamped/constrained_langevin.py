"""The form dX = f dt + sigma dW + (sigma^2/4) grad ln det G dt - (1/eps) g G^{-1} zeta dt, and its limit eps = 0.

Symbols as in Laurent (2022): constraint zeta : R^d -> R^q, g = grad zeta (d x q), Gram matrix G = g^T g, and
Pi = Id - g G^{-1} g^T, the projector onto the tangent space; H_k is the Hessian of zeta_k.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array, Parts
from ...errors import ProblemError
from ...numerics.derivatives import directional
from ...numerics.linalg import norm
from ..checks import (
    PROBES,
    check_analytic,
    check_derivative,
    check_known,
    check_not_negative,
    check_shape,
    check_vanishes,
    columns,
    vector,
)
from ..features import Feature, has_several_constraints, pilot_states
from ..generic import GenericClass
from ..manifold import onto_manifold
from ..mechanics.jacobian import ConstraintJacobian, Gram
from ..mechanics.mistakes import KEPT_MISTAKES, PENALISED_MISTAKES
from ..problem import Problem, Residual, briefly_signed
from ..sde.sde import SDE
from ..traits import ADDITIVE
from ..trivial import Trivials
from .generic import FEATURES, draw_family
from .stiffness_family import StiffnessFamily
from .trivial_dynamics import trivial_dynamics

K = TypeVar("K")


@dataclass(frozen=True, eq=False)
class ConstraintGeometry:
    """The geometry of a constraint at points x: its gradient, its Gram matrix and their derivatives.

    Each property is computed at its first access.

    Authors of problems with closed forms override `relaxation`, `quadratic`, `fixman` and `divergence`.

    Attributes
    ----------
    problem : ConstrainedLangevin
    x : ndarray, shape (d, P)
    """

    problem: "ConstrainedLangevin"
    x: Array

    @cached_property
    def zeta(self) -> Array:
        """Return zeta(x), shape (q, P)."""
        return self.problem.constraint(self.x)

    @cached_property
    def J(self) -> ConstraintJacobian:
        """Return the Jacobian g^T."""
        return self.problem.linearised(self.x)

    @cached_property
    def gram(self) -> Gram:
        """Return the Gram matrix G."""
        return self.J.gram(self.J)

    @property
    def share(self) -> Array:
        """Return c = G^{-1} zeta, shape (q, P)."""
        return self.gram.solve(self.zeta)

    @property
    def relaxation(self) -> Array:
        """Return w = g G^{-1} zeta, shape (d, P): minus the first-order step back to the manifold."""
        return self.J.transposed(self.share)

    @property
    def quadratic(self) -> Array:
        """Return g'(w) c = sum_k c_k H_k w, shape (d, P): (zeta c / 2) grad ln det G in codimension one."""
        if len(self.zeta) == 1:
            return 0.5 * self.zeta * self.share * self.fixman
        return self.problem.contraction(self.x, self.relaxation[:, None] * self.share)

    @cached_property
    def fixman(self) -> Array:
        """Return grad ln det G = 2 sum_k H_k (g G^{-1})_k, shape (d, P)."""
        return 2.0 * self.problem.contraction(self.x, np.swapaxes(self.dual, 0, 1))

    @property
    def divergence(self) -> Array:
        """Return div g = (tr H_k)_k, shape (q, P)."""
        return self.problem.traces(self.x)

    @cached_property
    def dual(self) -> Array:
        """Return G^{-1} g^T, shape (q, d, P)."""
        return self.gram.solve(np.broadcast_to(self.problem.dg(self.x), (len(self.zeta), *self.x.shape)))

    @property
    def normal_traces(self) -> Array:
        """Return (tr H_k P)_k with P = g G^{-1} g^T, shape (q, P): the sum over j of (g G^{-1})_j . H_k g_j."""
        gradients = np.broadcast_to(self.problem.dg(self.x), self.dual.shape)
        terms = (
            np.einsum("kdp,dp->kp", self.problem.turn_normals(self.x, g_j), dual_j)
            for g_j, dual_j in zip(gradients, self.dual, strict=True)
        )
        return np.asarray(sum(terms, np.zeros_like(self.zeta)))

    def normal(self, y: Array) -> Array:
        """Return P y = g G^{-1} g^T y, shape (d, P)."""
        return self.J.transposed(self.gram.solve(self.J.times(y)))


@briefly_signed
@dataclass(frozen=True, kw_only=True, eq=False)
class ConstrainedLangevin(StiffnessFamily):
    """Overdamped Langevin dynamics near or on the manifold zeta = 0, W in R^d.

    For eps > 0 the penalised dynamics (1.4), for eps = 0 the constrained dynamics (1.2):

        dX = f dt + sigma dW + (sigma^2/4) grad ln det G dt - (1/eps) g G^{-1} zeta dt                    (1.4)
        dX = Pi f dt + sigma Pi o dW = [Pi f - (sigma^2/2) g G^{-1} tau] dt + sigma Pi dW,                (1.2)

    tau_k = tr(Pi H_k), H_k the Hessian of zeta_k.

    Attributes
    ----------
    drift : callable, x -> ndarray, shape (d, P)
        f.
    strength : float
        sigma, finite and not negative.
    eps : float
        Stiffness parameter, not negative, in the problem's unit of time.
    constraint : callable, x -> ndarray, shape (q, P)
        zeta; for eps > 0, a nonlinear function of it defines another problem.
    start : array_like, shape (d,)
        X at time 0, on the manifold.
    jacobian : callable, x -> ndarray, shape (q, d, P), optional
        g^T; by complex step if omitted, and zeta must then be analytic.
    hessians : array_like, shape (q, d, d), optional
        H_k if they are constant.
    second : callable, (x, A) -> ndarray, shape (d, P), optional
        S(x; A) = sum_k H_k(x) A_k for A of shape (d, q, P), from which all second derivatives follow.
    laplacians : callable, x -> ndarray, shape (q, P), optional
        tr H_k.
        Second derivatives are taken by complex step of the Jacobian if all three are omitted.
    geometry : callable, (problem, x) -> ConstraintGeometry, optional
        Returns closed forms, if there are any.
    family : callable, eps -> ConstrainedLangevin, optional
        The same problem, its truths included, with another eps.
    noise_dim : int
        d, set by the form.
    horizon, source, units, traits, noise, observables, truths, controls, chart, domain
        As for any `Problem`.
    relaxation_time, fastest_time
        As for any `Problem`, and seen_as, which only views set.

    Raises
    ------
    ProblemError
        If shapes, eps or the start are inconsistent, or a derivative disagrees with the constraint.
    """

    drift: Callable[[Array], Array]
    strength: float
    eps: float
    constraint: Callable[[Array], Array]
    start: ArrayLike
    jacobian: Callable[[Array], Array] | None = None
    hessians: ArrayLike | None = None
    second: Callable[[Array, Array], Array] | None = None
    laplacians: Callable[[Array], Array] | None = None
    geometry: Callable[["ConstrainedLangevin", Array], ConstraintGeometry] = ConstraintGeometry
    family: Callable[[float], "ConstrainedLangevin"] | None = None
    noise_dim: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", vector("start", self.start))
        object.__setattr__(self, "noise_dim", self.dimension)
        super().__post_init__()
        check_not_negative(self, "strength", "eps")
        object.__setattr__(self, "fastest_time", self.eps or np.inf)
        self._check_functions()
        self._check_start()
        check_known(self, self.parts(self.initial(PROBES)))

    def _all_traits(self) -> frozenset[str]:
        return super()._all_traits() | (ADDITIVE if self.eps else frozenset())

    @property
    def dimension(self) -> int:
        """Number d of components."""
        return len(cast("Array", self.start))

    @property
    def constraints(self) -> int:
        """Number q of constraints."""
        return len(self.constraint(self.initial(1)))

    @property
    def has_constraints(self) -> bool:
        """Whether the constraint is exact, that is in the limit eps = 0."""
        return self.eps == 0.0

    def initial(self, paths: int) -> Array:
        """Return the start on every path, shape (d, P)."""
        return columns(cast("Array", self.start), paths)

    def parts(self, x: Array) -> Parts:
        """Return the state as the single component x."""
        return {"x": x}

    def near(self, x: Array) -> ConstraintGeometry:
        """Return the geometry of the constraint at x."""
        return self.geometry(self, x)

    def contraction(self, x: Array, A: Array) -> Array:
        """Return S(x; A) = sum_k H_k(x) A_k, shape (d, P), for A of shape (d, q, P)."""
        if self._hessians is not None:
            return np.asarray(np.einsum("kij,jkp->ip", self._hessians, A))
        if self.second is not None:
            return self.second(x, A)
        terms = (self.turn_normals(x, column)[k] for k, column in enumerate(np.swapaxes(A, 0, 1)))
        return np.asarray(sum(terms, np.zeros_like(x)))

    def bent(self, x: Array, c: Array) -> Array:
        """Return sum_k c_k H_k(x), shape (d, d, P), for c of shape (q, P)."""
        if self._hessians is not None:
            return np.asarray(np.einsum("kij,kp->ijp", self._hessians, c))
        units = np.eye(self.dimension)[..., None, None]
        return np.stack([self.contraction(x, unit * c) for unit in units], axis=1)

    def turn_normals(self, x: Array, w: Array) -> Array:
        """Return the rows H_k w, shape (q, d, P): the derivative of g^T in the direction w of shape (d, P)."""
        if self._hessians is not None:
            return np.asarray(np.einsum("kij,jp->kip", self._hessians, w))
        if self.second is None:
            return directional(self.dg, x, w)
        units = np.eye(self.constraints)[..., None]
        return np.stack([self.second(x, w[:, None] * unit) for unit in units])

    def traces(self, x: Array) -> Array:
        """Return tr H_k, shape (q, P)."""
        if self.laplacians is not None:
            return self.laplacians(x)
        units = np.eye(self.dimension)
        if self._hessians is not None:
            return np.asarray(np.einsum("kii->k", self._hessians)[:, None] + 0.0 * x[:1])
        rows = (self.turn_normals(x, np.broadcast_to(unit[:, None], x.shape))[:, i] for i, unit in enumerate(units))
        return np.asarray(sum(rows, np.zeros((self.constraints, x.shape[-1]))))

    def residuals(self, parts: Parts) -> Mapping[str, Residual]:
        """Return the defect zeta(x) if the constraint is exact."""
        if not self.has_constraints:
            return {}
        x = parts["x"]
        return {"zeta": Residual(self.constraint(x), self.linearised(x).size() * norm(x))}

    def admissible(self, x: Array) -> Array:
        """Return points of the manifold near the columns of x, or x itself if the constraint is penalised."""
        return onto_manifold(self.constraint, self, x) if self.has_constraints else x

    @classmethod
    def generic_classes(cls) -> tuple[GenericClass, ...]:
        """Return the classes of polynomial problems with exact and with penalised constraints."""
        return tuple(
            GenericClass(
                f"ConstrainedLangevin at eps {sign} 0", partial(draw_family, cls, kept=kept), FEATURES, known
            )
            for sign, kept, known in (("=", True, KEPT_MISTAKES), (">", False, PENALISED_MISTAKES))
        )

    def capability(self, kind: type[K]) -> K | None:
        """Return the problem as a capability; it is a `StiffnessFamily` only with a family."""
        return None if kind is StiffnessFamily and self.family is None else super().capability(kind)

    def why_not(self, kind: type[Any]) -> str:
        """Return why the problem does not have a capability, or an empty string."""
        if kind is StiffnessFamily and self.family is None:
            return "the problem is defined for one stiffness parameter only"
        return super().why_not(kind)

    def member(self, eps: float) -> "ConstrainedLangevin":
        """Return the problem with another eps."""
        assert self.family is not None
        return self.family(eps)

    def view(self, form: type[Problem]) -> Problem | None:
        """Return the problem itself, or its Ito equation if an `SDE` is requested."""
        return self._sde if form is SDE else super().view(form)

    @classmethod
    def trivial_problems(cls) -> Trivials:
        """Return the problems that every scheme for the form solves exactly, or to first order."""
        return trivial_dynamics(ConstrainedLangevin)

    @classmethod
    def features(cls) -> tuple[Feature, ...]:
        """Return the features of the form: several constraints, and curved ones."""
        return (
            Feature("several constraints", has_several_constraints),
            Feature("a curved constraint", lambda problem: problem.is_curved),
        )

    @property
    def is_curved(self) -> bool:
        """Whether the constraint's second derivative is nonzero at some states."""
        x = pilot_states(self)
        return bool(np.any(self.turn_normals(x, np.ones_like(x))))

    def ito(self) -> SDE:
        """Return the penalised equation (1.4) or, in the limit, (1.2) in Ito's form."""
        return cast("SDE", self._sde)

    def _make_sde(self) -> SDE:
        return langevin_equation(self)

    @cached_property
    def _hessians(self) -> Array | None:
        return None if self.hessians is None else np.asarray(self.hessians, dtype=float)

    def _check_functions(self) -> None:
        d, q, x = self.dimension, self.constraints, self.initial(PROBES)
        if not 0 < q < d:
            raise ProblemError(f"constraint(x) has {q} components, expected between 1 and {d - 1}")
        check_shape("drift(x)", self.drift(x), (d, PROBES))
        check_shape("constraint(x)", self.constraint(x), (q, PROBES))
        if self.jacobian is None:
            check_analytic("constraint", self.constraint, x, "; give jacobian")
        check_shape("jacobian(x)", self.dg(x), (q, d, PROBES))
        if self.jacobian is not None:
            check_derivative("jacobian", self.constraint, lambda y, z: self.linearised(y).times(z), x)
        if self._hessians is not None and self._hessians.shape != (q, d, d):
            raise ProblemError(f"hessians has shape {self._hessians.shape}, expected {(q, d, d)}")
        if self._hessians is None and self.second is None:
            check_analytic("jacobian", self.dg, x, "; give hessians or second")
        self._check_second(x)

    def _check_second(self, x: Array) -> None:
        c = np.cos(1.0 + np.arange(self.constraints))[:, None]
        y = x + 0.1
        A = np.broadcast_to(np.sin(1.0 + np.arange(len(x)))[:, None, None], (len(x), self.constraints, PROBES)) * c
        check_shape("second(x, A)", self.contraction(x, A), x.shape)
        check_derivative(
            "second",
            lambda z: self.linearised(z).transposed(c + 0.0 * z[:1]),
            lambda z, w: self.contraction(z, w[:, None] * c),
            y,
        )
        check_shape("laplacians(x)", self.traces(x), (self.constraints, PROBES))
        basis = [np.broadcast_to(unit[:, None], y.shape) for unit in np.eye(self.dimension)]
        expected = sum(self.turn_normals(y, unit)[:, i] for i, unit in enumerate(basis))
        if not np.allclose(self.traces(y), expected, rtol=1e-6, atol=1e-9):
            raise ProblemError("laplacians disagrees with the traces of the second derivatives")

    def _check_start(self) -> None:
        x = self.initial(1)
        Dg = self.dg(x)
        if np.linalg.matrix_rank(Dg[..., 0]) < self.constraints:
            raise ProblemError(f"the gradient of the constraint does not have full rank at start {x[:, 0].tolist()}")
        check_vanishes("start violates", "constraint", self.constraint(x), self.linearised(x).size() * norm(x))


def langevin_equation(problem: "ConstrainedLangevin") -> SDE:
    """Return the Ito equation of penalised or constrained dynamics, (1.4) or (1.2)."""
    sigma, eps, d = problem.strength, problem.eps, problem.dimension

    def penalised_drift(_: float, x: Array) -> Array:
        at = problem.near(x)
        return problem.drift(x) + 0.25 * sigma**2 * at.fixman - at.relaxation / eps

    def constrained_drift(_: float, x: Array) -> Array:
        at, f = problem.near(x), problem.drift(x)
        tau = at.divergence - at.normal_traces
        return f - at.normal(f) - 0.5 * sigma**2 * at.J.transposed(at.gram.solve(tau))

    def projector(_: float, x: Array) -> Array:
        at = problem.near(x)
        return sigma * (np.eye(d)[..., None] - at.J.transposed(at.dual))

    def project(_: float, x: Array, w: Array) -> Array:
        return sigma * (w - problem.near(x).normal(w))

    return SDE(
        drift=penalised_drift if eps else constrained_drift,
        diffusion=(lambda *_: sigma * np.eye(d)[..., None]) if eps else projector,
        diffusion_product=(lambda *given: sigma * given[-1]) if eps else project,
        start=problem.start,
        constraint=None if eps else problem.constraint,
        jacobian=None if eps else problem.jacobian,
        **problem.shared_fields,
        source=f"{'penalised' if eps else 'constrained'} dynamics of: {problem.source}",
        seen_as="penalised SDE" if eps else "constrained SDE",
    )
