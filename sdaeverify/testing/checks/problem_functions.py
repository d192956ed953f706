"""Checks of a problem's functions at its start, on one path and on many, and of its chart."""

import numpy as np

from ...numerics.statistics import EPS
from ..check import Inapplicable
from ..problem_subject import PATHS, WHEN, ProblemSubject, excess


def consistent(subject: ProblemSubject) -> str:
    """Expect all constraints to hold at the start, the hidden ones and 0 = u too: paths begin there."""
    problem = subject.problem
    residuals = problem.residuals(subject.start())
    if bool(residuals) != problem.has_constraints:
        return f"has_constraints is {problem.has_constraints}, but it has {len(residuals)} residuals"
    if not residuals:
        raise Inapplicable("it has no constraint")
    for name, (value, scale) in residuals.items():
        if text := excess(value, 8 * EPS, scale):
            return f"{name} at the start is {text}"
    return ""


def observed(subject: ProblemSubject) -> str:
    """Expect each observable to be one finite number a path, on one path and on three."""
    problem = subject.problem
    if not problem.observables:
        raise Inapplicable("it has no observables: only paths can be compared on it")
    for paths in (1, 3):
        parts = problem.parts(problem.initial(paths))
        for name, observable in problem.observables.items():
            value = np.asarray(observable(0.0, parts))
            if value.shape != (paths,):
                return f"observable {name} has shape {value.shape} on {paths} paths"
            if not np.isfinite(value).all():
                return f"observable {name} is not finite at the start"
    return ""


def path_by_path(subject: ProblemSubject) -> str:
    """Expect drift and diffusion of a path not to depend on the paths beside it."""
    x = subject.x
    for name in ("drift", "diffusion"):
        f = getattr(subject.equation, name)
        together = f(WHEN, x)
        together = np.broadcast_to(together, (*together.shape[:-1], PATHS))
        alone = np.concatenate([f(WHEN, x[:, p : p + 1])[..., :1] for p in range(PATHS)], axis=-1)
        if text := excess(alone - together, 8 * EPS, together):
            return f"{name} on one path differs from {name} on many: {text}"
    return ""


def multiplied(subject: ProblemSubject) -> str:
    """Expect the given product of the diffusion with a vector to be that of the matrix, wherever a path goes."""
    equation, x = subject.equation, subject.x
    if equation.diffusion_product is None:
        raise Inapplicable("it gives no diffusion_product")
    w = np.random.default_rng(7).standard_normal((equation.noise_dim, PATHS))
    product = np.einsum("dlp,lp->dp", subject.B, w)
    text = excess(equation.diffusion_product(WHEN, x, w) - product, 64 * EPS * equation.noise_dim, subject.B)
    return text and f"diffusion_product is {text}"


def charted(subject: ProblemSubject) -> str:
    """Expect a chart to read the coordinates it embeds, on the manifold, and to cover the start."""
    problem = subject.problem
    if problem.chart is None:
        raise Inapplicable("it has no chart")
    chart, ito = problem.chart, problem.ito()
    z = np.random.default_rng(2).uniform(-2.5, 2.5, (len(chart.axes), PATHS))
    x, start = chart.embed(z), ito.initial(1)
    if x.shape != (ito.dimension, PATHS):
        return f"chart.embed returns shape {x.shape}, expected {(ito.dimension, PATHS)}"
    terms = {
        "coordinates read from the state they make are": (chart.read(x) - z, z),
        "states embedded again are": (chart.embed(chart.read(x)) - x, x),
        "the start, embedded again, is": (chart.embed(chart.read(start)) - start, start),
        **{f"{name} on the chart is": pair for name, pair in problem.residuals(ito.parts(x)).items()},
    }
    return next((f"{name} {text}" for name, (v, size) in terms.items() if (text := excess(v, 16 * EPS, size))), "")
