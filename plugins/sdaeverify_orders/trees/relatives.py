"""Test whether a step commutes with affine maps between related equations, near the origin and far out."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from sdaeverify import Array, Scheme
from sdaeverify.errors import FAULTS, one_line
from sdaeverify.numerics import largest
from sdaeverify.probing import Nodes, OneStep
from sdaeverify.trees import Relatives, far_problems

from .nodes import SEED, random_points
from .weights import NoStepError, moved

TIME_0 = far_problems.TIME_0

# Step size for the comparison of related equations.
H = 2.0**-4
# Far out, where a step may truncate a drift by its size and h, shorter steps are compared that do not: the shortest
# one with a drift of 2^20 moves the state by 2^-4, of which rounding in a state of that size is 2^-28.
SHORTER = (H, 2.0**-14, 2.0**-24)
# Rounding errors of a state in a step: sums over a few components and motions, and the maps before and after.
ROUNDINGS = 64.0
# Paths of a batch in which a path is compared with itself alone, and the distances of their states.
CROWD, NEAR = 256, 0.7


def distance(scheme: Scheme, relatives: Relatives, nodes: Nodes) -> float:
    """Return the distance of a step from commuting with the maps of two problems, relative to the states.

    Parameters
    ----------
    scheme : Scheme
    relatives : Relatives
        The problems and their maps.
    nodes : Nodes
        Noise of the problem `above`.

    Raises
    ------
    NoStepError
        If a step is truncated or fails.
    """
    return max(float(np.max(off / (1.0 + size))) for off, size, _ in _compared(scheme, relatives, nodes, H))


def distance_far(scheme: Scheme, relatives: Sequence[Relatives], nodes: Nodes) -> float:
    """Return the largest distance beyond rounding over pairs with a problem far out, relative to the step's motion.

    The problem `below` has states and coefficients of size 1. The map takes rounding errors of the problem `above`,
    eps of its size each, to it. Without noise a step moves the state by as little as h. Therefore the motion is the
    unit, and the part explained by rounding is subtracted.

    Parameters
    ----------
    scheme : Scheme
    relatives : sequence of Relatives
    nodes : Nodes
        Noise of the problems `above`.

    Raises
    ------
    NoStepError
        If a step of each size is truncated or fails.
    """
    return max((_shortened(scheme, each, nodes) for each in relatives), default=0.0)


def distance_alone(step: OneStep) -> float:
    """Return the distance of a path in a batch of different states and noises from the path alone, relative.

    Parameters
    ----------
    step : OneStep
    """
    start, nodes = step.equation.initial(1), random_points(step.view.noise_dim, step.scheme.law, CROWD)
    rng = np.random.Generator(np.random.Philox(key=SEED + 2))
    x = start + NEAR * rng.standard_normal((len(start), CROWD))
    with np.errstate(all="ignore"):
        every = step(x, step.time, H, nodes.increment(H))
        alone = step(x[:, :1], step.time, H, nodes.select(slice(1)).increment(H))
    off = np.abs(every[:, :1] - alone) / (1.0 + np.abs(alone))
    return float(np.max(off, initial=0.0, where=np.isfinite(off)))


def _shortened(scheme: Scheme, relatives: Relatives, nodes: Nodes) -> float:
    """Return the distance for the longest step size at which all steps can be computed."""
    for h in SHORTER:
        try:
            return max(map(_beyond_rounding, *zip(*_compared(scheme, relatives, nodes, h), strict=True)))
        except NoStepError as error:
            why = error
        except FAULTS as fault:
            raise NoStepError(f"a step far out raises {one_line(fault)}") from fault
    raise NoStepError(f"far out {why}") from why


def _beyond_rounding(off: Array, size: Array, motion: Array) -> float:
    explained = ROUNDINGS * np.finfo(float).eps * (1.0 + size)
    with np.errstate(all="ignore"):
        return float(np.nan_to_num(np.max((off - explained).clip(0.0)) / np.max(motion), nan=np.inf))


def _compared(scheme: Scheme, relatives: Relatives, nodes: Nodes, h: float) -> list[tuple[Array, Array, Array]]:
    """Return the distance, the size of the states and the motion for each component of `below`, shapes (S K,)."""
    above, below = (OneStep(scheme, problem) for problem in (relatives.above, relatives.below))
    states = above.equation.initial(1) if relatives.states is None else relatives.states
    x = np.repeat(states, len(nodes.weights), axis=1)
    z = np.concatenate(
        [A @ x[above.names[name]] + c for name, (A, c) in relatives.maps.items() if name in above.names]
    )
    higher = scheme.parts(relatives.above, moved(above, x, nodes, h, TIME_0 + relatives.delay)[1])
    begin, end = moved(below, z, driven(nodes, relatives.driven), h, TIME_0 + relatives.later)
    before, lower = (scheme.parts(relatives.below, state) for state in (begin, end))
    found = []
    for name, (A, c) in relatives.maps.items():
        off, size = A @ higher[name] + c - lower[name], largest(lower[name])
        found.append((largest(off), size, largest(lower[name] - before[name])))
    if not all(np.isfinite(part).all() for each in found for part in each):
        raise NoStepError(f"a step of size {h:g} is not finite")
    return found


def driven(nodes: Nodes, by: Array) -> Nodes:
    """Return the noise of Brownian motions that are linear combinations of given ones.

    Parameters
    ----------
    nodes : Nodes
        Noise of m motions, with some of dW, H, K and A.
    by : ndarray, shape (l, m)
        Coefficients of the combinations.
    """
    dW, H, K = (None if part is None else by @ part for part in (nodes.dW, nodes.H, nodes.K))
    assert dW is not None
    if nodes.A is None:
        return nodes._replace(dW=dW, H=H, K=K)
    (l, m), count = by.shape, len(nodes.weights)
    areas = np.zeros((m, m, count))
    for place, (i, j) in enumerate(combinations(range(m), 2)):
        areas[i, j], areas[j, i] = nodes.A[place], -nodes.A[place]
    areas = np.einsum("ai,bj,ijk->abk", by, by, areas)
    A = [areas[i, j] for i, j in combinations(range(l), 2)]
    return nodes._replace(dW=dW, H=H, K=K, A=np.reshape(A, (-1, count)))


def within(error: float) -> str:
    """Return a distance in words: ``to 3e-16``, or ``exactly`` if it is 0."""
    return f"to {error:.0e}" if error else "exactly"
