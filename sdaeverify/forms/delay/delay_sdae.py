"""The form dx = f dt + g dW, 0 = u of index 1, with one constant delay in x: Qu, Huang & Liu (2010), (2.1)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple, TypeGuard, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array, Mask, Parts
from ...errors import ProblemError
from ...noise.brownian import Increment
from ...numerics.linalg import apply, determinant, largest, norm, solve
from ...numerics.newton import newton, update_tolerance
from ..checks import (
    CONSISTENCY,
    PROBES,
    check_known,
    check_not_negative,
    check_shape,
    columns,
    format_value,
    numbers,
    vector,
)
from ..features import Feature
from ..generic import GenericClass
from ..problem import Problem, Residual, briefly_signed
from ..sde.sde import SDE
from ..trivial import Trivials
from .checks import check_jacobians, check_regular, check_solved, size_of_terms, why_not_drift_partials
from .delay_features import delay_features
from .delayed import Delayed
from .dissipation import Dissipation
from .generic import FEATURES, draw_delay
from .mesh import Lag, Mesh, Recall
from .partials import Partials, partials
from .trivial_delays import trivial_delays

# Number of times at which a history is checked.
HISTORY = 17
NO_Y = "the equation has no algebraic component y; refuse it in refuses(problem)"
# Arguments: t, x, the lagged x, and y.
Coefficient = Callable[[float, Array, Array, Array], Array]
K = TypeVar("K")


class DelayState(NamedTuple):
    """The state at a mesh point, without its past.

    Attributes
    ----------
    x : ndarray, shape (d, P)
        Differential components.
    y : ndarray, shape (q, P)
        Algebraic components.
    """

    x: Array
    y: Array


def _is_number(given: object) -> TypeGuard[int]:
    """Return whether `algebraic` is the number of components of y, whose initial value is then solved for."""
    return isinstance(given, int | np.integer)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Compared(SDE):
    """The equation that steps are compared with; omits the test of linear growth, which solves for y at large x."""

    def _grows_linearly(self) -> bool:
        return False


@briefly_signed
@dataclass(frozen=True, kw_only=True, eq=False)
class DelaySDAE(Delayed):
    """A stochastic delay differential-algebraic equation of index 1 (Ito).

    With v(t) = x(t - tau),

        dx = f(t, x, v, y) dt + g(t, x, v, y) dW,    0 = u(t, x, v, y),    x = phi on [-tau, 0].

    The constraint contains no noise and determines y: du/dy is regular. Without delay it is a plain SDAE, with v = x.

    Attributes
    ----------
    drift : callable, (t, x, v, y) -> ndarray, shape (d, P)
        f, for x and v of shape (d, P) and y of shape (q, P).
    diffusion : callable, (t, x, v, y) -> ndarray, shape (d, l, P) or (d, l, 1)
        g, one column for each Brownian motion.
    delay : float
        tau, in the problem's unit of time; 0 for none.
    history : callable, t -> array_like, shape (d,)
        phi, for t from -tau to 0.
    constraint : callable, (t, x, v, y) -> ndarray, shape (q, P), optional
        u; if omitted, there is no y.
    algebraic : array_like, shape (q,), or int, optional
        y at time 0, which must be consistent. If it is an int, the number q, y is solved for.
    solved : callable, (t, x, v) -> ndarray, shape (q, P), optional
        U, the y that solves the constraint; by Newton's method if omitted.
    drift_partials, constraint_partials : callable, (t, x, v, y) -> three matrices, optional
        The derivatives in x, v and y of f, shapes (d, d, P), (d, d, P), (d, q, P), and of u; by complex step if
        omitted, and the function must then be analytic.
    dissipation : Dissipation, optional
        The constants of condition (4.1) of mean-square stability.
    dissipation_without_y : Dissipation, optional
        Constants of the equation with y eliminated, if better than those that `dissipation` implies.
    horizon, noise_dim, source, units, traits, noise, observables, truths
        As for any `Problem`.
    controls, chart, domain, relaxation_time, fastest_time
        As for any `Problem`, and seen_as, which only views set.

    Raises
    ------
    ProblemError
        If a function returns the wrong shape or a value that is not finite at the start, if the delay is negative, if
        y at time 0 is inconsistent or du/dy is singular there, or if given derivatives are wrong.
    """

    drift: Coefficient
    diffusion: Coefficient
    delay: float
    history: Callable[[float], ArrayLike]
    constraint: Coefficient | None = None
    algebraic: ArrayLike | int | None = None
    solved: Callable[[float, Array, Array], Array] | None = None
    drift_partials: Callable[[float, Array, Array, Array], Partials] | None = None
    constraint_partials: Callable[[float, Array, Array, Array], Partials] | None = None
    dissipation: Dissipation | None = None
    dissipation_without_y: Dissipation | None = None

    # Arguments of the author's functions, for messages.
    arguments = "t, x, v, y"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_not_negative(self, "delay")
        if (self.constraint is None) != (self.algebraic is None):
            raise ProblemError("constraint and algebraic, the y at time 0 or their number, must be given together")
        if _is_number(self.algebraic) and (isinstance(self.algebraic, bool) or self.constraints < 1):
            raise ProblemError(f"algebraic must be y at time 0 or a number of at least 1, got {self.algebraic!r}")
        for t in np.linspace(0.0, -self.delay, HISTORY):
            self.past(float(t))
        self._check_functions()
        check_known(self, self.parts(self.initial(PROBES)))

    def _all_traits(self) -> frozenset[str]:
        constants = self.reduced_dissipation
        found = {
            "no-delay": not self.delay,
            "algebraic": self.has_constraints,
            "dissipative": constants is not None and constants.C > 0.0,
        }
        # An interpolated y has order 1/2 with additive noise, too: only x gains. The noise that drives the past
        # differs from the noise that drives x, so they do not commute if a diffusion depends on the past.
        not_said = {"no-delay", *({"vanishing-milstein-term", "commutative-noise"} if self.delay else ())}
        return super()._all_traits() - not_said | {name for name, holds in found.items() if holds}

    @property
    def reduced_dissipation(self) -> Dissipation | None:
        """The constants of the equation with y eliminated: the given ones, or those that `dissipation` implies."""
        given = self.dissipation_without_y
        return given or (self.dissipation.without_y if self.dissipation else None)

    @property
    def dimension(self) -> int:
        """Number d of differential components."""
        return len(vector("history(0.0)", self.history(0.0)))

    @property
    def constraints(self) -> int:
        """Number q of algebraic components."""
        given = self.algebraic
        if given is None:
            return 0
        return int(given) if _is_number(given) else len(vector("algebraic", given))

    @property
    def has_constraints(self) -> bool:
        """Whether there are algebraic components."""
        return self.constraint is not None

    def past(self, t: float) -> Array:
        """Return phi(t), shape (d, 1)."""
        value = vector(f"history({t!r})", self.history(t))
        if len(value) != self.dimension:
            raise ProblemError(f"history({t!r}) has {len(value)} components, history(0.0) has {self.dimension}")
        return value[:, None]

    def initial(self, paths: int) -> DelayState:
        """Return x and y at time 0 on every path."""
        return DelayState(np.repeat(self.past(0.0), paths, axis=1), columns(self._start_y, paths))

    def parts(self, state: DelayState) -> Parts:
        """Return x and, if there are algebraic components, y."""
        return state._asdict() if self.constraints else {"x": state.x}

    def mesh(self, h: float) -> Mesh:
        """Return the position of the delay on a grid of steps of size h."""
        return Mesh.of(self.delay, h)

    def recall(self, h: float, paths: int) -> Recall | None:
        """Return the lagged values of a run with steps of size h on a number of paths; None without delay."""
        return Recall(self.mesh(h), h, self.delay, self.past, self.initial(paths).x) if self.delay else None

    def lag(self, x: Array, h: float, noise: Increment) -> Lag:
        """Return the lagged values of a step of size h from x, shape (d, P), driven by `noise`."""
        if not self.delay:
            return Lag(x, np.zeros_like(x), 1.0)
        assert noise.lagged is not None
        assert noise.ahead is not None
        return Lag(noise.lagged, noise.ahead, self.mesh(h).weight)

    def why_not_jacobian(self) -> str:
        """Return why the drift cannot be differentiated, or an empty string."""
        return why_not_drift_partials(self)

    def diffused(self, t: float, x: Array, v: Array, y: Array, w: Array) -> Array:
        """Return g(t, x, v, y) w, shape (d, P), for w of shape (l, P)."""
        return apply(self.diffusion(t, x, v, y), w)

    def linearised_drift(self, t: float, x: Array, v: Array, y: Array) -> Partials:
        """Return the derivatives of f in x, v and y.

        Parameters
        ----------
        t : float
        x, v : ndarray, shape (d, P)
            The solution at t, and one delay before t.
        y : ndarray, shape (q, P)
            Algebraic components at t.
        """
        return self.drift_partials(t, x, v, y) if self.drift_partials else partials(self.drift, t, x, v, y)

    def linearised_constraint(self, t: float, x: Array, v: Array, y: Array) -> Partials:
        """Return the derivatives of u in x, v and y."""
        if self.constraint is None:
            raise ProblemError(NO_Y)
        given = self.constraint_partials
        return given(t, x, v, y) if given else partials(self.constraint, t, x, v, y)

    def eliminated(self, t: float, x: Array, v: Array) -> Array:
        """Return U(t, x, v), the y that solves the constraint, shape (q, P); NaN if Newton's method fails."""
        if self.constraint is None:
            raise ProblemError(NO_Y)
        if self.solved is not None:
            return self.solved(t, x, v)
        return solve_algebraic(self, t, x, v, columns(self._start_y, x.shape[-1]))

    def without_y(self) -> "DelaySDAE":
        """Return the delay equation with y eliminated; the problem itself if there is no y."""
        if not self.constraints:
            return self
        return DelaySDAE(
            drift=lambda t, x, v, _: self.drift(t, x, v, self.eliminated(t, x, v)),
            diffusion=lambda t, x, v, _: self.diffusion(t, x, v, self.eliminated(t, x, v)),
            delay=self.delay,
            history=self.history,
            dissipation=self.reduced_dissipation,
            **self.shared_fields,
            source=f"y eliminated from: {self.source}",
            seen_as="delay equation",
        )

    def capability(self, kind: type[K]) -> K | None:
        """Return the problem as a capability; it is `Delayed` only with a delay."""
        return None if kind is Delayed and not self.delay else super().capability(kind)

    def view(self, form: type[Problem]) -> Problem | None:
        """Return the problem itself or, without delay, the equation of x if an `SDE` is requested."""
        return super().view(form) or (self._sde if form is SDE and not self.delay else None)

    @classmethod
    def trivial_problems(cls) -> Trivials:
        """Return the problems that every scheme for the form solves exactly."""
        return trivial_delays(DelaySDAE)

    @classmethod
    def generic_classes(cls) -> tuple[GenericClass, ...]:
        """Return the class of all polynomial problems of the form."""
        return (GenericClass("DelaySDAE", partial(draw_delay, DelaySDAE), FEATURES),)

    @classmethod
    def features(cls) -> tuple[Feature, ...]:
        """Return the features of the form: several components and motions, kinds of noise, and the delay."""
        return delay_features()

    def ito(self) -> SDE | None:
        """Return the equation of x with y eliminated; None with a delay, because x alone is not a state."""
        return None if self.delay else self._compared

    def coefficients(self, t: float, x: Array) -> tuple[Array, ...]:
        """Return f, g and u at the rows x and y of states; the lagged x of each path is the x of another path."""
        z, y = x[: self.dimension], x[self.dimension :]
        v, constraint = np.roll(z, 1, axis=1), [] if self.constraint is None else [self.constraint]
        return tuple(function(t, z, v, y) for function in (self.drift, self.diffusion, *constraint))

    def state(self, x: Array, t: float = 0.0) -> DelayState:
        """Return the state at x and time t, for problems without delay."""
        return self.consistent(t, x, x)

    def consistent(self, t: float, x: Array, v: Array) -> DelayState:
        """Return the state at x and its lagged value v, with the y that solves the constraint."""
        return DelayState(x, self.eliminated(t, x, v) if self.constraints else x[:0])

    def residuals(self, parts: Parts) -> Mapping[str, Residual]:
        """Return the defect u if y, the lagged x (with a delay) and the time are known."""
        if self.constraint is None or "y" not in parts or (self.delay and "lagged" not in parts):
            return {}
        x, y, t = parts["x"], parts["y"], float(parts["t"][0, 0]) if "t" in parts else 0.0
        v = parts.get("lagged", x)
        terms = zip(self.linearised_constraint(t, x, v, y), (x, v, y), strict=True)
        sizes = [np.abs(A).max(axis=(0, 1)) * norm(z) for A, z in terms]
        scale = np.broadcast_to(sum(sizes, np.zeros(1)), x.shape[-1:])
        return {"u": Residual(self.constraint(t, x, v, y), scale)}

    @property
    def moving_constraints(self) -> bool:
        """Always: u depends on time and, with a delay, on the past."""
        return True

    def kick(self, t: float, parts: Parts, noise: Increment) -> Array:
        """Return g dW, shape (d, P)."""
        x = parts["x"]
        return self.diffused(t, x, x if noise.lagged is None else noise.lagged, parts.get("y", x[:0]), noise.dW)

    def index_lost(self, t: float, h: float, parts: Parts, noise: Increment) -> Mask:
        """Return the paths on which du/dy changes sign, or no y is found, within a step of Euler's method.

        A solution ends at a point where du/dy is singular, because the equation has index 1 no longer.

        Parameters
        ----------
        t, h : float
            Beginning and length of the step.
        parts : mapping of str to ndarray
            x and y at its beginning.
        noise : Increment
            Of the step, the lagged values included.

        Returns
        -------
        ndarray of bool, shape (P,)
        """
        x, y = parts["x"], parts.get("y")
        if self.constraint is None or y is None:
            return super().index_lost(t, h, parts, noise)
        lag = self.lag(x, h, noise)
        later = x + h * self.drift(t, x, lag.now, y) + self.diffused(t, x, lag.now, y, noise.dW)
        found = solve_algebraic(self, t + h, later, lag.ahead(later), y)
        begin = self.linearised_constraint(t, x, lag.now, y).y
        end = self.linearised_constraint(t + h, later, lag.ahead(later), found).y
        return np.asarray(~(determinant(begin) * determinant(end) > 0.0))

    def without_index(self, t: float, x: Array, v: Array) -> Mask:
        """Return the paths on which no y is found at x and lagged v, or det du/dy has another sign than at time 0.

        The determinant is continuous and nonzero along a solution of index 1. So no solution reaches a point where
        its sign differs, even if the equation with y eliminated does.

        Parameters
        ----------
        t : float
        x, v : ndarray, shape (d, P)

        Returns
        -------
        ndarray of bool, shape (P,)
        """
        if self.constraint is None:
            return super().without_index(t, x, v)
        start, past = self.initial(1), self.past(-self.delay)
        before = determinant(self.linearised_constraint(0.0, start.x, past, start.y).y)
        now = determinant(self.linearised_constraint(t, x, v, self.eliminated(t, x, v)).y)
        return np.asarray(~(before * now > 0.0))

    @cached_property
    def _compared(self) -> SDE:
        return self._make_sde(_Compared)

    def _make_sde(self, kind: type[SDE] = SDE) -> SDE:
        plain, y = self.without_y(), np.zeros((0, 1))
        return kind(
            drift=lambda t, x: plain.drift(t, x, x, y),
            diffusion=lambda t, x: plain.diffusion(t, x, x, y),
            start=self.past(0.0)[:, 0],
            **self.shared_fields,
            source=f"y eliminated from: {self.source}",
            seen_as="SDE",
        )

    @cached_property
    def _start_y(self) -> Array:
        if self.algebraic is None:
            return np.zeros(0)
        if not _is_number(self.algebraic):
            return vector("algebraic", self.algebraic)
        x, v, zeros = self.past(0.0), self.past(-self.delay), np.zeros((self.constraints, 1))
        y = self.solved(0.0, x, v) if self.solved else solve_algebraic(self, 0.0, x, v, zeros)
        if not np.isfinite(y).all():
            text = "the constraint has no solution y at time 0 that Newton's method finds from 0"
            raise ProblemError(f"{text}; give algebraic=[y(0)]")
        return np.asarray(y[:, 0])

    def _check_functions(self) -> None:
        d, q = self.dimension, self.constraints
        (x, y), v = self.initial(PROBES), np.repeat(self.past(-self.delay), PROBES, axis=1)
        check_shape(f"drift({self.arguments})", self.drift(0.0, x, v, y), (d, PROBES))
        check_shape(f"diffusion({self.arguments})", self.diffusion(0.0, x, v, y), (d, self.noise_dim, PROBES))
        check_jacobians(self, x, v, y)
        if self.constraint is None:
            return
        u = self.constraint(0.0, x, v, y)
        check_shape(f"constraint({self.arguments})", u, (q, PROBES))
        check_regular(self, x, v, y)
        check_solved(self, x, v)
        if np.abs(u).max() > CONSISTENCY * size_of_terms(self, x, v, y):
            given = format_value(numbers(y[:, 0]).tolist())  # type: ignore[union-attr]
            solution = format_value(self.eliminated(0.0, x, v)[:, 0].tolist())
            raise ProblemError(
                f"algebraic: y = {given} at time 0 violates constraint = 0; it is solved by {solution}"
            )


def solve_algebraic(problem: "DelaySDAE", t: float, x: Array, v: Array, guess: Array) -> Array:
    """Return the y that solves 0 = u(t, x, v, y), by Newton's method; NaN on paths where it fails.

    x and v may be complex, for a derivative by complex step: y then has the derivative of the solution, which one
    further update of Newton's method at the real solution computes exactly.

    Parameters
    ----------
    problem : DelaySDAE
    t : float
    x, v : ndarray, shape (d, P)
    guess : ndarray, shape (q, P) or (q, 1)
        Initial iterate.

    Returns
    -------
    ndarray, shape (q, P)
    """
    constraint = problem.constraint
    assert constraint is not None
    real, lagged = np.real(x), np.real(v)

    def matrix(y: Array) -> Array:
        return problem.linearised_constraint(t, real, lagged, y).y

    def linearise(y: Array) -> tuple[Array, Callable[[], Array]]:
        return constraint(t, real, lagged, y), lambda: matrix(y)

    begin = np.broadcast_to(guess, (len(guess), x.shape[-1]))
    root = newton(linearise, begin, update_tolerance(largest(begin), largest(real)))
    y = np.where(root.converged, root.x, np.nan)
    if not (np.iscomplexobj(x) or np.iscomplexobj(v)):
        return y
    return y - solve(matrix(y), constraint(t, x, v, y))
