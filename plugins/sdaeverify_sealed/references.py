"""What is known of an observable without the solver: an exact mean, or one over paths of the problem's reference."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, InvariantMean, Moment, Pathwise, Problem
from sdaeverify.measuring import group_sums
from sdaeverify.numerics import GROUPS
from sdaeverify.studying import Brownian, Source

# The measures that a sealed solver claims something of.
WEAK, INVARIANT = "weak", "invariant"
# Steps of a reference with an error of its own, and of one that is exact.
FINE, EXACT = 2**8, 1
# Paths of a reference that are simulated together.
BLOCK = 2**14


class Reference(NamedTuple):
    """The mean of an observable that a solver is compared with.

    Attributes
    ----------
    mean : ndarray, shape (G,)
        The exact mean in each entry; or means of G groups of paths, which are independent of the solver's.
    bias : float
        Bound of the error that more paths leave as it is; 0 for an exact mean.
    """

    mean: Array
    bias: float = 0.0


def exact_means(problem: Problem, measure: str) -> dict[str, float]:
    """Return the exact means of observables, by name: at the horizon, or under the invariant law.

    Parameters
    ----------
    problem : Problem
        With its moment equations as observables of mean 0 (`Problem.with_moment_equations`).
    measure : str
        ``weak`` or ``invariant``.
    """
    if measure == INVARIANT:
        return {truth.observable: truth.value for truth in problem.truths if isinstance(truth, InvariantMean)}
    moments = (truth for truth in problem.truths if isinstance(truth, Moment))
    return {truth.observable: truth.value(problem.horizon) for truth in moments}


def references(problem: Problem, measure: str, names: Sequence[str], source: Source) -> dict[str, Reference]:
    """Return the references of some observables; those of which nothing is known are left out.

    Parameters
    ----------
    problem : Problem
        As of `exact_means`.
    measure : str
        ``weak`` or ``invariant``.
    names : sequence of str
        Of the observables.
    source : Source
        Of the paths of a reference, with their number.
    """
    known = {name: Reference(np.full(GROUPS, mean)) for name, mean in exact_means(problem, measure).items()}
    missing = [name for name in names if name not in known]
    if measure == WEAK and missing and problem.pathwise is not None and not problem.records:
        known |= sampled(problem, problem.pathwise, missing, source)
    return {name: known[name] for name in names if name in known}


def sampled(problem: Problem, known: Pathwise, names: Sequence[str], source: Source) -> dict[str, Reference]:
    """Return means of observables over paths of the problem's reference solution.

    The bound of the bias of a reference of order q is the change that halving its step makes, over 2^q - 1.

    Parameters
    ----------
    problem : Problem
    known : Pathwise
        Its reference solution.
    names : sequence of str
        Of the observables.
    source : Source
        With the number of paths.
    """
    sums: dict[str, list[Array]] = {name: [] for name in names}
    for block in range(-(-source.paths // BLOCK)):
        ends = _ends(problem, known, source._replace(block=block, paths=min(BLOCK, source.paths)))
        for name in names:
            values = [problem.observe(name, problem.horizon, known.parts(problem.horizon, end)) for end in ends]
            if all(each is not None for each in values):
                sums[name].append(group_sums(np.stack([np.asarray(each) for each in values])))
    size = min(BLOCK, source.paths)
    counts = group_sums(np.ones(size))[:, None] * -(-source.paths // BLOCK)
    means = {name: np.sum(blocks, axis=0) / counts for name, blocks in sums.items() if blocks}
    halved = 2.0**known.order - 1.0
    return {
        name: Reference(mean[:, -1], 0.0 if known.exact else float(abs((mean[:, 0] - mean[:, -1]).mean())) / halved)
        for name, mean in means.items()
    }


def _ends(problem: Problem, known: Pathwise, source: Source) -> list[Array]:
    """Return final states of the reference on one block of paths, of its two step sizes, the finer one last."""
    steps = EXACT if known.exact else FINE // 2
    h, rng = problem.horizon / steps, source.stream("extra normals", 0)
    states = [known.start(source.paths) for _ in range(2)]
    for number, levels in enumerate(Brownian(source, problem.noise_dim, h, 1, frozenset(problem.noise)).steps()):
        if number == steps:
            break
        for level, noise in enumerate(levels):
            size = h / 2**level
            for step in range(len(noise.dW)):
                xi = rng.standard_normal((known.extra_normals, source.paths)) if known.extra_normals else None
                t = number * h + step * size
                increment = noise.increment(step)._replace(xi=xi)
                states[level] = known.advance(states[level], t, size, increment)
    return states
