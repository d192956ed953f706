"""Identification of the equation that a wrong step solves, from its rates: common mistakes in schemes.

As h -> 0 a step has the rates f_0 = lim E Delta/h and Q_0 = lim E Delta Delta^T/h. If these are not f and B B^T,
the step solves another equation. A mistake is named only if it explains both rates at all probed states, to the
resolution of the limits, and if no other mistake does.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...errors import FAULTS
from ...forms import Damped, Equation, Problem
from ..step.nodes import Nodes, law_nodes
from ..step.one_step import STILL, OneStep
from .step_law import equation_rates, short_steps

# Step size in units of time, ratio and number of sizes: rates are extrapolated to eliminate their errors in h and
# h^2.
SIZE, RATIO, LEVELS = 2.0**-10, 2.0, 3
# Relative accuracy of the limits of rates with an expansion in h, and the smallest relative deviation that counts as
# a mistake.
RESOLUTION, DEFECT = 2e-5, 1e-3
# Part of the exact variance below which there is no noise but rounding; a noise h dW has 1e-7.
NO_NOISE = 1e-12
# Numbers of times and states at which rates are compared, and the largest growth of states.
# Size: times and states.
TIMES, STATES, GROWN = 5, 6, 10.0
# Relative step of the difference quotients of the diffusion along its columns.
ALONG = 1e-5
# Factors that change friction and strength, to distinguish 1/gamma from gamma; powers that are tested.
CHANGED, POWERS = (1.37, 1.21), (-2, -1, 0, 1, 2)
# Factors that common mistakes have for any equation; other factors are reported only if the correction is no multiple
# of the drift.
SIMPLE = (0.0, 1.0, -1.0, 0.5, 2.0)
# Exponents s of a noise xi h^s in place of xi sqrt(h), with their descriptions.
SCALINGS = {
    1.0: "the noise is h xi where sqrt(h) xi is meant: it does not scale with sqrt(h)",
    1.5: "the noise is h dW where dW is meant: it is multiplied by the step size",
    0.0: "the noise is xi where sqrt(h) xi is meant: it does not scale with sqrt(h)",
}


class Rates(NamedTuple):
    """Rates of mean and square of an equation, or of short steps, at n points.

    Attributes
    ----------
    f : ndarray, shape (d, n)
    Q : ndarray, shape (d, d, n)
    """

    f: Array
    Q: Array


@dataclass(frozen=True, eq=False)
class Given:
    """The equation given to a step, at n points of one time.

    Attributes
    ----------
    equation : Equation
    t : float
    x : ndarray, shape (d, n)
    """

    equation: Equation
    t: float
    x: Array

    def drift(self, t: float | None = None) -> Array:
        """Return f, shape (d, n), at the points, by default at their time."""
        return np.broadcast_to(self.equation.drift(self.t if t is None else t, self.x), self.x.shape)

    def diffusion(self, t: float | None = None, x: Array | None = None) -> Array:
        """Return B, shape (d, l, n), by default at the points and their time."""
        at = self.x if x is None else x
        B = self.equation.diffusion(self.t if t is None else t, at)
        return np.broadcast_to(B, (len(at), self.equation.noise_dim, at.shape[1]))

    @cached_property
    def correction(self) -> Array:
        """Half the sum of DB_j B_j, the difference between the drifts of Ito and Stratonovich, shape (d, n)."""
        total = np.zeros(self.x.shape)
        for j in range(self.equation.noise_dim):
            column = self.diffusion()[:, j]
            eps = ALONG * (1.0 + np.abs(self.x).max()) / (1.0 + np.abs(column).max())
            ahead, behind = (self.diffusion(x=self.x + sign * eps * column)[:, j] for sign in (1.0, -1.0))
            total += (ahead - behind) / (4.0 * eps)
        return total

    @property
    def rates(self) -> Rates:
        """Rates f and B B^T of the equation at the points."""
        return Rates(self.drift(), squares(self.diffusion()))


def squares(B: Array) -> Array:
    """Return B B^T, shape (d, d, n)."""
    return np.asarray(np.einsum("ikn,jkn->ijn", B, B))


class Mistake(NamedTuple):
    """A mistake and the rates that result from it.

    Attributes
    ----------
    drift, noise : callable, Given -> ndarray, or None
        Return f_0, shape (d, n), and columns whose squares are Q_0, shape (d, l, n); None if unchanged.
    sentence : str
    """

    drift: Callable[[Given], Array] | None
    noise: Callable[[Given], Array] | None
    sentence: str

    @property
    def changes(self) -> int:
        """Number of changed coefficients, of drift and diffusion."""
        return (self.drift is not None) + (self.noise is not None)


def _summed(given: Given) -> Array:
    return np.asarray(given.diffusion().sum(axis=1, keepdims=True))


def _first(given: Given) -> Array:
    return given.diffusion()[:, :1]


def _transposed(given: Given) -> Array:
    B = given.diffusion()
    return B.swapaxes(0, 1) if B.shape[0] == B.shape[1] else np.full(B.shape, np.nan)


def _squared(given: Given) -> Array:
    return squares(given.diffusion())


def _own_sizes(given: Given) -> Array:
    """Return the diagonal matrix of row lengths of B: independent noises of the right size in each component."""
    sizes = np.sqrt((given.diffusion() ** 2).sum(axis=1))
    return np.asarray(np.einsum("in,ij->ijn", sizes, np.eye(len(sizes))))


MISTAKES = (
    Mistake(
        lambda g: g.drift() + g.correction,
        None,
        "dx = (f + (1/2) sum DB_j B_j) dt + B dW: Ito's equation is given, Stratonovich's is solved",
    ),
    Mistake(
        lambda g: g.drift() - g.correction,
        None,
        "dx = (f - (1/2) sum DB_j B_j) dt + B dW: the drift is Stratonovich's, the noise is Ito's",
    ),
    Mistake(
        lambda g: g.drift() + 2.0 * g.correction,
        None,
        "dx = (f + sum DB_j B_j) dt + B dW: the noise is evaluated at the end of the step (backward Ito)",
    ),
    Mistake(
        lambda g: g.drift() - 2.0 * g.correction,
        None,
        "dx = (f - sum DB_j B_j) dt + B dW: the whole correction is subtracted, and the noise is Ito's",
    ),
    Mistake(None, _summed, "all Brownian motions share one increment"),
    Mistake(None, _first, "only the first Brownian motion acts"),
    Mistake(None, _transposed, "the diffusion is transposed: B^T dW"),
    Mistake(None, _squared, "the covariance is used in place of the diffusion: B B^T dW"),
    Mistake(None, _own_sizes, "the noises of the components are independent, their correlation is lost"),
    Mistake(lambda g: g.drift(0.0), lambda g: g.diffusion(0.0), "the coefficients are evaluated at t = 0"),
    Mistake(lambda g: g.drift(0.0), None, "the drift is evaluated at t = 0"),
    Mistake(None, lambda g: g.diffusion(0.0), "the diffusion is evaluated at t = 0"),
)


def solved_instead(scheme: Scheme, view: Problem) -> str:
    """Return a sentence on the equation that a step solves instead of that of a problem, or an empty string.

    It is empty if the step solves the right equation, if no known mistake explains its rates, and if several
    mistakes do.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    """
    try:
        with np.errstate(all="ignore"):
            step = short_steps(scheme, view)
            if step is not None and step.is_still(SIZE * step.time_unit):
                return STILL
            # On a manifold the correction is a multiple of the drift or of normals, so that too many mistakes would
            # explain the rates.
            measured = None if view.has_constraints else _measured(scheme, view)
            if measured is None or not measured.differs:
                return ""
            dynamics = view.capability(Damped)
            found = _of_langevin(scheme, dynamics) if dynamics is not None else _of_equation(measured)
    except FAULTS:
        return ""
    return found


class Measured(NamedTuple):
    """Rates of short steps, the equation that they are given at a few times, and the exponent of their noise in h."""

    given: list[Given]
    rates: list[Rates]
    power: float

    @property
    def differs(self) -> bool:
        """Whether a step has other rates than the equation."""
        return not self.explained_by([each.rates for each in self.given], DEFECT) or self.power != 0.5

    def explained_by(self, rates: Sequence[Rates], tolerance: float = RESOLUTION) -> bool:
        """Return whether given rates are those of the step, relative to the sizes of both."""
        exact = [each.rates for each in self.given]
        return all(
            _near(own.f, other.f, tolerance, right.f) and _near(own.Q, other.Q, tolerance, right.Q)
            for own, other, right in zip(self.rates, rates, exact, strict=True)
        )


def _near(a: Array, b: Array, tolerance: float, right: Array) -> bool:
    """Return whether two rates agree at all points, relative to both and to the exact one."""
    axes = tuple(range(a.ndim - 1))
    size = np.abs(a).max(axis=axes) + np.abs(b).max(axis=axes) + np.abs(right).max(axis=axes)
    return bool((np.abs(a - b).max(axis=axes) <= tolerance * (size + 1e-3 * size.max(initial=0.0))).all())


def _measured(scheme: Scheme, view: Problem) -> Measured | None:
    """Return the rates of short steps at states that solutions reach; None if steps cannot be compared."""
    step = short_steps(scheme, view)
    if step is None:
        return None
    points = equation_rates(step.view, step.equation)
    sizes = np.abs(points.x).max(axis=(1, 2))
    # Solutions of random equations may grow so large that no step size is small.
    known = np.flatnonzero(np.isfinite(sizes) & (sizes <= GROWN * (1.0 + sizes[0])))
    if not known.size:
        return None
    when = np.unique(known[np.linspace(0, len(known) - 1, TIMES).astype(int)])
    return measured_at(step, [Given(step.equation, float(points.t[k]), points.x[k, :, -STATES:]) for k in when])


def measured_at(step: OneStep, given: list[Given]) -> Measured | None:
    """Return the rates of short steps at some points; None where they have no limit."""
    nodes, other = law_nodes(step.view.noise_dim, step.scheme.noise, step.scheme.law)
    power = _power(step, given, nodes)
    if power is None:
        return None
    rates = [_limits(step, each, nodes, power) for each in given]
    again = [_limits(step, each, other, power, 0.75) for each in given]
    measured = Measured(given, rates, power)
    # Without an expansion in h, or with two limits, the step solves no equation.
    return measured if measured.explained_by(again) else None


def _power(step: OneStep, given: Sequence[Given], nodes: Nodes) -> float | None:
    """Return the exponent s of the noise of a step in h, 1/2 if there is no noise; None if no exponent fits."""
    h = SIZE * step.time_unit
    sizes = [max(np.abs(_central(step, each, nodes, a)).max() for each in given) for a in (h, 0.25 * h)]
    exact = max(np.abs(each.rates.Q).max() for each in given)
    if not sizes[1] > NO_NOISE * h * exact:
        return 0.5
    found = 0.5 * float(np.log2(sizes[0] / sizes[1])) / 2.0
    near = min((0.0, 0.5, 1.0, 1.5), key=lambda s: abs(s - found))
    return near if abs(near - found) < 0.05 else None


def _moves(step: OneStep, given: Given, nodes: Nodes, h: float) -> Array:
    """Return the displacements of a step of size h, shape (d, n, K)."""
    wide = np.repeat(given.x, len(nodes.weights), axis=1)
    made = step.make(wide.copy(), given.t, h, nodes.increment(h, given.x.shape[1]))
    return np.asarray((step.read(made.state) - wide).reshape(*given.x.shape, -1))


def _central(step: OneStep, given: Given, nodes: Nodes, h: float) -> Array:
    moves = _moves(step, given, nodes, h)
    moves = moves - (moves @ nodes.weights)[..., None]
    return np.asarray(np.einsum("ink,jnk,k->ijn", moves, moves, nodes.weights))


def _limits(step: OneStep, given: Given, nodes: Nodes, power: float, part: float = 1.0) -> Rates:
    """Return the limits of E Delta/h and of the covariance over h^(2 s), extrapolated from three step sizes."""
    sizes = [part * SIZE * step.time_unit * RATIO**-k for k in range(LEVELS)]
    means = [_moves(step, given, nodes, h) @ nodes.weights / h for h in sizes]
    covariances = [_central(step, given, nodes, h) / h ** (2.0 * power) for h in sizes]
    return Rates(_extrapolated(means), _extrapolated(covariances))


def _extrapolated(values: list[Array]) -> Array:
    for k in range(1, len(values)):
        values = [(RATIO**k * b - a) / (RATIO**k - 1.0) for a, b in pairwise(values)]
    return values[0]


def _of_equation(measured: Measured) -> str:
    """Return the sentence of the mistake that explains the rates; factors last, which often fit linear equations."""
    if measured.power != 0.5:
        right = measured.explained_by([each.rates for each in measured.given])
        return SCALINGS[measured.power] if right else ""
    found = [*_explanations(measured)]
    if not found:
        return _scaled(measured)
    # If the diffusion is constant, a mistake that also changes its time explains no more than one that does not.
    fewest = min(each.changes for each in found)
    sentences = {each.sentence for each in found if each.changes == fewest}
    return sentences.pop() if len(sentences) == 1 else ""


def _explanations(measured: Measured) -> Iterator[Mistake]:
    """Yield the mistakes whose rates agree with the measured ones at all times and states."""
    for mistake in MISTAKES:
        changed = [
            Rates(
                mistake.drift(each) if mistake.drift else each.rates.f,
                squares(mistake.noise(each)) if mistake.noise else each.rates.Q,
            )
            for each in measured.given
        ]
        if measured.explained_by(changed):
            yield mistake


def _scaled(measured: Measured) -> str:
    """Return the sentence on a drift and a noise that are multiples of those of the equation, or an empty string."""
    exact = [each.rates for each in measured.given]
    a, c = (
        _simple_factor([getattr(each, name) for each in measured.rates], [getattr(each, name) for each in exact])
        for name in ("f", "Q")
    )
    if measured.power != 0.5 or not measured.explained_by([Rates(a * each.f, c * each.Q) for each in exact]):
        return ""
    if a not in SIMPLE and _is_ambiguous(measured):
        return ""
    return ", ".join(filter(None, (_times("the drift", a), _noise_times(c))))


def _is_ambiguous(measured: Measured) -> bool:
    """Return whether the correction is a multiple of the drift, so that a factor of the drift may be due to it."""
    f, more = [each.drift() for each in measured.given], [each.correction for each in measured.given]
    factor = _factor(more, f)
    return factor != 0.0 and all(_near(factor * a, b, RESOLUTION, a) for a, b in zip(f, more, strict=True))


def _factor(found: Sequence[Array], exact: Sequence[Array]) -> float:
    a, b = (np.concatenate([each.ravel() for each in some]) for some in (found, exact))
    square = float(b @ b)
    return float(a @ b) / square if square else 1.0


def _simple_factor(found: Sequence[Array], exact: Sequence[Array]) -> float:
    """Return the factor between rates, rounded to a simple one if that agrees to the resolution."""
    factor = _factor(found, exact)
    return next((each for each in SIMPLE if abs(factor - each) <= RESOLUTION), factor)


def _times(what: str, factor: float) -> str:
    named = {0.0: "is left out", -1.0: "has the wrong sign", 0.5: "is halved", 2.0: "is doubled"}
    for value, words in named.items():
        if abs(factor - value) <= RESOLUTION:
            return f"{what} {words}"
    return "" if abs(factor - 1.0) <= DEFECT else f"{what} is multiplied by {factor:.4g}"


def _noise_times(factor: float) -> str:
    if abs(factor) <= RESOLUTION:
        return "the noise is left out"
    if abs(factor - 1.0) <= DEFECT:
        return ""
    return f"the variance of the noise is multiplied by {factor:.4g}, the noise by {np.sqrt(abs(factor)):.4g}"


# For Langevin dynamics, friction and strength are changed to determine the powers in which they enter.

STRENGTHS = {
    (1.0, -2, 0): "sqrt(2 kT/gamma) where sqrt(2 kT gamma) is meant",
    (1.0, -1, 0): "sqrt(2 kT) where sqrt(2 kT gamma) is meant",
    (0.5, 0, 0): "sqrt(kT gamma) where sqrt(2 kT gamma) is meant",
    (0.5, -1, 0): "sqrt(kT) where sqrt(2 kT gamma) is meant",
    (0.5, -2, 0): "sqrt(kT/gamma) where sqrt(2 kT gamma) is meant",
    (1.0, 0, 2): "2 kT gamma where its square root is meant",
    (1.0, 1, 0): "sigma sqrt(gamma) where sigma is meant: the strength already contains the friction",
    (1.0, 2, 0): "gamma sigma where sigma is meant: the variance is gamma^2 times too large",
}


def _of_langevin(scheme: Scheme, view: Any) -> str:
    """Return the sentence on a step of Langevin dynamics: factors of velocity, force, friction and noise."""
    views = [
        view,
        replace(view, friction=CHANGED[0] * view.friction),
        replace(view, strength=CHANGED[1] * view.strength),
    ]
    found = [_factors(scheme, each) for each in views]
    if any(each is None for each in found):
        return ""
    factors = np.array(found, dtype=float)
    powers = [_monomial(column, view) for column in factors.T]
    if any(each is None for each in powers):
        return ""
    speed, force, friction, noise = (each for each in powers if each is not None)
    words = (
        _plain("the velocity of the position", speed),
        _plain("the force", force),
        _friction(friction),
        _strength(noise),
    )
    return ", ".join(filter(None, words))


class _Monomial(NamedTuple):
    # The monomial kappa gamma^a sigma^b.
    kappa: float
    a: int
    b: int


def _factors(scheme: Scheme, view: Any) -> tuple[float, float, float, float] | None:
    """Return the factors of velocity, force, friction and variance of a step; None if these do not explain it."""
    measured = _measured(scheme, view)
    if measured is None or measured.power != 0.5:
        return None
    n = view.noise_dim
    q, p = (np.concatenate([each.x[rows] for each in measured.given], axis=1) for rows in (slice(n), slice(n, None)))
    f = np.concatenate([each.f for each in measured.rates], axis=1)
    F = np.broadcast_to(view.force(q), q.shape)
    speed = _factor([f[:n]], [p])
    columns = np.stack([F.ravel(), -view.friction * p.ravel()], axis=1)
    force, friction = np.linalg.lstsq(columns, f[n:].ravel(), rcond=None)[0]
    noise = _factor([each.Q[n:, n:] for each in measured.rates], [each.rates.Q[n:, n:] for each in measured.given])
    changed = [
        Rates(
            np.concatenate(
                [speed * each.x[n:], force * view.force(each.x[:n]) - friction * view.friction * each.x[n:]]
            ),
            noise * each.rates.Q,
        )
        for each in measured.given
    ]
    return (speed, float(force), float(friction), noise) if measured.explained_by(changed) else None


def _monomial(factors: Array, view: Any) -> _Monomial | None:
    """Return the monomial kappa gamma^a sigma^b that fits a factor at the changed friction and strength, or None."""
    base, of_friction, of_strength = map(float, factors)
    if np.abs(factors).max() <= RESOLUTION:
        return _Monomial(0.0, 0, 0)
    for a in POWERS:
        for b in POWERS:
            near = (of_friction - base * CHANGED[0] ** a, of_strength - base * CHANGED[1] ** b)
            if np.abs(near).max() <= 10.0 * RESOLUTION * np.abs(factors).max():
                return _Monomial(base / (view.friction**a * view.strength**b), a, b)
    return None


def _plain(what: str, of: _Monomial) -> str:
    if (of.a, of.b) == (0, 0):
        return _times(what, of.kappa)
    return f"{what} is multiplied by {_product(of)}"


def _friction(of: _Monomial) -> str:
    if (of.a, of.b) == (0, 0):
        return _times("the friction", of.kappa)
    return f"the friction is {_product(of._replace(a=of.a + 1))} where gamma is meant"


def _strength(of: _Monomial) -> str:
    for (kappa, a, b), words in STRENGTHS.items():
        if (of.a, of.b) == (a, b) and abs(of.kappa - kappa) <= 20.0 * RESOLUTION:
            return f"the noise is {words}"
    if (of.a, of.b) == (0, 0):
        return _noise_times(of.kappa)
    return f"the variance of the noise is multiplied by {_product(of)}"


def _product(of: _Monomial) -> str:
    parts = [f"{name}^{power}" if power != 1 else name for name, power in (("gamma", of.a), ("sigma", of.b)) if power]
    return " ".join(([f"{of.kappa:.4g}"] if abs(of.kappa - 1.0) > DEFECT or not parts else []) + parts)
