"""Exactness on trivial equations: no scheme has an error on dx = 0, dx = c dt or dx = S dW beyond rounding.

A step of twice the length, noise used twice or for the wrong component, and noise of the wrong strength are off here
by a fixed part, however short the steps. Schemes that tame or balance their increments are off by a part that
vanishes with them, and are let pass. Where nothing is claimed of a scheme's paths, it is held to the law of dx = S dW
alone: (W_{n+1} - W_{n-1})/2 in the place of W_{n+1} - W_n is off by half an increment on each path, and right in law.
"""

from functools import cache
from itertools import chain
from typing import Any

import numpy as np

from ..contracts.scheme import Scheme
from ..errors import FAULTS, SdaeverifyError, one_line
from ..forms import Problem
from ..noise.brownian import Increment
from ..numerics.statistics import EPS
from ..probe.step.nodes import SEED
from .law import law_error
from .trivial import H, Trivial, trivial_problems
from .trivial_run import parts_along

STEPS, PATHS = 8, 3
# A relative error of order 1/2 or more in h falls below this power of the factor that steps are shortened by.
VANISHING = 0.4
# Measures that compare a scheme with the solution for the same Brownian motion.
PATHWISE = frozenset({"intervals", "limits", "multipliers", "strong", "uniform", "uniformity"})


@cache
def exactness_breach(scheme: Scheme) -> str:
    """Return the first trivial problem that a scheme gets wrong, in one line, or an empty string.

    The same on every problem that the scheme is put to, and found once.
    """
    forms: Any = scheme.forms
    for variants in chain.from_iterable(map(trivial_problems, forms)):
        if text := _first_miss(scheme, variants):
            return text
    return ""


def _first_miss(scheme: Scheme, variants: tuple[Trivial, ...]) -> str:
    """Return what is wrong on the first variant that the scheme refuses neither beforehand nor in its step."""
    for trivial in variants:
        if not _accepts(scheme, trivial.problem):
            continue
        try:
            text = _miss(scheme, trivial)
        except SdaeverifyError:
            continue
        several = trivial.problem.noise_dim
        hint = f" with {several} Brownian motions, which the scheme does not refuse" if several > 1 else ""
        return f"{text} on {trivial.name}{hint}" if text else ""
    return ""


def _accepts(scheme: Scheme, problem: Problem) -> bool:
    return scheme.noise <= problem.noise and not scheme.refuses(problem)


def _miss(scheme: Scheme, trivial: Trivial) -> str:
    try:
        error, moved, bound = _error(scheme, trivial, H)
        if error <= bound:
            return ""
        fine, fine_moved, fine_bound = _error(scheme, *trivial.shortened)
        if fine <= max(fine_bound, trivial.shorter**VANISHING * fine_moved * error / moved if moved else 0.0):
            return ""
        if trivial.noisy and PATHWISE.isdisjoint(claim.measure for claim in scheme.promises):
            return _miss_in_law(scheme, trivial)
    except SdaeverifyError:
        raise
    except FAULTS as fault:
        return f"a step raises {one_line(fault)}"
    return f"{STEPS} steps are off by {error:.2g}, of {moved:.2g} that the solution moves,"


def _miss_in_law(scheme: Scheme, trivial: Trivial) -> str:
    coarse, fine = law_error(scheme, trivial, H), law_error(scheme, *trivial.shortened)
    if coarse is None or fine is None or fine.share <= max(fine.rounding, trivial.shorter**VANISHING * coarse.share):
        return ""
    return f"{fine.quantity} of many steps is off by {fine.share:.2g} of what the solution's grows by,"


def _error(scheme: Scheme, trivial: Trivial, h: float) -> tuple[float, float, float]:
    """Return the largest error after some steps, how far the solution has moved, and what rounding explains."""
    problem = trivial.problem
    rng = np.random.Generator(np.random.Philox(key=SEED))
    draws = np.sqrt(h) * rng.standard_normal((STEPS, 2, problem.noise_dim, PATHS))
    noises = [scheme.law.increment(Increment(dW, area / np.sqrt(12.0)), h) for dW, area in draws]
    *_, got = parts_along(scheme, problem, h, noises)
    W = sum((noise.dW for noise in noises), np.zeros(draws.shape[2:]))
    before, after = trivial.solution(0.0, 0.0 * W), trivial.solution(STEPS * h, W)
    error = max(float(np.abs(got[name] - after[name]).max()) for name in after)
    moved = max(float(np.abs(after[name] - before[name]).max()) for name in after)
    size = max(float(np.abs(part).max()) for part in (*before.values(), *after.values()))
    return error, moved, 64.0 * EPS * STEPS * size
