"""Identification of the equation that a wrong step solves, from its rates: common mistakes in schemes.

As h -> 0 a step has the rates f_0 = lim E Delta/h and Q_0 = lim E Delta Delta^T/h. If these are not f and B B^T,
the step solves another equation. A mistake is named only if it explains both rates at all probed states, to the
resolution of the limits, and if no other mistake does.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...errors import FAULTS
from ...forms import Damped, Problem
from ...numerics import norm
from ..mistakes.fitted_mistakes import factor_text, fitted_mistakes
from ..mistakes.given_rates import DEFECT, RESOLUTION, Given, Mistake, Rates, near, squares
from ..mistakes.used_noise import NONLINEAR, SIZE, moves_at, moves_of, used_noise
from ..step.nodes import Nodes, law_nodes
from ..step.one_step import STILL, OneStep
from .equation_rates import equation_rates
from .step_law import short_steps

# Words: ratio and number of step sizes: rates are extrapolated to eliminate their errors in h and h^2.
RATIO, LEVELS = 2.0, 3
# Words: part of the exact variance below which there is no noise but rounding; a noise h dW has 1e-7.
NO_NOISE = 1e-12
# Numbers of times and states at which rates are compared, and the largest growth of states.
# Size: times and states.
TIMES, STATES, GROWN = 5, 6, 10.0
# Words: factors that change friction and strength, to distinguish 1/gamma from gamma; powers that are tested.
CHANGED, POWERS = (1.37, 1.21), (-2, -1, 0, 1, 2)
# Exponents s of a noise xi h^s in place of xi sqrt(h), with their descriptions.
SCALINGS = {
    1.0: "the noise is h xi where sqrt(h) xi is meant: it does not scale with sqrt(h)",
    1.5: "the noise is h dW where dW is meant: it is multiplied by the step size",
    0.0: "the noise is xi where sqrt(h) xi is meant: it does not scale with sqrt(h)",
}


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


def _tamed(given: Given) -> Array:
    f = given.drift()
    return f / (1.0 + norm(f))


def _truncated(given: Given) -> Array:
    f = given.drift()
    return f / np.maximum(1.0, norm(f))


def _shifted(factor: float, sentence: str) -> Mistake:
    """Return the mistake of a drift that is off by a multiple of the correction."""
    return Mistake(lambda g: g.drift() + factor * g.correction, None, f"dx = (f {sentence}")


MISTAKES = (
    _shifted(1.0, "+ (1/2) sum DB_j B_j) dt + B dW: Ito's equation is given, Stratonovich's is solved"),
    _shifted(-1.0, "- (1/2) sum DB_j B_j) dt + B dW: the drift is Stratonovich's, the noise is Ito's"),
    _shifted(2.0, "+ sum DB_j B_j) dt + B dW: Ito's equation is given, the backward Ito equation is solved"),
    _shifted(-2.0, "- sum DB_j B_j) dt + B dW: the drift lacks the whole correction, twice that of Stratonovich"),
    Mistake(None, _summed, "all Brownian motions share one increment"),
    Mistake(None, _first, "only the first Brownian motion acts"),
    Mistake(None, _transposed, "the diffusion is transposed: B^T dW"),
    Mistake(None, _squared, "the covariance is used in place of the diffusion: B B^T dW"),
    Mistake(None, _own_sizes, "the noises of the components are independent, their correlation is lost"),
    Mistake(lambda g: g.drift(0.0), lambda g: g.diffusion(0.0), "the coefficients are evaluated at t = 0"),
    Mistake(lambda g: g.drift(0.0), None, "the drift is evaluated at t = 0"),
    Mistake(None, lambda g: g.diffusion(0.0), "the diffusion is evaluated at t = 0"),
    Mistake(lambda g: g.drift() * g.x, None, "the drift is multiplied by the state"),
    Mistake(None, lambda g: g.diffusion() * g.x[:, None], "the diffusion is multiplied by the state"),
    Mistake(_tamed, None, "the drift is f/(1 + |f|): it is tamed without the step size, at any step size"),
    Mistake(
        _truncated, None, "the drift is f min(1, 1/|f|): it is truncated without the step size, at any step size"
    ),
)


def solved_instead(scheme: Scheme, view: Problem, *, paths: bool = False) -> str:
    """Return a sentence on the equation that a step solves instead of that of a problem, or an empty string.

    It is empty if the step solves the right equation, and if no known mistake explains its rates. The mistake is the
    only one, with the same numbers, that explains the rates on a random equation of the form, too.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    paths : bool
        Whether the refuted claim is about paths, so that noise that is not dW but has its law is a mistake.
    """
    try:
        with np.errstate(all="ignore"):
            step = short_steps(scheme, view)
            if step is not None and step.is_still(SIZE * step.time_unit):
                return STILL
            # On a manifold the correction is a multiple of the drift or of normals, so that too many mistakes would
            # explain the rates.
            found = frozenset() if view.has_constraints else _sentences(scheme, view, paths=paths)
            other = view.random_like() if found else None
            if other is None or scheme.why_not(other):
                return ""
            both = found & _sentences(scheme, other, paths=paths)
            return next(iter(both)) if len(both) == 1 else ""
    except FAULTS:
        return ""


def _sentences(scheme: Scheme, view: Problem, *, paths: bool) -> frozenset[str]:
    """Return the sentences of the mistakes that explain the moves on one problem."""
    step = short_steps(scheme, view)
    given = [] if step is None else _points(step)
    if step is None or not given:
        return frozenset()
    measured, dynamics = measured_at(step, given), view.capability(Damped)
    if measured is not None and measured.power != 0.5:
        return _all(_of_power(measured))
    differs = measured if measured is not None and measured.differs else None
    if differs is not None and dynamics is None and (known := _explained(differs, MISTAKES)):
        return known | _all(_scaled(differs))
    moves = _of_moves(step, given, paths=paths)
    if differs is None or moves not in {"", NONLINEAR}:
        return _all(moves)
    # The law of a nonlinear function of the noise says more than that it is one.
    rates = _of_rates(differs) if dynamics is None else _all(_of_langevin(scheme, dynamics))
    return rates or _all(moves)


def _all(sentence: str) -> frozenset[str]:
    return frozenset({sentence} - {""})


def _of_moves(step: OneStep, given: Sequence[Given], *, paths: bool) -> str:
    """Return the sentence on the noise that a step uses, if it is the same for two rules."""
    rules = law_nodes(step.view.noise_dim, step.scheme.noise, step.scheme.law)
    found = {used_noise(moves_of(step, given, nodes), paths=paths) for nodes in rules}
    return found.pop() if len(found) == 1 else ""


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
            near(own.f, other.f, tolerance, right.f) and near(own.Q, other.Q, tolerance, right.Q)
            for own, other, right in zip(self.rates, rates, exact, strict=True)
        )


def _points(step: OneStep) -> list[Given]:
    """Return the equation at a few times, at states that solutions reach; empty if none is known."""
    points = equation_rates(step.view, step.equation)
    sizes = np.abs(points.x).max(axis=(1, 2))
    # Solutions of random equations may grow so large that no step size is small.
    known = np.flatnonzero(np.isfinite(sizes) & (sizes <= GROWN * (1.0 + sizes[0])))
    if not known.size:
        return []
    when = np.unique(known[np.linspace(0, len(known) - 1, TIMES).astype(int)])
    return [Given(step.equation, float(points.t[k]), points.x[k, :, -STATES:]) for k in when]


def _measured(scheme: Scheme, view: Problem) -> Measured | None:
    """Return the rates of short steps at states that solutions reach; None if steps cannot be compared."""
    step = short_steps(scheme, view)
    given = [] if step is None else _points(step)
    return measured_at(step, given) if step is not None and given else None


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


def _central(step: OneStep, given: Given, nodes: Nodes, h: float) -> Array:
    moves = moves_at(step, given, nodes, h)
    moves = moves - (moves @ nodes.weights)[..., None]
    return np.asarray(np.einsum("ink,jnk,k->ijn", moves, moves, nodes.weights))


def _limits(step: OneStep, given: Given, nodes: Nodes, power: float, part: float = 1.0) -> Rates:
    """Return the limits of E Delta/h and of the covariance over h^(2 s), extrapolated from three step sizes."""
    sizes = [part * SIZE * step.time_unit * RATIO**-k for k in range(LEVELS)]
    means = [moves_at(step, given, nodes, h) @ nodes.weights / h for h in sizes]
    covariances = [_central(step, given, nodes, h) / h ** (2.0 * power) for h in sizes]
    return Rates(_extrapolated(means), _extrapolated(covariances))


def _extrapolated(values: list[Array]) -> Array:
    for k in range(1, len(values)):
        values = [(RATIO**k * b - a) / (RATIO**k - 1.0) for a, b in pairwise(values)]
    return values[0]


def _of_power(measured: Measured) -> str:
    """Return the sentence on noise that does not scale with sqrt(h), or an empty string."""
    right = measured.explained_by([each.rates for each in measured.given])
    return SCALINGS[measured.power] if right else ""


def _of_rates(measured: Measured) -> frozenset[str]:
    """Return the sentences with numbers; they often fit linear equations, where they do not exclude factors."""
    pairs = [*zip(measured.given, measured.rates, strict=True)]
    return _explained(measured, fitted_mistakes(pairs)) | _all(_scaled(measured))


def _explained(measured: Measured, mistakes: Iterable[Mistake]) -> frozenset[str]:
    """Return the sentences of the mistakes with the fewest changes whose rates are the measured ones."""
    found = [each for each in mistakes if measured.explained_by([*map(each.rates, measured.given)])]
    # If the diffusion is constant, a mistake that also changes its time explains no more than one that does not.
    fewest = min((each.changes for each in found), default=0)
    return frozenset(each.sentence for each in found if each.changes == fewest)


def _scaled(measured: Measured) -> str:
    """Return the sentence on a drift and a noise that are multiples of those of the equation, or an empty string."""
    exact = [each.rates for each in measured.given]
    a, c = (
        _factor([getattr(each, name) for each in measured.rates], [getattr(each, name) for each in exact])
        for name in ("f", "Q")
    )
    if not measured.explained_by([Rates(a * each.f, c * each.Q) for each in exact]):
        return ""
    return ", ".join(filter(None, (factor_text("the drift", a), _noise_times(c))))


def _factor(found: Sequence[Array], exact: Sequence[Array]) -> float:
    a, b = (np.concatenate([each.ravel() for each in some]) for some in (found, exact))
    square = float(b @ b)
    return float(a @ b) / square if square else 1.0


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
    plain = _plain("the velocity of the position", speed), _plain("the force", force)
    return ", ".join(filter(None, (*plain, _friction(friction), _strength(noise))))


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
        return factor_text(what, of.kappa)
    return f"{what} is multiplied by {_product(of)}"


def _friction(of: _Monomial) -> str:
    if (of.a, of.b) == (0, 0):
        return factor_text("the friction", of.kappa)
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
