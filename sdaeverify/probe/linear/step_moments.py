"""Second moments after one step of a scheme: P -> E A P A^T with A = [[R, r], [0, 1]] acting on (x, 1).

The expectation is exact for the atoms of a discrete law; for steps affine in Gaussian noise, by the n + 1 vertices of
a regular simplex; and for polynomials of degree 4 in each normal, by five nodes per normal. Other steps need
quadrature, by rules that are refined until two of them agree:

1. Products of Gauss-Hermite rules with 5, 9 and 15 nodes per normal, for steps that are smooth in the noise. If the
   step has a pole, rules with 25 and 41 nodes follow.
2. One normal: panels of [-9.5, 9.5], bisected until they agree, in batches, for kinks and jumps anywhere.
3. Two normals: products of Gauss-Legendre rules on both sides of 0, with 20, 24, 32 and 41 nodes, for kinks at 0.
"""

from collections.abc import Callable, Iterable
from functools import partial
from itertools import chain
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme, flatten
from ...forms import Problem
from ..local.smoothness import follow
from ..step.nodes import SEED, Nodes
from ..step.one_step import OneStep
from ..step.step_noise import CUT, StepNoise
from .affine import AFFINE, relative
from .linear_map import LinearMap, MemoryStep, factors_at, linear_map
from .noise_shape import (
    affine_shares,
    image_state,
    is_affine,
    is_told,
    is_told_at_random,
    polynomial_shares,
    trial_nodes,
    trial_points,
)
from .second_moments import Operator

# Number of initial panels, which is even, and of nodes in each: one panel resolves the normal density.
# Size: panels and nodes.
FIRST, NODES = 8, 16
GAUSS_LEGENDRE = np.polynomial.legendre.leggauss(NODES)
# A panel and its halves agree if they differ by at most this part of the whole integral.
# Rounding: factors of 64 operations err by 64 eps, their products by 128 eps, and the difference of two sums of these
# by 256 eps = 6e-14.
TOLERANCE = 1e-13
# At a jump the error is the length of a panel, which is below 1e-12 in the last round.
# Rounding: 2.4 of a panel at the start, 2.4/2^44 = 1.4e-13 of one in the last round.
ROUNDS = 44
# Size: panels at most.
MOST_PANELS = 256
# Rounding: exp(-z^2/2) is 0 in floating point beyond 38.6.
FAR = 60.0
# Size: of the grid of a line.
SPACING = 0.125
# A peak is refined to a distance of SPACING / ZOOM^ZOOMS.
# Size: of a search.
ZOOM, ZOOMS = 8, 8
# Peaks that after this number of zooms have hardly risen above the first value, nor far above the grid, are not
# refined further.
# Theorem: elementary, between these zooms |z - z*|^-p rises by 8^(2 p), which is 6.5 for p = 0.45.
LOOKED, FLAT, RISEN = 3, 1.001, 2.0
# Size: peaks at most.
MOST_PEAKS = 64
# Most nodes along lines in one call of a step: more states of many components do not fit the processor's caches.
# Size: nodes of a call.
AT_ONCE = 4_400
# |z - z*|^-p has an infinite second moment for p >= 1/2; a peak of finite height has p = 0.
# Theorem: elementary, over a factor 8^8 of distances, another factor up to 2.3 in the height changes p by up to 0.05.
EXPONENT = 0.45
# Image of a state, shape (k, K), as a function of normals x, shape (variables, K).
Image = Callable[[Array], Array]
# If a search for kinks follows, only the first few rules of the ladder are tried.
# Size: nodes of the rules.
LADDER, FEW = (5, 9, 15, 25, 41), 3
# Size: nodes of the rules on either side of a kink.
SPLIT = (20, 24, 32, 41)
# Lines between random normals, and intervals of each, along which a step that two rules agree on may jump.
# Size: lines and intervals.
LINES, CUTS = 16, 32
# Two rules agree if the operators differ by at most this, relative.
# Rounding: ten panels that differ by `TOLERANCE`; a thousandth of the least |rho - 1| that decides, `windows.MARGIN`.
AGREEMENT = 1e-12
# Most entries of the matrices at all nodes: 64 MiB.
# Size: memory.
ENTRIES = 1 << 23
# Size: states that are tried.
TRIALS = 3


class Panels(NamedTuple):
    """Intervals, each with the nodes of a Gauss-Legendre rule.

    Attributes
    ----------
    ends : ndarray, shape (2, I)
    values : ndarray, shape (..., I NODES)
        Values of a function at all nodes.
    integrals : ndarray, shape (..., I)
        Integrals of a function of these values against the normal density.
    """

    ends: Array
    values: Array
    integrals: Array


def bisect_panels(
    function: Callable[[Array], Array], integrand: Callable[[Array, Array], Array]
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return rules on [-9.5, 9.5] adapted to integrals of a function; 0 is a panel boundary.

    Parameters
    ----------
    function : callable, ndarray of shape (K,) -> ndarray of shape (..., K)
        Evaluated at nodes in units of the standard deviation.
    integrand : callable, (values, weights) -> ndarray of shape (..., I)
        Returns integrals over I panels, from values of shape (..., I, NODES) and weights of shape (I, NODES).

    Returns
    -------
    tuple of ndarray, shape (..., K) and (K,)
        Values of the function at the nodes, and the weights of the nodes.
    tuple of ndarray
        The same for the coarser rule of parent panels.
    """
    fine: list[Panels] = []
    coarse: list[Panels] = []
    ends = np.linspace(-CUT, CUT, FIRST + 1)
    parents = _panels(np.stack([ends[:-1], ends[1:]]), function, integrand)
    for left in reversed(range(ROUNDS)):
        middle = parents.ends.mean(axis=0)
        ends = np.stack([parents.ends[0], middle, middle, parents.ends[1]]).reshape(2, 2, -1)
        children = _panels(ends.swapaxes(0, 1).reshape(2, -1), function, integrand)
        done = _agree(parents, children, [*fine, parents])
        if left == 0 or np.count_nonzero(~done) > MOST_PANELS:
            done = np.ones_like(done)
        coarse.append(_select_panels(parents, done))
        fine.append(_select_panels(children, np.tile(done, 2)))
        if done.all():
            break
        parents = _select_panels(children, np.tile(~done, 2))
    return _rule(fine), _rule(coarse)


def _panels(ends: Array, function: Callable[[Array], Array], integrand: Callable[[Array, Array], Array]) -> Panels:
    z, weights = _nodes(ends)
    values = function(z.ravel())
    return Panels(ends, values, integrand(values.reshape(*values.shape[:-1], *z.shape), weights))


def _nodes(ends: Array) -> tuple[Array, Array]:
    # Return nodes and weights of all panels, shape (I, NODES).
    q, w = GAUSS_LEGENDRE
    half = 0.5 * (ends[1] - ends[0])[:, None]
    z = 0.5 * (ends[0] + ends[1])[:, None] + half * q
    return z, half * w * np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)


def _agree(parents: Panels, children: Panels, all_panels: list[Panels]) -> Array:
    # Return which parents agree with the sum of their two children; all first halves precede all second halves.
    first, second = np.split(children.integrals, 2, axis=-1)
    axes = tuple(range(first.ndim - 1))
    total = sum(panels.integrals.sum(axis=-1) for panels in all_panels)
    return np.asarray(np.abs(parents.integrals - first - second).max(axis=axes) <= TOLERANCE * np.abs(total).max())


def _select_panels(panels: Panels, which: Array) -> Panels:
    return Panels(panels.ends[:, which], panels.values[..., np.repeat(which, NODES)], panels.integrals[..., which])


def _rule(parts: list[Panels]) -> tuple[Array, Array]:
    weights = np.concatenate([_nodes(part.ends)[1].ravel() for part in parts])
    return np.concatenate([part.values for part in parts], axis=-1), weights


def far_noise(image: Image, noise: StepNoise) -> tuple[float, float]:
    """Return the nearest pole of a step in its noise, and the mean square from far noise, missed by quadrature.

    A step that divides by 1 - c z has an infinite second moment, however far out the pole is, but a quadrature that
    stops at 9.5 standard deviations gives a finite number. Lines through 0 are scanned up to 60 standard deviations.
    They are scanned from one random state, because a step with a pole has it from almost every state.

    Parameters
    ----------
    image : callable
        Image of a state for given normals.
    noise : StepNoise

    Returns
    -------
    pole : float
        Smallest |z| at which the step is infinite, in standard deviations; infinite if there is no pole.
    left_out : float
        Bound of the contribution of |z| > 9.5 to the mean square after a step from a state of length 1, along the
        lines.
    """
    z = np.arange(-FAR, FAR + SPACING, SPACING)
    directions = noise.directions()
    lines = _sizes(image, directions[:, :, None] * z)
    line, place = np.nonzero((lines[:, 1:-1] >= lines[:, :-2]) & (lines[:, 1:-1] > lines[:, 2:]))
    nearby = np.maximum(lines[line, place], lines[line, place + 2])
    sharpest = np.argsort(nearby / lines[line, place + 1], kind="stable")[:MOST_PEAKS]
    line, centre, nearby = line[sharpest], z[place + 1][sharpest], nearby[sharpest]
    exponent = _exponents(image, directions[:, line], centre, nearby)
    pole = float(np.min(np.abs(centre), initial=np.inf, where=exponent > EXPONENT))
    return pole, np.inf if pole < np.inf else _bound_tails(lines, z)


def _sizes(image: Image, x: Array) -> Array:
    # Return a bound of the norm of the image for normals x, shape (n, ...) -> (...).
    flat = x.reshape(len(x), -1)
    parts = (image(part) for part in np.array_split(flat, -(-flat.shape[1] // AT_ONCE), axis=1))
    sizes = np.concatenate([len(y) * np.abs(y).max(axis=0) for y in parts]).reshape(x.shape[1:])
    return np.where(np.isnan(sizes), np.inf, sizes)


def _exponents(image: Image, directions: Array, centre: Array, nearby: Array) -> Array:
    """Return the exponents p of peaks like |z - z*|^-p, from their growth as the distance shrinks."""
    closer, first = _zoom(image, directions, centre, range(1))
    closer, sizes = _zoom(image, directions, closer, range(1, LOOKED))
    # The other peaks have a finite height.
    rising = sizes > np.minimum(FLAT * first, RISEN * nearby)
    _, sizes[rising] = _zoom(image, directions[:, rising], closer[rising], range(LOOKED, ZOOMS))
    return np.asarray(np.log(sizes / nearby) / np.log(float(ZOOM) ** ZOOMS))


def _zoom(image: Image, directions: Array, centre: Array, zooms: range) -> tuple[Array, Array]:
    """Return the positions of the largest values near some centres, and these values."""
    sizes = np.full(len(centre), np.nan)
    for width in SPACING / float(ZOOM) ** np.array(zooms if len(centre) else ()):
        places = centre[:, None] + width * np.linspace(-1.0, 1.0, 2 * ZOOM + 1)
        values = _sizes(image, directions[:, :, None] * places)
        centre, sizes = places[np.arange(len(places)), values.argmax(axis=1)], values.max(axis=1)
    return centre, sizes


def _bound_tails(lines: Array, z: Array) -> float:
    # Return the mean square integrated over the far ends of a line; the maximum over lines.
    far = np.abs(z) > CUT
    density = np.exp(2.0 * np.log(lines[:, far]) - 0.5 * z[far] ** 2) / np.sqrt(2.0 * np.pi)
    return float(np.max(density.sum(axis=1)) * SPACING)


class Expectation(NamedTuple):
    """An operator computed by two rules.

    Attributes
    ----------
    operator : Operator
    coarser : Operator or None
        Operator by the coarser rule: the operator itself if the two agree to 1e-12 or the rule is exact, None if
        there are too many normals for two rules.
    """

    operator: Operator
    coarser: Operator | None

    @property
    def disagreement(self) -> float:
        """Relative difference of the two operators at some random positive matrices."""
        if self.coarser is self.operator:
            return 0.0
        if self.coarser is None:
            return np.inf
        values, others = (each(_positive(each.dimension)) for each in (self.operator, self.coarser))
        return _difference(values, others)


def expectation(
    step: MemoryStep, noise: StepNoise, few: Operator, first: Operator | None, *, kinks: bool = True
) -> Expectation:
    """Return the second-moment operator of a step.

    Parameters
    ----------
    step : MemoryStep
    noise : StepNoise
    few : Operator
        By the smallest rule, used if all others are too large.
    first : Operator or None
        By the first product rule; None if it is too large.
    kinks : bool
        Whether to search for kinks if smooth rules do not agree.

    Returns
    -------
    Expectation
    """
    further = (_by_rule(step, noise.rule(count)) for count in LADDER[1 : FEW if kinks else None])
    found = _climb_rules(few, chain([first], further))
    if found.coarser is found.operator and _jumps(step, noise):
        return Expectation(found.operator, None)
    if found.coarser is found.operator or not kinks:
        return found
    if noise.normals == 1:
        return _bisect_expectation(step, noise)
    split = _climb_rules(few, (_by_rule(step, noise.split_rule(count)) for count in SPLIT))
    agreed = split.coarser is split.operator
    return split if agreed else min(found, split, key=lambda pair: pair.disagreement)


def _jumps(step: MemoryStep, noise: StepNoise) -> bool:
    """Return whether a step has a kink or a jump along lines between random normals, which few nodes may miss."""
    ends = noise.scattered().reshape(noise.normals, 2, -1)[..., :LINES]
    weights = np.random.Generator(np.random.Philox(key=SEED + 23)).standard_normal(step.dimension)
    return follow(ends, CUTS, lambda x: np.asarray(weights @ _image(step, noise, x)), 2)[0]


def _difference(values: Array, others: Array) -> float:
    """Return the largest relative difference of two operators' values at some random positive matrices."""
    return relative((values - others).reshape(-1, 1), values.reshape(-1, 1))


def _image(step: MemoryStep, noise: StepNoise, x: Array) -> Array:
    # Return the image of a random state of length 1 for normals x, shape (n, K) -> (k, K).
    return step.at_nodes(image_state(step.dimension)[:, None], noise.nodes(x))[0][:, 0]


def _by_rule(step: MemoryStep, nodes: Nodes | None) -> Operator | None:
    if nodes is None or not _affords(step.dimension, nodes):
        return None
    return Operator(factors_at(step, nodes), nodes.weights)


def _affords(memory: int, nodes: Nodes) -> bool:
    return (memory + 1) ** 2 * len(nodes.weights) <= ENTRIES


def _climb_rules(few: Operator, operators: Iterable[Operator | None]) -> Expectation:
    """Return the first operator that agrees with the previous one, else the last two; None ends the search."""
    found, before = Expectation(few, None), None
    for finer in operators:
        if finer is None:
            break
        values = finer(_positive(finer.dimension))
        if before is not None and _difference(values, before) <= AGREEMENT:
            return Expectation(finer, finer)
        found, before = Expectation(finer, None if before is None else found.operator), values
    return found


def _bisect_expectation(step: MemoryStep, noise: StepNoise) -> Expectation:
    def integrals(factors: Array, weights: Array) -> Array:
        by_panel = factors.transpose(2, 0, 1, 3)
        left, right = (part.reshape(*part.shape[:2], -1) for part in (by_panel * weights[:, None, None], by_panel))
        return np.moveaxis(left @ right.swapaxes(1, 2), 0, -1)

    rules = bisect_panels(lambda z: factors_at(step, noise.nodes(z[None])), integrals)
    found = Expectation(*(Operator(*rule) for rule in rules))
    return found._replace(coarser=found.operator) if found.disagreement <= AGREEMENT else found


def _positive(n: int) -> Array:
    G = np.random.Generator(np.random.Philox(key=SEED + 5)).standard_normal((TRIALS, n, n))
    return G @ G.swapaxes(1, 2)


class StepMoments(NamedTuple):
    """Second-moment operator of a step, with diagnostics.

    Attributes
    ----------
    operator : Operator
        Acts on matrices E z z^T with z = (x, 1), where x contains all memory of the scheme.
    coarser : Operator or None
        Operator by a coarser rule, see `Expectation`.
    defect : float
        Relative deviation from linearity in the state: rounding if the step is linear.
    failed : bool
        Whether the scheme found no root at some state or node.
    pole, left_out : float
        Pole of the step in its noise, and contribution of noise beyond the quadrature; see `far_noise`.
    """

    operator: Operator
    coarser: Operator | None
    defect: float
    failed: bool
    pole: float = np.inf
    left_out: float = 0.0

    @property
    def rule_error(self) -> float:
        """Difference of the two rules plus the omitted noise, relative to an operator of size at least 1."""
        return Expectation(self.operator, self.coarser).disagreement + self.left_out


def why_not_linear_step(scheme: Scheme, view: Problem) -> str:
    """Return why a step cannot be probed for a linear map, or an empty string; its linearity is not tested here."""
    noise, memory = StepNoise.of(OneStep(scheme, view)), flatten(scheme.start(view, 1, view.horizon))
    if not noise.tractable:
        return f"{view.noise_dim} bounded variables have too many joint values"
    if memory.dtype.kind != "f":
        return "the scheme's memory is no array of real numbers"
    least = noise.rule(0) if noise.law.bounded else trial_nodes(noise)
    text = f"a memory of {len(memory)} numbers and {noise.normals} variables are too many for matrices"
    return "" if least is None or _affords(len(memory), least) else text


def step_moments(one_step: OneStep, h: float, *, far: bool = True, atoms: bool = True) -> StepMoments:
    """Return the second-moment operator of a step of size h.

    Parameters
    ----------
    one_step : OneStep
    h : float
    far : bool
        Whether to search for poles and for contributions of noise beyond the quadrature.
    atoms : bool
        Whether to use all atoms of a discrete law even if there are many and fewer points give the same up to
        rounding.

    Returns
    -------
    StepMoments
    """
    step, noise = MemoryStep(one_step, h), StepNoise.of(one_step)
    with np.errstate(all="ignore"):
        if noise.law.bounded and (atoms or not noise.has_many_atoms):
            return _by_atoms(step, noise)
        found, vertices = linear_map(step, trial_nodes(noise)), noise.normals + 1
        few = Operator(found.factors[..., :vertices], np.full(vertices, 1.0 / vertices))
        if found.defect > AFFINE:
            # No operator maps moments through a nonlinear step, so no accurate rule is needed.
            return StepMoments(few, None, found.defect, found.failed)
        image = partial(_image, step, noise)
        if noise.law.bounded:
            return _exact(found, few) if is_affine(noise, found) else _by_atoms(step, noise)
        points = noise.scattered()
        scattered = image(points)
        if is_affine(noise, found) and is_told_at_random(scattered, few, affine_shares(noise, points)):
            return _exact(found, few)
        first = _by_rule(step, noise.rule(LADDER[0]))
        if (
            first is not None
            and is_told(found.factors, first.factors, polynomial_shares(trial_points(noise), LADDER[0]))
            and is_told_at_random(scattered, first, polynomial_shares(points, LADDER[0]))
        ):
            # The step is the polynomial that interpolates its values at the nodes.
            return _exact(found, first)
        pole, left_out = far_noise(image, noise) if far else (np.inf, 0.0)
        operators = expectation(step, noise, few, first, kinks=pole > CUT)
        return StepMoments(*operators, found.defect, found.failed, pole, left_out)


def _by_atoms(step: MemoryStep, noise: StepNoise) -> StepMoments:
    atoms = noise.rule(0)
    assert atoms is not None
    found = linear_map(step, atoms)
    return _exact(found, Operator(found.factors, atoms.weights))


def _exact(found: LinearMap, operator: Operator) -> StepMoments:
    return StepMoments(operator, operator, found.defect, found.failed)
