"""Checks of views: the SDE of a problem keeps the constraints and is the same equation."""

from typing import Any

import numpy as np

from ...arrays import Array
from ...forms import Damped, Delayed, IndexOne, Multiplied, Penalised
from ...numerics.statistics import EPS
from ..check import Inapplicable
from ..subjects import WHEN, ProblemSubject, excess
from .differences import FIRST_ERROR, SECOND_ERROR, first, second


def check_constraints_kept(subject: ProblemSubject) -> str:
    """Expect drift and diffusion of the SDE to keep the constraints: Dg B = 0, and Ito's condition on the drift.

    For mechanics, Dg v is constant, on and off the manifold: Dg a + D^2 g(v, v) = 0. For an SDE with an invariant g,
    at points with g = 0: Dg f + (1/2) sum_j D^2 g(B_j, B_j) = 0.
    """
    if subject.problem.capability(Multiplied):
        return _check_velocities(subject)
    if subject.equation.constraint is None:
        raise Inapplicable("it has no constraint that its SDE could leave")
    return _check_points(subject.equation, subject.x)


def _check_velocities(subject: ProblemSubject) -> str:
    problem, x, n = subject.problem, subject.x, subject.problem.dimension
    f, B = subject.equation.drift(WHEN, x), subject.B
    Dg, v = problem.dg(x[:n]), x[n:]
    turning = problem.d2g(x[:n], v, v)
    noise = np.einsum("mnp,nlp->mlp", Dg, B[n:])
    if not np.array_equal(f[:n], v) or B[:n].any():
        return "dr is not v dt"
    if text := excess(noise, 64 * EPS, B):
        return f"Dg B of the inherent SDE is {text}"
    text = excess(np.einsum("mnp,np->mp", Dg, f[n:]) + turning, 64 * EPS, turning, f)
    return text and f"Dg a + D^2 g(v, v) of the inherent SDE is {text}"


def _check_points(equation: Any, near: Array) -> str:
    x = equation.admissible(near)
    f, B = equation.drift(WHEN, x), _matrix(equation, x)
    Dg, constraint = equation.dg(x), equation.constraint
    assert constraint is not None
    if text := excess(np.einsum("mnp,nlp->mlp", Dg, B), 64 * EPS, Dg, B):
        return f"Dg B is {text}"
    rate = np.einsum("mnp,np->mp", Dg, f)
    for column in np.moveaxis(B, 1, 0):
        length = np.maximum(np.linalg.norm(column, axis=0), EPS)
        rate = rate + 0.5 * length**2 * second(constraint, x, column / length)
    scale = float(np.max(np.abs(B))) ** 2 * equation.noise_dim
    text = excess(rate, SECOND_ERROR * max(1.0, scale), f)
    return text and f"Dg f + (1/2) sum_j D^2 g(B_j, B_j) is {text}: the drift lacks a part of Ito's term"


def check_same_equation(subject: ProblemSubject) -> str:
    """Expect the SDE view of a problem to be its equation, assembled here independently."""
    problem = subject.problem
    if problem.capability(Penalised):
        return _check_penalised(subject) if problem.eps else _check_tangential(subject)
    views = {Multiplied: _check_push_along_normals, IndexOne: _check_without_y, Damped: _check_damped}
    for kind, check in views.items():
        if problem.capability(kind):
            return check(subject)
    raise Inapplicable("it is an SDE itself")


def _check_push_along_normals(subject: ProblemSubject) -> str:
    """Check that M dv = a dt + B dw + grad g dmu with the dmu of the equation with a multiplier."""
    problem, x, n = subject.problem, subject.x, subject.problem.dimension
    r, v = x[:n], x[n:]
    full = problem.ito()
    state = np.concatenate([x, np.zeros((problem.constraints, x.shape[-1]))])
    f, B, Dg = full.drift(WHEN, state), _matrix(full, state), problem.dg(r)
    push = np.einsum("mnp,mp->np", Dg, f[2 * n :])
    kick = np.einsum("mnp,mlp->nlp", Dg, B[2 * n :])
    force = f[n : 2 * n] - problem.inverse_mass(problem.force(WHEN, r, v) + push)
    noise = B[n : 2 * n] - problem.inverse_mass(problem.diffusion(WHEN, r, v) + kick)
    if text := excess(force, 64 * EPS, push, f) or excess(noise, 64 * EPS, kick, B):
        return f"dv - M^{{-1}} (a dt + B dw + grad g dmu) is {text}"
    drift = excess(subject.equation.drift(WHEN, x) - f[: 2 * n], 64 * EPS, f)
    text = drift or excess(subject.B - B[: 2 * n], 64 * EPS, B)
    return text and f"the inherent SDE without multiplier and that with it differ: {text}"


def _check_tangential(subject: ProblemSubject) -> str:
    """Check that constrained dynamics have the tangential part of f, and sigma times the projector as noise."""
    problem, x = subject.problem, subject.problem.admissible(subject.x)
    flat = np.eye(len(x)) - _normals(problem.dg(x))
    f, noise = subject.equation.drift(WHEN, x) - problem.drift(x), _matrix(subject.equation, x)
    if text := excess(np.einsum("pij,jp->ip", flat, f), 64 * EPS, f, problem.drift(x)):
        return f"the drift adds a tangential part to f: it is {text}"
    text = excess(noise - problem.strength * np.moveaxis(flat, 0, -1), 64 * EPS, noise)
    return text and f"the noise differs from sigma times the projector: it is {text}"


def _check_penalised(subject: ProblemSubject) -> str:
    """Check that penalised dynamics add (sigma^2/4) grad ln det G - (1/eps) g G^{-1} zeta, with noise sigma dW."""
    problem, x = subject.problem, subject.x

    def log_det(z: Array) -> Array:
        Dg = np.moveaxis(problem.dg(z), -1, 0)
        return np.asarray(np.linalg.slogdet(Dg @ Dg.swapaxes(1, 2))[1])

    Dg = np.moveaxis(problem.dg(x), -1, 0)
    pull = np.einsum("pij,jp->ip", np.linalg.pinv(Dg), problem.constraint(x)) / problem.eps
    units = (np.broadcast_to(unit[:, None], x.shape) for unit in np.eye(len(x)))
    fixman = 0.25 * problem.strength**2 * np.stack([first(log_det, x, unit) for unit in units])
    f = subject.equation.drift(WHEN, x)
    rest = f - problem.drift(x) - fixman + pull
    if text := excess(rest, 8 * FIRST_ERROR * max(1.0, problem.strength**2), f, pull, fixman):
        return f"the drift of the penalised SDE is {text}"
    unit = problem.strength * np.eye(len(x))[..., None]
    text = excess(subject.B - unit, EPS, unit)
    return text and f"the noise of the penalised SDE is {text}"


def _check_without_y(subject: ProblemSubject) -> str:
    """Check that without delay the SDE has the drift and noise of x, with the y that solves 0 = u."""
    problem = subject.problem
    if problem.capability(Delayed):
        raise Inapplicable("with a delay it has no view as an SDE")
    x = subject.x
    y = problem.eliminated(WHEN, x, x)
    f, g = problem.drift(WHEN, x, x, y), problem.diffusion(WHEN, x, x, y)
    if text := excess(subject.equation.drift(WHEN, x) - f, 8 * EPS, f):
        return f"the drift of the SDE is {text}"
    text = excess(subject.B - g, 8 * EPS, g)
    return text and f"the noise of the SDE is {text}"


def _check_damped(subject: ProblemSubject) -> str:
    """Check that the first-order system is dq = p dt, dp = (F - gamma p) dt + sigma dW."""
    problem, x, n = subject.problem, subject.x, subject.problem.noise_dim
    f = np.concatenate([x[n:], problem.force(x[:n]) - problem.friction * x[n:]])
    B = problem.strength * np.eye(2 * n)[:, n:, None]
    text = excess(subject.equation.drift(WHEN, x) - f, 8 * EPS, f) or excess(subject.B - B, 8 * EPS, B)
    return text and f"the first-order system is {text}"


def _normals(Dg: Array) -> Array:
    """Return the projector onto the span of the gradients on each path, shape (P, n, n)."""
    gradients = np.moveaxis(Dg, -1, 0).swapaxes(1, 2)
    return np.asarray(gradients @ np.linalg.pinv(gradients))


def _matrix(equation: Any, x: Array) -> Array:
    return np.asarray(np.broadcast_to(equation.diffusion(WHEN, x), (len(x), equation.noise_dim, x.shape[-1])))
