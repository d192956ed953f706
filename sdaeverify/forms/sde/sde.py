"""The form dx = f(t, x) dt + B(t, x) dW in Ito's sense."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array, Parts
from ...errors import ProblemError, SchemeError
from ...noise.brownian import BROWNIAN, Increment
from ...numerics.derivatives import directional, is_analytic, jacobian, jacobian_at_once
from ...numerics.linalg import apply, norm
from ..checks import (
    PROBES,
    check_analytic,
    check_derivative,
    check_known,
    check_product,
    check_shape,
    check_vanishes,
    columns,
    vector,
)
from ..domain import Domain
from ..features import (
    Feature,
    differ,
    has_several_motions,
    noises_do_not_commute,
    pilot_states,
    times_of,
    vary,
)
from ..manifold import onto_manifold
from ..mechanics.jacobian import ConstraintJacobian, DenseJacobian
from ..problem import Problem, Residual, briefly_signed
from ..traits import COMMUTING
from ..trivial import NOISES, RATE, SOURCE, Trivial, Trivials
from .linear_growth import grows_linearly
from .trivial_in_domain import trivial_equations_in
from .waves import SOURCE as RANDOM_SOURCE
from .waves import random_coefficients


@briefly_signed
@dataclass(frozen=True, kw_only=True, eq=False)
class SDE(Problem):
    """A stochastic differential equation dx = f dt + B dW (Ito).

    Attributes
    ----------
    drift : callable, (t, x) -> ndarray, shape (d, P)
        f, for states x of shape (d, P).
    diffusion : callable, (t, x) -> ndarray, shape (d, l, P) or (d, l, 1)
        B, one column for each Brownian motion.
    start : array_like, shape (d,)
        x at time 0.
    diffusion_derivative : callable, (t, x, y) -> ndarray, shape (d, l, P), optional
        DB(x) y, the derivative of B in the direction y of shape (d, P); by complex step if omitted, and B
        must then be analytic.
    drift_derivative : callable, (t, x) -> ndarray, shape (d, d, P) or (d, d, 1), optional
        Df, for implicit schemes; by complex step if omitted. The last axis is 1 if it is the same on every path.
    diffusion_product : callable, (t, x, w) -> ndarray, shape (d, P), optional
        B(t, x) w for w of shape (l, P), if it is cheaper than the product with the matrix.
    names : mapping of str to slice, optional
        Named components; ``x`` for the whole state if omitted.
    constraint : callable, x -> ndarray, shape (m, P), optional
        g, an invariant of the equation that vanishes along solutions.
    jacobian : callable, x -> ndarray, shape (m, d, P), optional
        Dg; by complex step if omitted, and g must then be analytic.
    horizon, noise_dim, source, units, traits, noise, observables, truths
        As for any `Problem`.
    controls, chart, domain, relaxation_time, fastest_time
        As for any `Problem`, and seen_as, which only views set.

    Raises
    ------
    ProblemError
        If a function returns the wrong shape or a value that is not finite at the initial state, if a name selects no
        component, or if the initial state violates the constraint.
    """

    drift: Callable[[float, Array], Array]
    diffusion: Callable[[float, Array], Array]
    start: ArrayLike
    diffusion_derivative: Callable[[float, Array, Array], Array] | None = None
    drift_derivative: Callable[[float, Array], Array] | None = None
    diffusion_product: Callable[[float, Array, Array], Array] | None = None
    names: Mapping[str, slice] | None = None
    constraint: Callable[[Array], Array] | None = None
    jacobian: Callable[[Array], Array] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "start", vector("start", self.start))
        d, x = self.dimension, self.initial(PROBES)
        check_shape("drift(t, x)", self.drift(0.0, x), (d, PROBES))
        check_shape("diffusion(t, x)", self.diffusion(0.0, x), (d, self.noise_dim, PROBES))
        if self.diffusion_derivative is not None:
            derivative = self.diffusion_derivative(0.0, x, x)
            check_shape("diffusion_derivative(t, x, y)", derivative, (d, self.noise_dim, PROBES))
            check_derivative(
                "diffusion_derivative", partial(self.diffusion, 0.0), partial(self.diffusion_derivative, 0.0), x
            )
        if self.drift_derivative is not None:
            check_shape("drift_derivative(t, x)", self.drift_derivative(0.0, x), (d, d, PROBES))
            check_derivative("drift_derivative", partial(self.drift, 0.0), self._drift_change, x)
        if not self.seen_as:
            # A view is made of functions that were checked in the original problem.
            check_product(self, x)
        for name, rows in (self.names or {}).items():
            if not (isinstance(rows, slice) and range(d)[rows]):
                raise ProblemError(f"names[{name!r}] must be a slice of the {d} components, got {rows!r}")
        self._check_constraint(x)
        self._check_domain(x)
        self._check_traits(x)
        others = self.traits - {"linear-growth"}
        object.__setattr__(self, "traits", others | ({"linear-growth"} if self._grows_linearly() else set()))
        check_known(self, self.parts(x))

    @property
    def dimension(self) -> int:
        """Number d of components."""
        return len(cast("Array", self.start))

    def initial(self, paths: int) -> Array:
        """Return the initial state on every path, shape (d, P)."""
        return columns(cast("Array", self.start), paths)

    def parts(self, x: Array) -> Parts:
        """Return the named components of a state of shape (d, P).

        Raises
        ------
        SchemeError
            If the state has another number of components; further memory must be separated by the scheme.
        """
        if np.ndim(x) < 2 or len(x) != self.dimension:
            text = f"a state of shape {np.shape(x)}, expected ({self.dimension}, P) with the paths last"
            raise SchemeError(f"{text}; a scheme with additional memory must override parts(problem, state)")
        return {name: x[rows] for name, rows in (self.names or {"x": slice(None)}).items()}

    @classmethod
    def trivial_problems(cls) -> Trivials:
        """Return the problems that every scheme for the form solves exactly."""
        return _trivial_equations()

    @classmethod
    def trivial_problems_in(cls, domain: Domain) -> Trivials:
        """Return problems of rest and of motion along a line in a domain, without noise, which would leave it."""
        return trivial_equations_in(SDE, domain)

    @classmethod
    def features(cls) -> tuple[Feature, ...]:
        """Return the features of the form: several motions, kinds of noise, and time-dependent coefficients."""
        return EQUATION_FEATURES

    def random_like(self) -> "SDE":
        """Return a random equation with this kind of noise, which is nonlinear and depends on time."""
        return SDE(
            **random_coefficients(self.dimension, self.noise_dim, self.traits), horizon=1.0, source=RANDOM_SOURCE
        )

    def ito(self) -> "SDE":
        """Return the equation itself."""
        return self

    @property
    def has_constraints(self) -> bool:
        """Whether the equation has an invariant."""
        return self.constraint is not None

    def diffused(self, t: float, x: Array, w: Array) -> Array:
        """Return B(t, x) w, shape (d, P), for w of shape (l, P).

        Parameters
        ----------
        t : float
        x : ndarray, shape (d, P)
        w : ndarray, shape (l, P)
            For example an increment of the Brownian motions.
        """
        if self.diffusion_product is not None:
            return self.diffusion_product(t, x, w)
        return apply(self.diffusion(t, x), w)

    def euler(self, t: float, x: Array, h: float, noise: Increment) -> Array:
        """Return x + f h + B dW, shape (d, P): a step of Euler-Maruyama.

        Parameters
        ----------
        t : float
            Start of the step.
        x : ndarray, shape (d, P)
        h : float
            Its size, in the problem's unit of time.
        noise : Increment
            Of the step.
        """
        return np.asarray(x + h * self.drift(t, x) + self.diffused(t, x, noise.dW))

    def linearised(self, x: Array) -> ConstraintJacobian:
        """Return the linearised constraint at x."""
        return DenseJacobian(self.dg(x))

    def push(self, J: ConstraintJacobian, c: Array) -> Array:
        """Return grad g c, shape (d, P), for c of shape (m, P)."""
        return J.transposed(c)

    def dg(self, x: Array) -> Array:
        """Return Dg(x), shape (m, d, P), of the constraint.

        Raises
        ------
        ProblemError
            If the equation has no invariant.
        """
        return jacobian(self._invariant, x) if self.jacobian is None else self.jacobian(x)

    def admissible(self, x: Array) -> Array:
        """Return points of the manifold g = 0 near the columns of x.

        Raises
        ------
        ProblemError
            If the equation has no invariant.
        """
        return onto_manifold(self._invariant, self, x)

    def residuals(self, parts: Parts) -> Mapping[str, Residual]:
        """Return the defect g(x), if there is a constraint."""
        if self.constraint is None:
            return {}
        x = np.concatenate([parts[name] for name in self.names or ("x",)])
        return {"g": Residual(self.constraint(x), self.linearised(x).size() * norm(x))}

    def derivative_of_drift(self, t: float, x: Array) -> Array:
        """Return Df(x), shape (d, d, P) or (d, d, 1)."""
        if self.drift_derivative is not None:
            return self.drift_derivative(t, x)
        return jacobian_at_once(partial(self.drift, t), x)

    def why_not_derivative_of_drift(self) -> str:
        """Return why Df is neither given nor available by complex step, or an empty string."""
        if self.drift_derivative is not None or is_analytic(partial(self.drift, 0.0), self.initial(1)):
            return ""
        return "drift is not analytic (abs or a real array?), so that Newton's method has no Jacobian"

    def derivative_of_diffusion(self, t: float, x: Array, y: Array) -> Array:
        """Return DB(x) y, shape (d, l, P).

        Parameters
        ----------
        t : float
        x : ndarray, shape (d, P)
        y : ndarray, shape (d, P)
            The direction.
        """
        if self.diffusion_derivative is not None:
            return self.diffusion_derivative(t, x, y)
        return directional(lambda z: self.diffusion(t, z), x, y)

    def why_not_derivative_of_diffusion(self) -> str:
        """Return why DB is neither given nor available by complex step, or an empty string."""
        if self.diffusion_derivative is not None:
            return ""
        if is_analytic(lambda z: self.diffusion(0.0, z), self.initial(1)):
            return ""
        text = "diffusion is not analytic (abs or a real array?), so that its derivative cannot be taken"
        return f"{text} by complex step; give diffusion_derivative"

    def _drift_change(self, x: Array, y: Array) -> Array:
        assert self.drift_derivative is not None
        return np.asarray(np.einsum("mnp,np->mp", self.drift_derivative(0.0, x), y))

    @property
    def _invariant(self) -> Callable[[Array], Array]:
        if self.constraint is None:
            raise ProblemError("the equation has no constraint, hence no Dg; refuse it in refuses(problem)")
        return self.constraint

    def _check_traits(self, x: Array) -> None:
        # A trait that does not hold would cause claims to be refuted on problems they were not made for.
        y = x + 0.1 * (1.0 + np.abs(x)) * np.cos(np.arange(1.0, len(x) + 1))[:, None]
        here, there = self.diffusion(0.0, x), self.diffusion(0.5 * self.horizon, y)
        if "additive-noise" in self.traits and not np.allclose(here, there, rtol=1e-12, atol=0.0):
            raise ProblemError("trait additive-noise: the diffusion depends on the state or on time")
        d, l, _ = there.shape
        if "diagonal-noise" in self.traits and (d != l or there[~np.eye(d, dtype=bool)].any()):
            raise ProblemError("trait diagonal-noise: the diffusion has entries off the diagonal")
        stated = "commutative-noise" in self.traits and not self.traits & COMMUTING
        if stated and not self.why_not_derivative_of_diffusion() and not self._commutes(0.5 * self.horizon, y):
            raise ProblemError("trait commutative-noise: DB_j B_k and DB_k B_j differ")
        if "overdamped-gradient" in self.traits and (why := self._why_not_gradient(y)):
            raise ProblemError(f"trait overdamped-gradient: {why}")

    def _grows_linearly(self) -> bool:
        return grows_linearly(self)

    def _why_not_gradient(self, x: Array) -> str:
        B, d = self.diffusion(0.0, x), self.dimension
        if B.shape[1] != d or not np.allclose(B, B[0, 0] * np.eye(d)[..., None], rtol=1e-12, atol=0.0):
            return "the diffusion is not a multiple of Id"
        if not np.array_equal(self.drift(0.0, x), self.drift(0.5 * self.horizon, x)):
            return "the drift depends on time"
        if self.why_not_derivative_of_drift():
            return ""
        J = np.asarray(self.derivative_of_drift(0.0, x))
        symmetric = np.allclose(J, J.swapaxes(0, 1), rtol=0.0, atol=1e-10 * np.abs(J).max())
        return "" if symmetric else "Df is not symmetric, so that the drift is not a gradient"

    def _commutes(self, t: float, x: Array) -> bool:
        B = np.broadcast_to(self.diffusion(t, x), (self.dimension, self.noise_dim, x.shape[-1]))
        turned = np.stack([self.derivative_of_diffusion(t, x, B[:, k]) for k in range(self.noise_dim)], axis=2)
        return bool(np.allclose(turned, turned.swapaxes(1, 2), rtol=0.0, atol=1e-10 * np.abs(turned).max()))

    def _check_domain(self, x: Array) -> None:
        if self.domain is None:
            return
        if not self.domain.contains(x).all():
            raise ProblemError(f"the start {x[:, 0].tolist()} is not in the domain, {self.domain}")
        if not self.domain.contains(self.domain.draw(self.dimension, PROBES)).all():
            raise ProblemError(f"domain {self.domain}: sample returns states that contains rejects")

    def _check_constraint(self, x: Array) -> None:
        if self.constraint is None:
            if self.jacobian is not None:
                raise ProblemError("jacobian is given without constraint")
            return
        value = self.constraint(x)
        m = len(value) if isinstance(value, np.ndarray) and value.ndim == 2 else 1
        check_shape("constraint(x)", value, (m, PROBES))
        if self.jacobian is not None:
            check_shape("jacobian(x)", self.jacobian(x), (m, self.dimension, PROBES))
            check_derivative("jacobian", self.constraint, lambda y, z: self.linearised(y).times(z), x)
        else:
            check_analytic("constraint", self.constraint, x, "; give jacobian")
        scale = self.residuals(self.parts(x))["g"].scale
        check_vanishes("the initial state violates", "constraint", value, scale)


def as_sde(problem: Problem) -> SDE | None:
    """Return the view of a problem as an SDE, or None if it has none."""
    seen = problem.view(SDE)
    return seen if isinstance(seen, SDE) else None


def zero_columns(blocks: Array, above: int) -> Array:
    """Prepend `above` rows of zeros to a matrix of shape (n, l, P)."""
    return np.concatenate([np.zeros((above, *blocks.shape[1:]), dtype=blocks.dtype), blocks])


# For schemes that need noise of equal strength in each component.
EVEN = 0.8 * np.eye(2)
# For schemes that need an invariant: x_2 = 0.
ALONG = np.array([[0.7, -0.3], [0.0, 0.0]])


def _is_multiplicative(problem: SDE) -> bool:
    return vary(problem.diffusion(0.0, pilot_states(problem)))


def _do_not_commute(problem: SDE) -> bool:
    return noises_do_not_commute(partial(problem.diffusion, 0.0), pilot_states(problem))


def _depends_on_time(problem: SDE) -> bool:
    x, times = pilot_states(problem), [*times_of(problem)]
    return any(differ([f(t, x) for t in times]) for f in (problem.drift, problem.diffusion))


EQUATION_FEATURES = (
    Feature("several Brownian motions", has_several_motions),
    Feature("multiplicative noise", _is_multiplicative),
    Feature("noises that do not commute", _do_not_commute),
    Feature("coefficients that depend on time", _depends_on_time),
)


def _trivial_equations() -> Trivials:
    """Return the problems dx = 0, dx = c dt and dx = S dW, each for several noise matrices."""
    noises = (*NOISES, EVEN, ALONG)
    still, moving = [0.0 * S for S in noises], [*(RATE for _ in noises[1:]), RATE * [1.0, 0.0]]
    return (
        tuple(_sde("dx = 0", 0.0 * RATE, S, invariant=S is still[-1]) for S in still),
        tuple(_sde("dx = c dt", c, S, invariant=S is still[-1]) for c, S in zip(moving, still, strict=True)),
        tuple(_sde("dx = S dW", 0.0 * RATE, S, invariant=S is ALONG) for S in noises),
    )


def _sde(name: str, c: Array, S: Array, *, invariant: bool) -> Trivial:
    start, l = np.array([1.0, 0.0 if invariant else -0.5]), S.shape[1]
    diagonal = l == 2 and not (S - np.diag(np.diag(S))).any()
    problem = SDE(
        drift=lambda _t, x: c[:, None] + 0.0 * x,
        diffusion=lambda _t, x: S[..., None] + 0.0 * x[:1, None],
        diffusion_derivative=lambda _t, x, _y: np.zeros((2, l, x.shape[1])),
        constraint=(lambda x: x[1:]) if invariant else None,
        start=start,
        noise_dim=l,
        noise=frozenset(BROWNIAN),
        horizon=1.0,
        traits=frozenset({"additive-noise", "diagonal-noise"} if diagonal else {"additive-noise"}),
        source=SOURCE,
    )

    def solution(t: float, W: Array) -> Parts:
        return {"x": start[:, None] + t * c[:, None] + S @ W}

    return Trivial(name, problem, solution)
