"""Single steps along random noise, including rare noise, compared with those of Euler's method.

A step that follows dx = f dt + B dW path by path differs from x + h f + B dW by less than any part of sqrt(h) B as h
tends to 0 with fixed dW/sqrt(h). Means over the nodes of a rule do not show all deviations, because for many
motions all nodes have the same size. So the step is made along 10^4 random draws of the noise, for any number of
motions, and the largest difference is used, if it has a nonzero limit. Each motion of a draw is normal, or with some
probability uniform in [-Z, Z], with

    Z^2 = 2 p ln(1/h),    p = 1/2,    h the shortest step,

because a right scheme may clip its increments at sqrt(2 p h ln(1/h)) (Milstein & Tretyakov 2004, section 1.3), and
does not allow an order of 1/2 if its p is smaller. Noise beyond Z = 4.6 has less than 2e-4 of the variance.
"""

from collections.abc import Sequence
from functools import lru_cache, reduce
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from ...arrays import Array, Mask
from ...contracts.scheme import Scheme
from ...forms import Equation, Problem
from ...noise.brownian import PARTS, Increment, complete
from ...numerics.statistics import EPS
from ..step.nodes import SEED, Nodes
from ..step.one_step import OneStep
from ..step.states import time_unit
from .equation_rates import FINER, EquationRates, equation_rates
from .step_law import ROUNDINGS, SETTLED, short_steps, state_words

# Total number of draws, number of times in the run; largest work, and fewest draws for large systems, which have more
# motions per draw.
# Size: draws and times.
DRAWS, TIMES, WORK, FEWEST = 10_000, 4, 2**21, 512
# Smallest p of clipped increments that allow an order of 1/2; see `Law.most`.
# Theorem: the one that `Law.most` names.
LEAST_CLIP = 0.5
# A larger difference, relative to the noise, is followed to shorter steps: for a right scheme it decreases like
# sqrt(h), or like h^(1/4) if it is tamed.
# Size: of what is followed, 30 times sqrt(h) at the shortest step; a smaller error of the noise is not reported.
SMALL = 1e-3
# Standard errors from which a mean differs from that of the noise: one in 10^6 by chance.
# Level: 6e-7 of a normal mean, two-sided.
STANDARD_ERRORS = 5.0


class _Draw(NamedTuple):
    """Noise and states at one time.

    Attributes
    ----------
    t : float
    x : ndarray, shape (d, P)
    root : ndarray, shape (C, P)
        Size of the noise of each component; infinite if it is not to be compared.
    nodes : Nodes
        Noise of a step of length 1; its weights are the density of the law divided by that of the draws.
    """

    t: float
    x: Array
    root: Array
    nodes: Nodes

    def select(self, places: Array) -> "_Draw":
        """Return the draws with some indices."""
        return _Draw(self.t, self.x[:, places], self.root[:, places], self.nodes.select(places))


def noise_departure(scheme: Scheme, view: Problem, *, paths: bool) -> str:
    """Return the noise along which short steps do not follow the equation, in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; see `step_law`.
    paths : bool
        Whether the scheme has claims on paths. If not, a step may deviate along some noise as long as its
        mean and mean square are those of the equation.
    """
    step = short_steps(scheme, view)
    rates = None if step is None else equation_rates(step.view, step.equation)
    if step is None or rates is None or not step.view.noise_dim:
        return ""
    with np.errstate(all="ignore"):
        draws = _drawn(step.view, step.equation)
        found = [_difference(step, rates, draw, FINER[-1]) for draw in draws]
        stays = [_stays(step, rates, draw, gap) for draw, gap in zip(draws, found, strict=True)]
        if not any(map(np.any, stays)) or not (paths or _changes_law(draws, found, stays)):
            return ""
    return _words(draws, [*map(_size, found)], stays)


# Cached, as it is the same for all schemes of a form.
@lru_cache(maxsize=8)
def _drawn(view: Problem, equation: Equation) -> tuple[_Draw, ...]:
    """Return draws at a few times, the same number for each of the states."""
    rng, rates = np.random.Generator(np.random.Philox(key=SEED + 17)), equation_rates(view, equation)
    (n, d, S), l = rates.x.shape, view.noise_dim
    each = max(1, int(np.clip(WORK // (d * l), FEWEST, DRAWS)) // (TIMES * S))
    found = []
    for place in np.linspace(0, n - 1, TIMES).astype(int).tolist():
        nodes = _random_nodes(rng, view, each * S)
        x, size = rates.x[place], rates.size[1, rates.core, place]
        wide, root = np.tile(x, each), np.tile(np.sqrt(size), each)
        found.append(_Draw(float(rates.t[place]), wide, np.where(np.isfinite(wide).all(axis=0), root, np.inf), nodes))
    return tuple(found)


def _random_nodes(rng: np.random.Generator, view: Problem, count: int) -> Nodes:
    """Return noise of a step of length 1 with normal increments, a share 1/(2 sqrt(l)) of them uniform instead."""
    l, share = view.noise_dim, 0.5 / np.sqrt(view.noise_dim)
    far = np.sqrt(2.0 * LEAST_CLIP * -np.log(FINER[-1] * time_unit(view)))
    normal, uniform = rng.standard_normal((l, count)), rng.uniform(-far, far, (l, count))
    dW = np.where(rng.uniform(size=(l, count)) < share, uniform, normal)
    density = scipy.stats.norm.pdf(dW)
    drawn = (1.0 - share) * density + share * (np.abs(dW) < far) / (2.0 * far)
    # The norm of an increment is limited to the quantile that corresponds to `far`, since a scheme may clip vectors,
    # too.
    most = scipy.stats.chi.isf(2.0 * scipy.stats.norm.sf(far), l) / np.linalg.norm(dW, axis=0)
    weights = np.prod(density / drawn, axis=0) * (most >= 1.0)
    dW = dW * np.minimum(most, 1.0)
    H = rng.standard_normal((l, count)) / np.sqrt(PARTS["H"])
    noise = complete(Increment(dW, H), 1.0, view.noise, rng)
    return Nodes(dW, H, weights, exact=False, K=noise.K, A=noise.A)


def _difference(step: OneStep, rates: EquationRates, draw: _Draw, part: float) -> tuple[Array, Array]:
    """Return the difference of a step from Euler's relative to the noise, shape (d, P), and Euler's move."""
    h = float(part * step.time_unit)
    noise = step.scheme.law.increment(draw.nodes.increment(h), h)
    made = step.make(draw.x, draw.t, h, noise)
    euler = step.euler(draw.x, draw.t, h, noise)
    root = np.full_like(draw.x, np.inf)
    for rows, size in zip(rates.core_rows.values(), draw.root, strict=True):
        root[rows] = np.sqrt(h) * size
    gap = step.read(made.state) - euler
    explained = ROUNDINGS * EPS * np.abs(draw.x).max(axis=0)
    gap = np.sign(gap) * np.fmax(np.abs(gap) - explained, 0.0) / root
    masks = [mask for mask in (made.failed, made.truncated) if mask is not None]
    masks.append(step.leaves_domain(draw.x, draw.t, h, noise))
    return np.where(reduce(np.logical_or, masks, ~np.isfinite(gap).all(axis=0)), np.nan, gap), (euler - draw.x) / root


def _size(gap: tuple[Array, Array]) -> Array:
    return np.asarray(np.abs(gap[0]).max(axis=0))


def _stays(step: OneStep, rates: EquationRates, draw: _Draw, found: tuple[Array, Array]) -> Mask:
    """Return the draws whose difference has a nonzero limit: its changes over two factors of 16 are small.

    It has none if the step's own move, relative to the noise, grows with both factors; see `step_law`.
    """
    stays = _size(found) > SMALL
    places = np.flatnonzero(stays)
    if places.size:
        some, (gap, moved) = draw.select(places), (each[:, places] for each in found)
        longer = [_difference(step, rates, some, part) for part in FINER[-2::-1].tolist()]
        gaps, own = [gap, *(each for each, _ in longer)], [gap + moved, *(a + b for a, b in longer)]
        changes = [np.abs(a - b).max(axis=0) for a, b in pairwise(gaps)]
        sizes = [np.abs(each).max(axis=0) for each in own]
        grows = np.all([b < (1.0 - SETTLED) * a for a, b in pairwise(sizes)], axis=0)
        stays[places] = (np.maximum(*changes) <= SETTLED * np.abs(gaps[0]).max(axis=0)) & ~grows
    return np.asarray(stays)


def _changes_law(draws: Sequence[_Draw], found: list[tuple[Array, Array]], stays: list[Mask]) -> bool:
    """Return whether differences with a limit change the mean or the mean squares of a step's noise."""
    changes = []
    for draw, (gap, moved), kept in zip(draws, found, stays, strict=True):
        gone = np.where(kept, gap, 0.0)
        changes.append(np.concatenate([gone, gone * (2.0 * moved + gone)]) * draw.nodes.weights)
    every = np.concatenate(changes, axis=1)
    error = every.std(axis=1) / np.sqrt(every.shape[1])
    return bool((np.abs(every.mean(axis=1)) > STANDARD_ERRORS * error)[error > 0.0].any())


def _words(draws: Sequence[_Draw], sizes: list[Array], stays: list[Mask]) -> str:
    """Describe the noise of the draws whose difference stays, and the state of the largest difference."""
    far = np.concatenate(
        [np.abs(draw.nodes.dW[:, kept]).max(axis=0) for draw, kept in zip(draws, stays, strict=True)]
    )
    seen = [np.where(kept, size, -1.0) for size, kept in zip(sizes, stays, strict=True)]
    place = int(np.argmax([size.max() for size in seen]))
    draw, at = draws[place], int(seen[place].argmax())
    noise = f"noise of {far.min():.2g} to {far.max():.2g} standard deviations"
    where = f"from {state_words(draw.x[:, at])}, t = {draw.t:.3g}"
    return f"one step {where} with {noise} is off by {seen[place][at]:.2g} of the noise at any h: wrong equation"
