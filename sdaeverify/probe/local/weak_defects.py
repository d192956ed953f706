"""Local weak defects: expectations after one step, by cubature, compared with those of the equation.

At a state x, for a test function phi and step sizes h, with nodes xi_k and weights w_k of the noise,

    D(h) = sum_k w_k phi(Phi(x, t, h, xi_k)) - E[phi(x(t + h)) | x(t) = x],

where the second expectation is computed by extrapolated trees of Euler steps, which need only the coefficients. A
scheme has weak order p if D = O(h^(p+1)) for all phi and x (Milstein 1986; Kloeden & Platen 1992, Theorem 14.5.2).

Components are divided by a power of two near their largest value over the states, so that orders do not depend on
units, and phi is meaningful for states of any size. A component that is 0 up to the rounding of the others has no
scale, and is divided by that of the state. A component that stays near a nonzero value, such as a temperature,
is measured from that value, in units of its range: otherwise errors of its noise would be below rounding.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...errors import ProblemError
from ...forms import Equation, Problem
from ...numerics import jacobian
from ...numerics.digits import SCALE, keep_defined, significant
from ...numerics.statistics import EPS
from ..step import test_functions
from ..step.nodes import COUNTS, FEWEST, LARGEST, Nodes, step_nodes
from ..step.one_step import OneStep, why_not_resolved
from ..step.romberg import SHALLOWEST, depth, extrapolate_means, leaves
from ..step.states import SPREAD, cloud, in_batches, spread_states, time_unit
from ..step.times import first_time, times
from ..step.together import PathBatch
from .weak_order import FINEST, LocalWeak

# Step sizes 2^-3, ..., 2^-18 of the horizon, or of the unit of time if that is shorter. At the finest, defects of
# weak order 1 reach the floor of rounding; those of order 0 that they hide do not yet.
LEVELS = FINEST * 2.0 ** np.arange(15.0, -1.0, -1.0)
# Much shorter step sizes, down to rounding, used if a step does not follow the equation at the others.
SHORTEST = 2.0 ** -np.arange(19.0, 37.0)
# Number of test functions up to which a batch has the full length of a step's; with more it is shorter.
# Size: of a batch.
FUNCTIONS = 32
# Number of finest step sizes that must not be truncated for an order.
# Theorem: elementary, the five sizes of one window of `weak_order.SMOOTH`.
LEAST = 5
# A component that is smaller than the state by this multiple of EPS, at all states, consists of rounding errors of
# the others.
# Rounding: 64 operations err by at most 64 eps of their sizes (Higham 2002, Lemma 3.1).
ROUNDINGS = 64.0
# Number of states that are perturbed by a rounding error, to measure its amplification by a step.
# Size: states that are changed.
NUDGED = 4
# Most leaves of a tree for all further states, and paths of a step from these: about as many as for `cloud`.
# Size: of a tree, and of a batch.
LEAVES, WORK = 2**15, 2**12
# Start and size of each step.
Steps = tuple[tuple[float, float], ...]
# A component stays near a value if it exceeds its distance from it by the first factor; beyond the second, its motion
# is rounding, and it does not move.
# Size: of a unit; with a nearer value, a component's own size is the unit of test functions.
# Rounding: a motion of 1e-8 of a value is known to eps/1e-8 = 2e-8.
NEAR, AT_REST = 128.0, 1e8


class Frame(NamedTuple):
    """Scaling of states before they are passed to test functions.

    Attributes
    ----------
    centre, unit : ndarray, shape (d, 1)
        Reference values and units of the components.
    """

    centre: Array
    unit: Array

    def of(self, x: Array) -> Array:
        """Return scaled states, shape (d, P), the arguments of test functions."""
        return (x - self.centre) / self.unit

    def coefficients(self, linear: Array, square: Array) -> Array:
        """Return the coefficients of test functions for l . x + x^T S x up to a constant, shape (F,).

        Parameters
        ----------
        linear, square : ndarray, shape (d,) and (d, d)
            l and S.
        """
        slope = linear + 2.0 * square @ self.centre[:, 0]
        return test_functions.coefficients(slope, square, self.unit[:, 0])


class SemigroupReference(NamedTuple):
    """Expectations of the equation, shared by all schemes that are compared with it.

    Attributes
    ----------
    states : ndarray, shape (d, S)
    frame : Frame
        Scaling of the arguments of test functions.
    t : tuple of float
        Start of the step of each size.
    h : ndarray, shape (H,)
    means : ndarray, shape (F, S, H)
        E phi(x(t + h)).
    scale : ndarray, shape (F, S, H)
        Scale of rounding without |phi| at a scheme's nodes: |D phi|_1 at the states, times the size of a component if
        that exceeds its unit, plus the square of the length of a step, which is the size of phi where D phi = 0.
    trees : int
        Number K of extrapolated trees: the error is O(h^(K+1)).
    """

    states: Array
    frame: Frame
    t: tuple[float, ...]
    h: Array
    means: Array
    scale: Array
    trees: int

    def first(self, count: int) -> "SemigroupReference":
        """Return the reference for the first states only."""
        states, means, scale = self.states[:, :count], self.means[:, :count], self.scale[:, :count]
        return self._replace(states=states, means=means, scale=scale)

    def affordable(self, nodes: int) -> "SemigroupReference":
        """Return every k-th state, such that steps at all nodes have at most `WORK` paths."""
        some = slice(None, None, -(-self.states.shape[1] * nodes // WORK))
        states, means, scale = self.states[:, some], self.means[:, some], self.scale[:, some]
        return self._replace(states=states, means=means, scale=scale)


def why_not_local_weak(scheme: Scheme, view: Problem) -> str:
    """Return why a scheme has no local weak order on a problem, or an empty string."""
    shortest = float(LEVELS[-1]) * time_unit(view)
    step = OneStep(scheme, view)
    why = why_not_nodes(scheme, view) or why_not_resolved(view, shortest) or step.why_not_probed()
    return why or step.why_not_sound(float(sizes(view)[-LEAST]))


def why_not_from(step: OneStep, x: Array) -> str:
    """Return why no step from the states x, shape (d, S), shows an order, or an empty string."""
    return step.why_not_sound(float(sizes(step.view)[-LEAST]), x)


def why_not_nodes(scheme: Scheme, view: Problem) -> str:
    """Return why the noise of a step has no cubature rule that resolves means, or an empty string."""
    nodes = _nodes(scheme, view.noise_dim)
    few = nodes.exact and len(nodes.weights) <= LARGEST
    return "" if few else f"noise in {view.noise_dim} dimensions needs too many quadrature nodes"


def sizes(view: Problem, *, shortest: bool = False) -> Array:
    """Return the probed step sizes, coarsest first, shape (H,)."""
    return np.asarray((SHORTEST if shortest else LEVELS) * time_unit(view))


def weak_reference(view: Problem, steps: Steps, *, further: bool = False) -> SemigroupReference:
    """Return the expectations with which all schemes of a form are compared on a problem.

    Parameters
    ----------
    view : Problem
        Problem with an Ito equation.
    steps : tuple of pairs of float
        Start and size of each step.
    further : bool
        Whether to use `spread_states`, with fewer trees, instead of `cloud`.

    Returns
    -------
    SemigroupReference
        States at which the equation is not finite are left out.

    Raises
    ------
    ProblemError
        If the equation is finite at none of the states of `cloud`.
    """
    ito = view.ito()
    assert ito is not None
    x, trees = cloud(view, ito), depth(ito.noise_dim)
    frame = frame_of(x)
    if further:
        x, trees = spread_states(view, ito, min(SPREAD, LEAVES // (2 * ito.noise_dim) ** SHALLOWEST)), SHALLOWEST
    found = _reference(ito, x, frame, steps, trees)
    if not (found.states.size or further):
        raise ProblemError("the Ito equation is not finite at any of the probed states")
    return found


def reference_from(view: Problem, x: Array, steps: Steps) -> SemigroupReference:
    """Return the expectations of test functions after steps from given states.

    Parameters
    ----------
    view : Problem
        Problem with an Ito equation.
    x : ndarray, shape (d, S)
    steps : tuple of pairs of float
        Start and size of each step.

    Returns
    -------
    SemigroupReference
        States at which the equation is not finite are left out.
    """
    ito = view.ito()
    assert ito is not None
    return _reference(ito, x, frame_of(x), steps, depth(ito.noise_dim))


def _reference(ito: Equation, x: Array, frame: Frame, steps: Steps, trees: int) -> SemigroupReference:
    t, h = zip(*steps, strict=True)

    def functions(y: Array) -> Array:
        return test_functions.values(frame.of(y))

    with np.errstate(all="ignore"):
        means = np.stack([extrapolate_means(ito, functions, x, step, trees) for step in steps], axis=-1)
        moved = np.stack([_moved(ito, x, at, size, frame.unit) for at, size in steps], axis=-1)
        slopes = np.abs(jacobian(test_functions.values, frame.of(x))) * np.maximum(np.abs(x) / frame.unit, 1.0)
        scale = slopes.sum(axis=1)[..., None] + moved**2
    sound = np.isfinite(means[..., -1]).all(axis=0)
    known = means[:, sound], scale[:, sound], trees
    return SemigroupReference(x[:, sound], frame, t, np.array(h), *known)


def _moved(ito: Equation, x: Array, t: float, h: float, unit: Array) -> Array:
    """Return the largest displacement by Euler's step in any component from each state, shape (S,)."""
    branches = leaves(ito, x, t, h, 1).reshape(*x.shape, -1)
    return np.asarray((np.abs(branches - x[..., None]).max(axis=2) / unit).max(axis=0))


def frame_of(x: Array) -> Frame:
    """Return the scaling for states (d, S): units are powers of two near the sizes of the components."""
    largest = np.abs(x).max(axis=1, where=np.isfinite(x), initial=0.0)
    own, state = largest > ROUNDINGS * EPS * largest.max(), largest.max() or 1.0
    size, start = np.where(own, largest, state), np.nan_to_num(x[:, 0])
    goes = np.abs(x - start[:, None]).max(axis=1, where=np.isfinite(x), initial=0.0)
    stays = own & (NEAR * goes < size) & (AT_REST * goes > size)
    unit = np.exp2(np.ceil(np.log2(np.where(stays, goes, size))))
    return Frame(np.where(stays, start, 0.0)[:, None], unit[:, None])


def local_weak(
    scheme: Scheme,
    view: Problem,
    reference: Callable[..., SemigroupReference] = weak_reference,
    *,
    shortest: bool = False,
) -> LocalWeak:
    """Compute the defects of one step of each size from each probe state, at each probe time.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_local_weak` is empty for the pair.
    reference : callable, optional
        `weak_reference`, or a function that caches it for further schemes.
    shortest : bool
        Whether to use the step sizes `SHORTEST` instead of `LEVELS`.

    Returns
    -------
    LocalWeak
    """
    step, nodes = OneStep(scheme, view), _nodes(scheme, view.noise_dim)
    h = sizes(view, shortest=shortest).tolist()
    first = reference(view, tuple((first_time(view.horizon), size) for size in h))
    moments = [tuple((each.of_size(step, size), size) for size in h) for each in times(step, first.states)]
    known = [first, *(reference(view, steps) for steps in moments[1:])]
    beside = [reference(view, steps, further=True).affordable(len(nodes.weights)) for steps in moments]
    return _record_defects(step, known, [each for each in beside if each.states.size])


def local_weak_from(scheme: Scheme, view: Problem, known: SemigroupReference) -> LocalWeak:
    """Compute the defects of one step of each size from the states of a reference.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    known : SemigroupReference
        Result of `reference_from`.

    Returns
    -------
    LocalWeak
    """
    return _record_defects(OneStep(scheme, view), [known], [])


def _record_defects(step: OneStep, near: list[SemigroupReference], beside: list[SemigroupReference]) -> LocalWeak:
    nodes, known = _nodes(step.scheme, step.view.noise_dim), [*near, *beside]
    with np.errstate(all="ignore"):
        found = list(zip(*(_defects_at(step, each, nodes) for each in known), strict=True))
        apart = _rules_apart(step, near[0], found[0][0])
        own = _own_rounding(step, near[0])
    defect, scale = (np.concatenate(parts, axis=1) for parts in found)
    apart = keep_defined(apart, scale[:, : apart.shape[1]])
    finite = np.isfinite(defect) & np.isfinite(scale)
    defect, scale = keep_defined(defect, scale), significant(scale, SCALE)
    counts = [each.shape[1] for each in found[0]]
    trees, time = (
        np.repeat(part, counts).astype(float) for part in ([each.trees for each in known], range(len(known)))
    )
    defect, scale = (np.where(finite, part, np.nan) for part in (defect, scale))
    further = (time >= len(near)).astype(float)
    dimension = np.array(float(len(near[0].frame.unit)))
    return LocalWeak(near[0].h, defect, scale, trees, dimension, time, further, apart, own)


def _rules_apart(step: OneStep, known: SemigroupReference, defect: Array) -> Array:
    """Return the change of the defects with another rule, shape (F, S, H); S is 0 for a discrete law."""
    if step.scheme.law.bounded or not step.view.noise_dim:
        return np.zeros((len(defect), 0, len(known.h)))
    other = _nodes(step.scheme, step.view.noise_dim, other=True)
    found, _ = _defects_at(step, known.first(max(1, WORK // len(other.weights))), other)
    return np.asarray(found - defect[:, : found.shape[1]])


def _own_rounding(step: OneStep, known: SemigroupReference) -> Array:
    """Return the largest change of a step by one rounding error of its state, in units of components, shape (H,).

    A step that divides a difference of states by h, or solves an equation up to a tolerance, amplifies a rounding
    error beyond eps of the state. The perturbation itself, and a rounding error of each of the two compared steps,
    are subtracted. The mean over a few nodes is taken for each state.
    """
    nodes, x = step.few_nodes(), known.states[:, :: max(1, known.states.shape[1] // NUDGED)]
    both = np.concatenate([x, x * (1.0 + EPS)], axis=1)
    found, start = [], np.repeat(np.abs(x), len(nodes.weights), axis=1)
    for end in _ends(step, known, nodes, both):
        a, b = np.split(end, 2, axis=1)
        beyond = (np.abs(b - a) - 3.0 * EPS * np.maximum(np.abs(a), start)).clip(0.0) / known.frame.unit
        means = nodes.mean(beyond.reshape(*x.shape, -1))
        found.append(means.max(where=np.isfinite(means), initial=0.0))
    return np.array(found)


def _ends(step: OneStep, known: SemigroupReference, nodes: Nodes, x: Array) -> Iterator[Array]:
    """Yield the results of steps of each size from the states x at all nodes, shape (d, S K)."""
    wide, when = np.repeat(x, len(nodes.weights), axis=1), zip(known.t, known.h.tolist(), strict=True)
    batches = (PathBatch(wide, t, h, nodes.increment(h, x.shape[1])) for t, h in when)
    return (step.read(made.state) for made in step.together(batches))


def _defects_at(step: OneStep, known: SemigroupReference, nodes: Nodes) -> tuple[Array, Array]:
    """Return the defects of a step from one time, and their scale, both of shape (F, S, H).

    Defects of truncated steps are NaN; states from which the fifth finest step size is truncated are left out.
    """
    some = in_batches(known.states, len(nodes.weights) * -(-len(known.means) // FUNCTIONS))
    parts = [_levels(step, known, nodes, x) for x in some]
    means, largest = (np.concatenate(part, axis=1) for part in zip(*parts, strict=True))
    truncated = step.truncated(known.states, known.h, known.t)
    kept, defect = ~truncated[:, -LEAST], np.where(truncated, np.nan, means - known.means)
    return defect[:, kept], (largest + known.scale)[:, kept]


def _nodes(scheme: Scheme, noises: int, *, other: bool = False) -> Nodes:
    areas = "H" in scheme.noise
    count = COUNTS.get(noises * (2 if areas else 1), FEWEST)
    return step_nodes(noises, count, areas=areas, law=scheme.law, other=other)


def _levels(step: OneStep, known: SemigroupReference, nodes: Nodes, x: Array) -> tuple[Array, Array]:
    """Return the means of phi over the nodes and the largest |phi|, both of shape (F, S, H), for states x."""
    states, count, found = x.shape[1], len(nodes.weights), []
    for end in _ends(step, known, nodes, x):
        phi = test_functions.values(known.frame.of(end))
        phi = phi.reshape(len(phi), states, count)
        found.append((nodes.mean(phi), np.maximum(phi.max(axis=-1), -phi.min(axis=-1))))
    means, largest = (np.stack(part, axis=-1) for part in zip(*found, strict=True))
    return means, largest
