"""Checks of the known pathwise solution of a problem, without simulation."""

import numpy as np

from ...conformance.own_run import level_noise
from ...forms.truths import Pathwise
from ...numerics.statistics import EPS
from ..check import Inapplicable
from ..subjects import ProblemSubject


def solution(subject: ProblemSubject) -> Pathwise:
    """Return the pathwise truth of a problem.

    Raises
    ------
    Inapplicable
        If the problem has none.
    """
    truth = subject.problem.pathwise
    if truth is None:
        raise Inapplicable("it has no solution along paths")
    assert isinstance(truth, Pathwise)
    return truth


def check_start(subject: ProblemSubject) -> str:
    """Expect the solution to have components of the problem, with the right values at time 0."""
    truth, problem = solution(subject), subject.problem
    known, start = truth.parts(0.0, truth.start(3)), problem.parts(problem.initial(3))
    if not known or not known.keys() <= start.keys():
        return f"the solution provides {sorted(known)}, the problem's components are {sorted(start)}"
    for name, value in known.items():
        if value.shape != start[name].shape:
            return f"the solution gives {name} in shape {value.shape}, the problem in {start[name].shape}"
        if not np.all(np.abs(value - start[name]) <= 4 * EPS * np.maximum(1.0, np.abs(start[name]))):
            return f"the solution begins with another {name}"
    return ""


def check_step(subject: ProblemSubject) -> str:
    """Expect a step of the solution to keep its shape and its inputs unchanged, on one path and on three."""
    truth, problem = solution(subject), subject.problem
    h = problem.horizon / 8
    for paths in (1, 3):
        z, noise = truth.start(paths), level_noise(problem, paths, h, 0)
        noise = noise._replace(xi=np.ones((truth.extra_normals, paths)) if truth.extra_normals else None)
        assert noise.H is not None
        before = z.copy(), noise.dW.copy(), noise.H.copy()
        new = truth.advance(z, 0.0, h, noise)
        if new.shape != z.shape or not np.isfinite(new).all():
            return f"a step of the solution on {paths} paths is not finite, or has shape {new.shape}"
        if not all(np.array_equal(a, b) for a, b in zip((z, noise.dW, noise.H), before, strict=True)):
            return "a step of the solution writes into its state or its noise"
    return ""


def check_standstill(subject: ProblemSubject) -> str:
    """Expect the solution to return its state to the bit after a step of length 0 with dW = 0."""
    truth, none = solution(subject), np.zeros((subject.problem.noise_dim, 1))
    z, nothing = truth.start(1), subject.problem.drawn(np.random.default_rng(0), 0.0, 1)
    extra = np.ones((truth.extra_normals, 1)) if truth.extra_normals else None
    same = np.array_equal(truth.advance(z, 0.0, 0.0, nothing._replace(dW=none, H=none, xi=extra)), z)
    return "" if same else "a step of length 0 changes the solution"
