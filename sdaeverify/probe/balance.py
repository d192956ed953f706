"""Detailed balance of a step that accepts or rejects a proposal, without sampling.

Let rho be the invariant density of dx = -grad V dt + sigma dW. A step proposes y = g(x, dW) and accepts it with
probability a(x, y); otherwise the state stays at x. With the density q of the proposal,

    rho(x) q(x, y) a(x, y) = rho(y) q(y, x) a(y, x)    for all x and y

makes rho invariant under the step (Hastings 1970). Each factor is computed from the step alone, at states that
solutions reach: a(x, y) by bisection of the uniform variable that the step uses to decide,
q(x, y) = n(dW)/|det dg/dW| with the normal density n of dW, and the increment that proposes x from y by Newton's
method.
"""

from typing import Any, NamedTuple

import numpy as np
import scipy

from ..arrays import Array, Mask
from ..contracts.scheme import Scheme, flatten
from ..forms import Problem
from ..noise.brownian import Increment
from .step.nodes import SEED
from .step.one_step import OneStep
from .step.states import WHEN, reached_states

# Number of pairs of x and y at each step size.
# Size: pairs that are compared.
PAIRS = 64
# Share of pairs with uniform increments, and their largest size in standard deviations, which has a mass of 7e-6.
# Size: of the share, and of what is looked for.
SOME, FAR = 0.25, 4.5
# Uniform variables at which acceptance is evaluated; an interval in which it changes is bisected. The extremes stand
# for 0 and 1.
GRID = np.array([1e-300, 1e-12, 1e-6, 1e-3, *np.linspace(0.05, 0.95, 10), 1.0 - 1e-3, 1.0 - 1e-6, 1.0 - 1e-12])
# Bisections of an interval of the grid, down to rounding errors of numbers near 1.
# Rounding: after 52 bisections an interval of length 1 has the length 2^-52, that is eps.
BISECTIONS = 52
# Error of an acceptance that is located in this way, with the rounding error of a uniform variable near 1.
# Rounding: 2^-52, and eps of the variable.
LOCATED = 2.0**-51
# Gauss-Legendre nodes of the integral of the drift from x to y; the difference between the two rules estimates its
# error.
# Size: nodes of a rule; the difference of the two is added to the accepted one.
NODES = (32, 24)
# Newton iterations for an increment; half width d of central differences of the proposal in units of sqrt(h);
# accepted relative residual.
# Size: iterations; a pair without a root is left out.
# Rounding: a difference errs by eps/d = 2e-12 of the state, and by d^2/6 = 2e-9 of a third derivative. A residual of
# 1e-10 changes a logarithm by 1e-10/sqrt(h), which is below `ALIKE` for h > 1e-8.
NEWTON, WIDTH, REACHED = 12, 1e-4, 1e-10
# A pair counts if either acceptance is at least this large: smaller ones are known with few digits.
# Rounding: a change that is located to 2^-52 is known to 2e-10 of an acceptance of 1e-6.
LEAST = 1e-6
# Accepted difference of the logarithms of both sides, due to differences of the proposal, in addition to the
# integral's error.
# Rounding: d^2/6 = 2e-9 of a third derivative for d = `WIDTH`, in each of two proposals.
ALIKE = 1e-6

# Acceptances between these bounds determine the weights of their logarithm.
# Rounding: located to 2^-52, the logarithm of an acceptance 1 - 1e-9 is known to 2e-7 of itself.
FEW, SURE = 1e-6, 1.0 - 1e-9
# Error of the logarithms of acceptances, due to differences of the proposal; also the tolerance for recognised
# weights.
# Words: which mistake a reason names; that balance fails is known by `ALIKE`.
KNOWN = 1e-5
# Smallest number of acceptances per weight for a fit.
# Size: data of a fit, whose residual is bounded by the constant above.
TIMES = 4


class Balance(NamedTuple):
    """Detailed balance for pairs of states at some step sizes, shape (H, N); NaN for pairs that are not usable.

    Attributes
    ----------
    density : ndarray
        log rho(y) - log rho(x).
    proposals : ndarray
        log q(y, x) - log q(x, y).
    forth, back : ndarray
        a(x, y) and a(y, x).
    off : ndarray
        Bound of the error of the difference of both sides, as logarithms.
    shift, square : ndarray
        (y - x) . (m(x) + m(y)) and (|m(x)|^2 - |m(y)|^2)/2 over the variance of the proposal, m(x) = g(x, 0) - x. For
        a normal proposal log q(y, x) - log q(x, y) = square - shift.
    """

    density: Array
    proposals: Array
    forth: Array
    back: Array
    off: Array
    shift: Array
    square: Array

    @property
    def defect(self) -> Array:
        """Value of log[rho(x) q(x, y) a(x, y)] - log[rho(y) q(y, x) a(y, x)], shape (H, N)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.log(self.forth) - np.log(self.back) - self.density - self.proposals)

    @property
    def seen(self) -> Mask:
        """Mask of the usable pairs, shape (H, N)."""
        return np.asarray(np.isfinite(self.density + self.proposals))

    @property
    def fails(self) -> Mask:
        """Mask of the usable pairs at which detailed balance fails, shape (H, N).

        Of a small acceptance the logarithm is not known, but the acceptance itself is, to `LOCATED`.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            ratio = np.exp(self.density + self.proposals)
            known = (np.abs(self.forth - self.back * ratio), np.abs(self.back - self.forth / ratio))
        off = np.abs(self.defect) > self.off
        return np.asarray(self.seen & off & ~(np.fmin(*known) <= LOCATED))

    @property
    def holds(self) -> bool:
        """Whether detailed balance holds at all usable pairs, and most pairs at each step size are usable."""
        return bool(self.seen.mean(axis=1).min() > 0.5 and not self.fails.any())


def why_not_balanced(scheme: Scheme, view: Any) -> str:
    """Return why detailed balance of a step cannot be probed, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    """
    if view.equation() is None or not _has_density(view):
        return "no invariant density is known from the drift"
    step = OneStep(scheme, view)
    if scheme.noise - {"dW", "H"} or scheme.law.bounded or view.records:
        return "a step uses noise other than normal dW and H"
    if step.why_not_comparable() or view.noise_dim != step.equation.dimension:
        return "the noise and the state of the proposal do not have the same components"
    if len(flatten(step.enter(step.equation.initial(1), 0.0, view.horizon))) > step.equation.dimension:
        return "the scheme has memory"
    return ""


def _has_density(view: Any) -> bool:
    scalar = view.noise_dim == 1 and {"additive-noise", "scalar-noise"} <= view.traits
    return scalar or "overdamped-gradient" in view.traits


def balance(scheme: Scheme, view: Problem, sizes: list[float]) -> Balance | None:
    """Return densities and acceptances for pairs of states, or None if the step does not accept or reject.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_balanced` is empty for the pair.
    sizes : list of float
        Step sizes.
    """
    step = OneStep(scheme, view)
    # A step may depend on time: each size is probed at another time.
    when = view.horizon * (WHEN * np.arange(1.0, 1.0 + len(sizes)) % 1.0)
    with np.errstate(all="ignore"):
        rng = np.random.Generator(np.random.Philox(key=SEED + 16))
        found = [_Metropolis(step, t, h).between(rng) for t, h in zip(when.tolist(), sizes, strict=True)]
    known = [each for each in found if each is not None]
    return Balance(*map(np.stack, zip(*known, strict=True))) if len(known) == len(found) else None


class _Metropolis:
    """A step of one size, as a proposal and its acceptance probability.

    Parameters
    ----------
    step : OneStep
    t, h : float
        Start and size of the step.
    """

    def __init__(self, step: OneStep, t: float, h: float) -> None:
        self.step, self.t, self.h = step, t, h
        self.decides = "H" in step.scheme.noise
        # Value of the uniform variable at which a proposal is accepted if it can be accepted.
        self.least = GRID[0]

    def between(self, rng: np.random.Generator) -> Balance | None:
        """Return the quantities of `Balance` for N pairs, or None if the step does not accept or reject.

        Increments are normal, and some of them uniform up to `FAR` standard deviations: a step that accepts rare
        proposals in another way than most ones is seen.
        """
        equation = self.step.equation
        points = reached_states(self.step.view, equation).points
        x = points[:, rng.integers(points.shape[1], size=PAIRS)]
        normal = rng.standard_normal((equation.noise_dim, PAIRS))
        far = rng.uniform(-FAR, FAR, normal.shape)
        dW = np.sqrt(self.h) * np.where(rng.uniform(size=PAIRS) < SOME, far, normal)
        forth = self._acceptance(x, dW)
        if forth is None:
            return None
        y = self._end(x, dW, self.least)
        back_dW, reached = self._increment(y, x, -dW)
        back = self._acceptance(y, back_dW)
        if back is None:
            return None
        density, off = _log_density_ratio(self.step, self.t, x, y)
        proposals = self._log_proposal(y, back_dW) - self._log_proposal(x, dW)
        seen = reached & (np.maximum(forth, back) >= LEAST) & (y != x).any(axis=0)
        density, proposals = (np.where(seen, each, np.nan) for each in (density, proposals))
        return Balance(density, proposals, forth, back, ALIKE + off, *self._regressors(x, y))

    def _end(self, x: Array, dW: Array, u: Array | float) -> Array:
        """Return the result of the step for a uniform variable u."""
        uniform = np.broadcast_to(scipy.special.ndtri(u), dW.shape)
        return self.step(x, self.t, self.h, Increment(dW, np.sqrt(self.h / 12.0) * uniform))

    def _acceptance(self, x: Array, dW: Array) -> Array | None:
        """Return a(x, g(x, dW)), shape (N,), or None if the result depends on u other than by acceptance."""
        if not self.decides:
            return np.ones(x.shape[1])
        ends = np.stack([self._end(x, dW, u) for u in GRID])
        taken = (ends != x).any(axis=1)
        first = np.where(taken[0], 0, -1)
        if (taken[0] < taken[-1]).any():
            self.least, first = GRID[-1], np.where(taken[-1], len(GRID) - 1, -1)
        proposal = ends[first, :, np.arange(x.shape[1])].T
        alone = (ends == proposal).all(axis=1) | ~taken
        turns = np.count_nonzero(np.diff(taken, axis=0), axis=0)
        if not (alone.all() and (turns <= 1).all()):
            return None
        share = self._bisect(x, dW, taken)
        return np.asarray(share if self.least == GRID[0] else 1.0 - share)

    def _bisect(self, x: Array, dW: Array, taken: Mask) -> Array:
        """Return the uniform variable at which acceptance changes; 1 or 0 if it is the same for all."""
        turn = np.argmax(np.diff(taken, axis=0), axis=0)
        low, high, begin = GRID[turn], GRID[np.minimum(turn + 1, len(GRID) - 1)], taken[0]
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            same = (self._end(x, dW, middle) != x).any(axis=0) == begin
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        # Without a change, the proposal is always or never accepted.
        always = np.where(begin == (self.least == GRID[0]), 1.0, 0.0)
        return np.where((taken == taken[:1]).all(axis=0), always, high)

    def _increment(self, y: Array, x: Array, guess: Array) -> tuple[Array, Mask]:
        """Return dW with g(y, dW) = x, and a mask of the paths on which it was found."""
        dW, scale = guess, 1.0 + np.abs(x).max(axis=0)
        for _ in range(NEWTON):
            off = self._end(y, dW, self.least) - x
            dW = dW - np.linalg.solve(self._slope(y, dW).transpose(2, 0, 1), off.T[..., None])[..., 0].T
        found = np.abs(self._end(y, dW, self.least) - x).max(axis=0) <= REACHED * scale
        return dW, found

    def _slope(self, x: Array, dW: Array) -> Array:
        """Return the derivative of the proposal with respect to dW, shape (d, d, N)."""
        width = WIDTH * np.sqrt(self.h)
        units = width * np.eye(len(dW))[..., None]
        columns = [self._end(x, dW + e, self.least) - self._end(x, dW - e, self.least) for e in units]
        found = np.stack(columns, axis=1) / (2.0 * width)
        singular = ~np.isfinite(found).all(axis=(0, 1)) | (np.abs(np.linalg.det(found.transpose(2, 0, 1))) == 0.0)
        return np.where(singular, np.eye(len(dW))[..., None], found)

    def _log_proposal(self, x: Array, dW: Array) -> Array:
        """Return log q(x, g(x, dW)) up to a constant."""
        return np.asarray(-0.5 * (dW**2).sum(axis=0) / self.h - np.log(self._volume(x, dW)))

    def _volume(self, x: Array, dW: Array) -> Array:
        """Return |det dg/dW| of the proposal at x, shape (N,)."""
        return np.asarray(np.abs(np.linalg.det(self._slope(x, dW).transpose(2, 0, 1))))

    def _regressors(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return `shift` and `square` of `Balance`."""
        still = np.zeros_like(x)
        variance = self.h * self._volume(x, still) ** (2.0 / len(x))
        at_x, at_y = (self._end(z, still, self.least) - z for z in (x, y))
        shift = ((y - x) * (at_x + at_y)).sum(axis=0) / variance
        return shift, ((at_x**2).sum(axis=0) - (at_y**2).sum(axis=0)) / (2.0 * variance)


def _log_density_ratio(step: OneStep, t: float, x: Array, y: Array) -> tuple[Array, Array]:
    """Return log rho(y) - log rho(x) = (2/sigma^2) int_x^y f, and its error estimate, each of shape (N,)."""
    variance, found = step.equation.diffusion(t, x)[0, 0] ** 2, []
    for count in NODES:
        nodes, weights = np.polynomial.legendre.leggauss(count)
        drift = (
            w * step.equation.drift(t, x + 0.5 * (1.0 + z) * (y - x)) for z, w in zip(nodes, weights, strict=True)
        )
        found.append(((y - x) * sum(drift)).sum(axis=0) / variance)
    return found[0], np.abs(found[0] - found[1])


# Terms of a wrong acceptance probability.


class Weights(NamedTuple):
    """Weights of an acceptance: its log is density (log rho(y) - log rho(x)) - shift S + square Q, if negative.

    S and Q are those of `Balance`. All three weights are 1 for the acceptance probability of Metropolis and Hastings.

    Attributes
    ----------
    density, shift, square : float
    """

    density: float
    shift: float
    square: float


# Known mistakes in the acceptance probability, with their descriptions.
MISTAKES = {
    Weights(1.0, 0.0, 0.0): "lacks the densities of the proposals",
    Weights(0.0, 1.0, 1.0): "lacks the invariant density",
    Weights(1.0, -1.0, -1.0): "has the densities of the forward and the reverse proposal exchanged",
    Weights(-1.0, 1.0, 1.0): "has the invariant densities of the current and the proposed state exchanged",
    Weights(-1.0, -1.0, -1.0): "has its ratio upside down",
    Weights(1.0, 1.0, -1.0): "evaluates the drift in the density of each proposal at the wrong state",
}
POWER = "has the invariant density to the power {density:.3g}"
OTHER = "has the density of another proposal, of {drift:.3g} times its drift and {variance:.3g} times its variance"


def say_imbalance(found: Balance) -> str:
    """Describe the failure of detailed balance: the mistake that explains all acceptances, or the size of the defect.

    Parameters
    ----------
    found : Balance
    """
    seen, defect = found.seen, np.abs(found.defect)
    text = f"detailed balance fails for {int(found.fails.sum())} of {seen.sum()} pairs of states"
    if (found.forth[seen] == 1.0).all() and (found.back[seen] == 1.0).all():
        return f"{text}: each proposal is accepted"
    mistake = _mistake(found) or f"is off by a factor of up to {np.exp(defect[seen].max()):.3g}"
    return f"{text}: the acceptance {mistake}"


def _mistake(found: Balance) -> str:
    """Describe the mistake that explains all acceptances, or return an empty string."""
    if named := [words for weights, words in MISTAKES.items() if explains(weights, found)]:
        return " or ".join(named)
    weights = fitted_weights(found)
    if weights is None or not explains(weights, found):
        return ""
    if np.allclose(weights[1:], 1.0, rtol=0.0, atol=KNOWN):
        return POWER.format(density=weights.density)
    if abs(weights.density - 1.0) <= KNOWN and min(weights) > 0.0:
        drift = weights.square / weights.shift
        return OTHER.format(drift=drift, variance=drift / weights.shift)
    return ""


def explains(weights: Weights, found: Balance) -> bool:
    """Return whether acceptances in both directions follow from given weights.

    Parameters
    ----------
    weights : Weights
    found : Balance
    """
    terms, accepted = _equations(found)
    expected = np.exp(np.minimum(terms @ np.array(weights), 0.0))
    off = np.abs(np.log(np.maximum(expected, FEW)) - np.log(np.maximum(accepted, FEW)))
    return bool((off <= KNOWN).all())


def fitted_weights(found: Balance) -> Weights | None:
    """Return the least-squares weights of the acceptances, or None if these do not determine all three.

    Parameters
    ----------
    found : Balance
    """
    terms, accepted = _equations(found)
    inner = (accepted > FEW) & (accepted < SURE)
    weights, _, rank, _ = np.linalg.lstsq(terms[inner], np.log(accepted[inner]), rcond=KNOWN)
    return Weights(*weights.tolist()) if rank == terms.shape[1] and inner.sum() >= TIMES * rank else None


def _equations(found: Balance) -> tuple[Array, Array]:
    """Return the factors of the weights, shape (M, 3), and the acceptances, shape (M,)."""
    seen = found.seen
    terms = np.stack([found.density[seen], -found.shift[seen], found.square[seen]], axis=1)
    return np.concatenate([terms, -terms]), np.concatenate([found.forth[seen], found.back[seen]])
