"""One step against two half steps for every stiffness parameter: the local weak error, uniformly in eps.

Laurent (2022), Propositions 3.3 and 3.7: from all x with omega |zeta(x)| <= C sqrt(h), omega = 1 - e^{-h/eps},

    |E phi(X^eps(h)) - E phi(Phi_h(x))| <= C h^{3/2}        with one C for all eps.

What is seen of it, for the first and second moments of an increment (third ones are O(h^{3/2}) themselves), is

    D(h) = sup_{eps, x} |E phi(Phi_h(x)) - E phi(Phi_{h/2} o Phi_{h/2}(x))|,

and where eps is far above h the difference between Phi_h and Euler's step. Together they are enough: the local error
delta(h, eps) is, but for what a stable step adds up, the sum over k of 2^k D(h/2^k) and the limit of
2^k delta(h/2^k, eps), where eps is far above h/2^k. D = O(h^p) with p > 1 makes the sum O(h^p).

Expectations are sums over nodes: all atoms of a bounded law, else +-sqrt(n) e_i, which have the right moments up to
the third. What that leaves out is O(h^2).
"""

from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...numerics import norm
from ...numerics.statistics import EPS
from ..step.nodes import Nodes, step_nodes
from ..step.one_step import OneStep
from ..step.states import cloud
from ..step.step_noise import StepNoise
from .family import member

# Step sizes 4^-4, ..., 4^-8 of the horizon, or of the unit of time where that is shorter; and eps in steps.
LEVELS = 4.0 ** -np.arange(4.0, 9.0)
RATIOS = 10.0 ** np.array([-6.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 6.0])
# Every third point of the cloud, and how far to either side of the manifold, in standard deviations of the noise.
EVERY, SIDES = 3, (-1.0, 0.0, 1.0)
# Pairs of nodes at most.
MOST_PAIRS = 1_000
# A defect is used where it is so many times its rounding.
FLOORS = 300.0
# Euler's step is trusted to so many times h/eps.
NEARLY = 100.0


class UniformDefects(NamedTuple):
    """Defects of F first and second moments of an increment, at H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
        From coarse to fine.
    halves : ndarray, shape (F, H)
        The largest over states and eps of the difference between one step and two half steps.
    ratio : ndarray, shape (F, H)
        eps/h where it is taken.
    euler : ndarray, shape (F, H)
        The largest over states of the difference from Euler's step, for the largest eps.
    floor, nearly : ndarray, shape (F, H)
        Below the first, a difference between steps is rounding; below the second, Euler's step is itself off by as
        much, because eps is not infinite.
    failed : ndarray, shape (H,)
        Share of steps without root.
    """

    h: Array
    halves: Array
    ratio: Array
    euler: Array
    floor: Array
    nearly: Array
    failed: Array


def uniform_defects_refusal(scheme: Scheme, view: Any) -> str:
    """Return why nothing is known of one step for all eps, or an empty string; `no_family` has nothing against it."""
    law, motions = scheme.law, view.noise_dim
    if law.bounded and len(law.values) ** (2 * motions) > MOST_PAIRS:
        return f"two steps with {law.name} increments in {motions} dimensions have too many atoms"
    return OneStep(scheme, member(view)).refusal()


def uniform_defects(scheme: Scheme, view: Any) -> UniformDefects:
    """Return the defects of a pair that `uniform_defects_refusal` has nothing against."""
    sizes = LEVELS * min(1.0, view.horizon)
    with np.errstate(all="ignore"):
        levels = [_level(scheme, view, float(h)) for h in sizes]
    return UniformDefects(sizes, *(np.stack(parts, axis=-1) for parts in zip(*levels, strict=True)))


def _level(scheme: Scheme, view: Any, h: float) -> tuple[Array, ...]:
    x, sizes, failed = _states(view, h), [], 0.0
    for ratio in RATIOS:
        one_step = OneStep(scheme, member(view, ratio * h))
        whole, halves = _after(one_step, x, h, 1), _after(one_step, x, 0.5 * h, 2)
        sizes.append(np.abs(whole.moments - halves.moments).max(axis=1))
        failed = max(failed, whole.failed, halves.failed)
    nodes = _nodes(one_step)
    wide = np.repeat(x, len(nodes.weights), axis=1)
    plain = _moments(one_step.euler(wide, 0.0, h, nodes.increment(h, x.shape[1])) - wide, nodes.weights)
    table, euler = np.array(sizes), np.abs(whole.moments - plain).max(axis=1)
    nearly = whole.floor + NEARLY / RATIOS[-1] * np.abs(plain).max()
    return table.max(axis=0), RATIOS[table.argmax(axis=0)], euler, whole.floor, nearly, np.asarray(failed)


def _states(view: Any, h: float) -> Array:
    """Return points on the manifold, and beside it by what the noise of a step moves, shape (d, S)."""
    limit = member(view, 0.0)
    on = cloud(limit, limit.ito())[:, ::EVERY]
    normal = limit.push(limit.linearised(on), np.ones((limit.constraints, on.shape[1])))
    unit = normal / norm(normal)
    return np.concatenate([on + side * np.sqrt(h) * limit.strength * unit for side in SIDES], axis=1)


class _After(NamedTuple):
    # Moments (F, S) of what some steps add, the size of their rounding (F,), and the share of steps without root.
    moments: Array
    floor: Array
    failed: float


def _after(one_step: OneStep, x: Array, h: float, steps: int) -> _After:
    """Return what is known after steps whose nodes are all combined."""
    nodes = _nodes(one_step)
    count, states = len(nodes.weights), x.shape[1]
    wide = np.repeat(x, count**steps, axis=1)
    state, step, failed = one_step.enter(wide, 0.0, h), one_step.scheme.prepare(one_step.view, h), 0.0
    weights = np.ones(1)
    for index in np.indices((count,) * steps).reshape(steps, -1):
        noise = Nodes(nodes.dW[:, index], None if nodes.H is None else nodes.H[:, index], nodes.weights[index])
        result = step(state, 0.0, noise.increment(h, states))
        state, weights = result.state, weights * noise.weights
        failed = max(failed, 0.0 if result.failed is None else float(np.mean(result.failed)))
    added = one_step.read(state) - wide
    rounding = FLOORS * EPS * np.abs(x).max() * np.array([1.0, np.abs(added).max()])
    moments = _moments(added, weights)
    return _After(moments, np.repeat(rounding, [len(x), len(moments) - len(x)]), failed)


def _moments(added: Array, weights: Array) -> Array:
    """Return the means of y_i and of y_i y_j, i <= j, shape (F, S)."""
    y = added.reshape(len(added), -1, len(weights))
    i, j = np.triu_indices(len(y))
    return np.asarray(np.concatenate([y, y[i] * y[j]]) @ weights)


def _nodes(one_step: OneStep) -> Nodes:
    noise = StepNoise.of(one_step)
    if noise.law.bounded:
        return step_nodes(noise.motions, 0, law=noise.law)
    n = noise.normals
    return noise.nodes(np.sqrt(n) * np.concatenate([np.eye(n), -np.eye(n)], axis=1), np.full(2 * n, 0.5 / n))
