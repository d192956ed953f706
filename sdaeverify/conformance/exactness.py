"""Exactness on trivial equations: no scheme has an error on dx = 0, dx = c dt or dx = S dW beyond rounding.

A step of twice the length, noise used twice or for the wrong component, and noise of the wrong strength are off here
by a fixed part, however short the steps. Schemes that tame or balance their increments are off by a part that
vanishes with them, and are let pass.
"""

from functools import cache
from itertools import chain
from typing import Any

import numpy as np

from ..errors import FAULTS, SdaeverifyError, one_line
from ..forms import Problem
from ..noise import Increment
from ..probe.nodes import SEED
from ..scheme import Scheme
from ..statistics import EPS
from .batches import frozen
from .trivial import SHORTER, H, Trivial, trivial_problems

STEPS, PATHS = 8, 3
# On so much shorter steps, a relative error that vanishes like h^(1/2) or faster is smaller by 2^10 at least.
VANISHING = 2.0**-8


@cache
def exactness_breach(scheme: Scheme) -> str:
    """Return the first trivial problem that a scheme gets wrong, in one line, or an empty string.

    The same on every problem that the scheme is put to, and found once.
    """
    forms: Any = scheme.forms
    for variants in chain.from_iterable(map(trivial_problems, forms)):
        accepted = next((trivial for trivial in variants if _accepts(scheme, trivial.problem)), None)
        if accepted is not None and (text := _miss(scheme, accepted)):
            several = accepted.problem.noise_dim
            hint = f" with {several} Brownian motions, which the scheme does not refuse" if several > 1 else ""
            return f"{text} on {accepted.name}{hint}"
    return ""


def _accepts(scheme: Scheme, problem: Problem) -> bool:
    return scheme.noise <= problem.noise and not scheme.refuses(problem)


def _miss(scheme: Scheme, trivial: Trivial) -> str:
    try:
        error, moved, bound = _error(scheme, trivial, H)
        if error <= bound:
            return ""
        fine, fine_moved, fine_bound = _error(scheme, trivial.finer or trivial, H * SHORTER)
    except SdaeverifyError:
        # A refusal that comes late: nothing is known.
        return ""
    except FAULTS as fault:
        return f"a step raises {one_line(fault)}"
    if fine <= max(fine_bound, VANISHING * fine_moved * error / moved if moved else 0.0):
        return ""
    return f"{STEPS} steps are off by {error:.2g}, of {moved:.2g} that the solution moves,"


def _error(scheme: Scheme, trivial: Trivial, h: float) -> tuple[float, float, float]:
    """Return the largest error after some steps, how far the solution has moved, and what rounding explains."""
    problem = trivial.problem
    rng = np.random.Generator(np.random.Philox(key=SEED))
    draws = np.sqrt(h) * rng.standard_normal((STEPS, 2, problem.noise_dim, PATHS))
    state, W, stepper = scheme.start(problem, PATHS, h), np.zeros(draws.shape[2:]), scheme.prepare(problem, h)
    before, recall = trivial.solution(0.0, W), problem.recall(h, PATHS)
    for n, (dW, area) in enumerate(draws):
        noise = scheme.law.increment(Increment(dW, area / np.sqrt(12.0)), h)
        noise = frozen(noise if recall is None else recall.driven(noise))
        state, W = stepper(frozen(state), n * h, noise).state, W + noise.dW
        if recall is not None:
            recall.push(scheme.parts(problem, state)["x"])
    after, got = trivial.solution(STEPS * h, W), scheme.parts(problem, state)
    error = max(float(np.abs(got[name] - after[name]).max()) for name in after)
    moved = max(float(np.abs(after[name] - before[name]).max()) for name in after)
    size = max(float(np.abs(part).max()) for part in (*before.values(), *after.values()))
    return error, moved, 64.0 * EPS * STEPS * size
