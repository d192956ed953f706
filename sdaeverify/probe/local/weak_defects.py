"""Local weak defects: expectations after one step, by cubature, against those of the equation.

At a state x, for a test function phi and step sizes h, with nodes xi_k and weights w_k of the noise,

    D(h) = sum_k w_k phi(Phi(x, t, h, xi_k)) - E[phi(x(t + h)) | x(t) = x],

the second by extrapolated trees of Euler steps, which need the coefficients alone. D = O(h^(p+1)) for all phi and x
is a scheme of weak order p (Milstein 1986; Kloeden & Platen 1992, Theorem 14.5.2).

Components are divided by a power of two near their largest value among the states, so that orders do not depend on
units, and phi keeps its meaning for states of any size. A component that is 0 up to the rounding of the others has no
size of its own, and is divided by that of the state. One that stays near a value far from 0, as a temperature does,
is measured from that value, in units of how far it goes: errors of its noise would be below rounding.
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
from ..step.states import SPREAD, cloud, in_batches, spread_states, time_unit
from ..step.times import first_time, times
from ..step.together import PathBatch
from .romberg import SHALLOWEST, depth, extrapolate_means, leaves
from .weak_order import FINEST, LocalWeak

# Step sizes 2^-3, ..., 2^-18 of the horizon, or of the unit of time where that is shorter. At the finest, defects of
# a weak order 1 meet the floor of rounding; those of order 0 that hide behind them do not yet.
LEVELS = FINEST * 2.0 ** np.arange(15.0, -1.0, -1.0)
# Where a step does not follow the equation at these, it may at much shorter ones, down to what rounding lets see.
SHORTEST = 2.0 ** -np.arange(19.0, 37.0)
# Test functions with which a batch is as long as that of a step; of more it is shorter.
# Size: of a batch.
FUNCTIONS = 32
# An order needs so many of the finest step sizes that are not truncated.
LEAST = 5
# A component that is this much smaller than the state, at all states, is made of the rounding errors of the others.
ROUNDINGS = 64.0
# States that are changed by a rounding error, to see what a step makes of it.
# Size: states that are changed.
NUDGED = 4
# Leaves of a tree at all further states, and paths of a step from these: about as many as from the cloud.
# Size: of a tree, and of a batch.
LEAVES, WORK = 2**15, 2**12
# When each step begins, and its size.
Steps = tuple[tuple[float, float], ...]
# A component stays near a value where it is so many times as large as it goes away from that; where it goes no
# farther than rounding does, it does not move.
NEAR, AT_REST = 128.0, 1e8


class Frame(NamedTuple):
    """How states are seen by test functions.

    Attributes
    ----------
    centre, unit : ndarray, shape (d, 1)
        What components are measured from, and in which units.
    """

    centre: Array
    unit: Array

    def of(self, x: Array) -> Array:
        """Return states, shape (d, P), as test functions are given them."""
        return (x - self.centre) / self.unit

    def coefficients(self, linear: Array, square: Array) -> Array:
        """Return with which coefficients the test functions make up l . x + x^T S x less a constant, shape (F,).

        Parameters
        ----------
        linear, square : ndarray, shape (d,) and (d, d)
            l and S.
        """
        slope = linear + 2.0 * square @ self.centre[:, 0]
        return test_functions.coefficients(slope, square, self.unit[:, 0])


class SemigroupReference(NamedTuple):
    """What the equation says, for all schemes that are compared with it.

    Attributes
    ----------
    states : ndarray, shape (d, S)
    frame : Frame
        In which test functions are taken.
    t : tuple of float
        When the step of each size begins.
    h : ndarray, shape (H,)
    means : ndarray, shape (F, S, H)
        E phi(x(t + h)).
    scale : ndarray, shape (F, S, H)
        Without |phi| at a scheme's nodes: |D phi|_1 at the states, times the size of a component where that is more
        than its unit, plus the square of how far a step leads, which phi still has as its size where D phi = 0.
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

    def affordable(self, nodes: int) -> "SemigroupReference":
        """Return every k-th state only, so that steps at all nodes make no more than `WORK` paths."""
        some = slice(None, None, -(-self.states.shape[1] * nodes // WORK))
        states, means, scale = self.states[:, some], self.means[:, some], self.scale[:, some]
        return self._replace(states=states, means=means, scale=scale)


def why_not_local_weak(scheme: Scheme, view: Problem) -> str:
    """Return why a pair has no local weak order, or an empty string."""
    shortest = float(LEVELS[-1]) * time_unit(view)
    step = OneStep(scheme, view)
    why = why_not_nodes(scheme, view) or why_not_resolved(view, shortest) or step.why_not_probed()
    return why or step.why_not_sound(float(sizes(view)[-LEAST]))


def why_not_from(step: OneStep, x: Array) -> str:
    """Return why no step from some states, shape (d, S), has an order, or an empty string."""
    return step.why_not_sound(float(sizes(step.view)[-LEAST]), x)


def why_not_nodes(scheme: Scheme, view: Problem) -> str:
    """Return why the noise of a step has no cubature rule that resolves means, or an empty string."""
    nodes = _nodes(scheme, view.noise_dim)
    few = nodes.exact and len(nodes.weights) <= LARGEST
    return "" if few else f"noise in {view.noise_dim} dimensions has too many nodes"


def sizes(view: Problem, *, shortest: bool = False) -> Array:
    """Return the step sizes that are probed."""
    return np.asarray((SHORTEST if shortest else LEVELS) * time_unit(view))


def weak_reference(view: Problem, steps: Steps, *, further: bool = False) -> SemigroupReference:
    """Return the expectations that all schemes of one form are compared with on a problem.

    Parameters
    ----------
    view : Problem
        With an Ito equation.
    steps : tuple of pairs of float
        When each step begins, and its size.
    further : bool
        Whether the states are `spread_states`, with fewer trees, in place of the cloud.

    Returns
    -------
    SemigroupReference
        States at which the equation is not finite are left out.

    Raises
    ------
    ProblemError
        If there is no other.
    """
    ito = view.ito()
    assert ito is not None
    x, trees = cloud(view, ito), depth(ito.noise_dim)
    frame = frame_of(x)
    if further:
        x, trees = spread_states(view, ito, min(SPREAD, LEAVES // (2 * ito.noise_dim) ** SHALLOWEST)), SHALLOWEST
    found = _reference(ito, x, frame, steps, trees)
    if not (found.states.size or further):
        raise ProblemError("the Ito equation is finite at none of the states it is probed at")
    return found


def reference_from(view: Problem, x: Array, steps: Steps) -> SemigroupReference:
    """Return the expectations of test functions after steps from given states.

    Parameters
    ----------
    view : Problem
        With an Ito equation.
    x : ndarray, shape (d, S)
    steps : tuple of pairs of float
        When each step begins, and its size.

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
    """Return how far a step of Euler's method leads at most from each state in any component, shape (S,)."""
    branches = leaves(ito, x, t, h, 1).reshape(*x.shape, -1)
    return np.asarray((np.abs(branches - x[..., None]).max(axis=2) / unit).max(axis=0))


def frame_of(x: Array) -> Frame:
    """Return the frame of some states, shape (d, S): units are powers of two near the sizes of components."""
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
    """Probe one step of each size at each state of the cloud, and at each time that counts.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form; the pair has a local order, see `why_not_local_weak`.
    reference : callable, optional
        `weak_reference`, or what remembers it for further schemes.
    shortest : bool
        Whether the step sizes are `SHORTEST` in place of `LEVELS`.

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
    """Probe one step of each size from the states of a reference.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    known : SemigroupReference
        Of `reference_from`.

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
    """Return by how much defects of a step differ if another rule is taken, (F, S, H); S is 0 for a bounded law."""
    if step.scheme.law.bounded or not step.view.noise_dim:
        return np.zeros((len(defect), 0, len(known.h)))
    other = _nodes(step.scheme, step.view.noise_dim, other=True)
    return np.asarray(_defects_at(step, known, other)[0] - defect)


def _own_rounding(step: OneStep, known: SemigroupReference) -> Array:
    """Return how far a step moves at most if its state changes by one rounding error, in units of components, (H,).

    A step that divides a difference of states by h, or solves an equation up to a tolerance, makes more of a rounding
    error than eps of the state. The change itself, and a rounding error of each of the two steps that are compared,
    do not count. It is the mean over a few nodes of a state.
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
    """Yield where steps of each size lead from some states x at all nodes, shape (d, S K)."""
    wide, when = np.repeat(x, len(nodes.weights), axis=1), zip(known.t, known.h.tolist(), strict=True)
    batches = (PathBatch(wide, t, h, nodes.increment(h, x.shape[1])) for t, h in when)
    return (step.read(made.state) for made in step.together(batches))


def _defects_at(step: OneStep, known: SemigroupReference, nodes: Nodes) -> tuple[Array, Array]:
    """Return the defects of a step from one time, and their scale, both of shape (F, S, H).

    Of steps that are truncated they are NaN, and a state has none where some of the finest are.
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
    """Return the means of phi over the nodes and the largest |phi|, both of shape (F, S, H), at some states x."""
    states, count, found = x.shape[1], len(nodes.weights), []
    for end in _ends(step, known, nodes, x):
        phi = test_functions.values(known.frame.of(end))
        phi = phi.reshape(len(phi), states, count)
        found.append((nodes.mean(phi), np.maximum(phi.max(axis=-1), -phi.min(axis=-1))))
    means, largest = (np.stack(part, axis=-1) for part in zip(*found, strict=True))
    return means, largest
