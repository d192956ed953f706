"""Checks of a problem's functions at its start for one and many paths, of its chart, and of derivatives.

Derivatives given by an author, and those by complex steps, are compared with finite differences. Construction already
rejects a problem with a discrepancy at the start; these checks compare along a run and with a smaller tolerance.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from ...arrays import Array
from ...errors import ProblemError
from ...forms import IndexOne, LevelSets, Multiplied, Penalised
from ...forms.checks import PROBES
from ...forms.mechanics.jacobian import DenseJacobian, check_linearisation
from ...numerics import apply, directional, is_analytic, jacobian, second_directional
from ...numerics.statistics import EPS
from ..check import Inapplicable
from ..subjects import PATHS, WHEN, ProblemSubject, directions, excess
from .differences import FIRST_ERROR, SECOND_ERROR, first, second

# Coefficients vary on the scale 1 or on that of a fine mesh; a correct derivative agrees on one of these scales.
LENGTHS = (1.0, 2.0**-5)
# Times, as parts of the horizon, at which coefficients have to be finite.
PARTS = (np.arange(64) + 0.5) / 64.0


def check_start(subject: ProblemSubject) -> str:
    """Expect all constraints, hidden ones and 0 = u included, to hold at the start of paths."""
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


def check_observables(subject: ProblemSubject) -> str:
    """Expect each observable to be one finite number per path, on one path and on three."""
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


def check_path_by_path(subject: ProblemSubject) -> str:
    """Expect drift and diffusion of a path not to depend on other paths of the batch."""
    x = subject.x
    for name in ("drift", "diffusion"):
        f = getattr(subject.equation, name)
        together = f(WHEN, x)
        together = np.broadcast_to(together, (*together.shape[:-1], PATHS))
        alone = np.concatenate([f(WHEN, x[:, p : p + 1])[..., :1] for p in range(PATHS)], axis=-1)
        if text := excess(alone - together, 8 * EPS, together):
            return f"{name} on one path differs from {name} on many: {text}"
    return ""


def check_finite_in_time(subject: ProblemSubject) -> str:
    """Expect drift and diffusion to be finite at the initial state at times over the horizon, excluding its end."""
    equation = subject.equation
    x, times = equation.initial(1), (equation.horizon * PARTS).tolist()
    with np.errstate(all="ignore"):
        wrong = (
            f"{name} is not finite at time {t:.4g}, at the state of the start"
            for t in times
            for name in ("drift", "diffusion")
            if not np.isfinite(getattr(equation, name)(t, x)).all()
        )
        return next(wrong, "")


def check_diffusion_product(subject: ProblemSubject) -> str:
    """Expect the given product of the diffusion with a vector to equal that of the matrix along a run."""
    equation, x = subject.equation, subject.x
    if equation.diffusion_product is None:
        raise Inapplicable("it gives no diffusion_product")
    w = np.random.default_rng(7).standard_normal((equation.noise_dim, PATHS))
    product = np.einsum("dlp,lp->dp", subject.B, w)
    text = excess(equation.diffusion_product(WHEN, x, w) - product, 64 * EPS * equation.noise_dim, subject.B)
    return text and f"diffusion_product is {text}"


def check_chart(subject: ProblemSubject) -> str:
    """Expect a chart to invert its embedding, to satisfy the constraints, and to cover the start."""
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


def check_diffusion_derivative(subject: ProblemSubject) -> str:
    """Expect DB(x) y, given or by complex step, to be the derivative of the diffusion, for Milstein's scheme."""
    equation, x = subject.equation, subject.x
    if reason := equation.why_not_derivative_of_diffusion():
        raise Inapplicable(reason)

    def B(z: Array) -> Array:
        return np.asarray(equation.diffusion(WHEN, z))

    derivative = partial(equation.derivative_of_diffusion, WHEN, x)
    if text := _wrong(B, derivative, x, subject.B):
        return f"DB(x) y is {text}"
    for y in directions(x) if is_analytic(B, x) else []:
        if text := excess(derivative(y) - directional(B, x, y), 64 * EPS, derivative(y)):
            return f"DB(x) y differs from a complex step: {text}"
    return ""


def check_jacobian(subject: ProblemSubject) -> str:
    """Expect Dg, given or by complex step, to be the derivative of the constraint, on and off the manifold."""
    problem, x = subject.offering(LevelSets), subject.x[: subject.problem.dimension]
    Dg, g = problem.dg(x), problem.constraint(x)
    if is_analytic(problem.constraint, x) and (text := excess(Dg - jacobian(problem.constraint, x), 16 * EPS, Dg)):
        return f"the Jacobian differs from complex steps: {text}"
    text = _wrong(problem.constraint, partial(apply, Dg), x, g)
    return text and f"the Jacobian is {text}"


def check_curvature(subject: ProblemSubject) -> str:
    """Expect the curvature D^2 g(y, z) to be symmetric and the second derivative of the constraint."""
    problem = subject.offering(Multiplied)
    r = subject.x[: problem.dimension]
    y, z, _ = directions(r)
    bend = problem.d2g(r, y, z)
    if text := excess(bend - problem.d2g(r, z, y), 16 * EPS, bend):
        return f"the curvature is not symmetric: {text}"
    # Complex steps balance truncation and rounding at 1e-12, times fourth derivatives along y and z of size 3.
    exact = second_directional(problem.constraint, r, y, z) if is_analytic(problem.constraint, r) else bend
    if text := excess(bend - exact, 1e-9, bend):
        return f"the curvature differs from complex steps: {text}"
    for w in (y, z, y + z):
        if text := excess(problem.d2g(r, w, w) - second(problem.constraint, r, w), SECOND_ERROR, bend):
            return f"the curvature is {text}"
    return ""


def check_second_derivatives(subject: ProblemSubject) -> str:
    """Expect the second derivatives of the constraint of Langevin dynamics, and their traces, to be those of Dg."""
    problem, x = subject.offering(Penalised), subject.x
    if text := _wrong(problem.dg, partial(problem.turn_normals, x), x, problem.dg(x)):
        return f"the second derivative is {text}"
    units = (np.broadcast_to(unit[:, None], x.shape) for unit in np.eye(len(x)))
    traces = sum(problem.turn_normals(x, unit)[:, i] for i, unit in enumerate(units))
    text = excess(problem.traces(x) - traces, 64 * EPS * len(x), traces)
    return text and f"the laplacians are {text}"


def check_force_derivatives(subject: ProblemSubject) -> str:
    """Expect the given derivatives of the force to be correct, because implicit schemes solve with them."""
    problem = subject.offering(Multiplied)
    if problem.force_derivatives is None:
        raise Inapplicable("it gives no force_derivatives")
    n = problem.dimension
    x = subject.x[: 2 * n]

    def force(z: Array) -> Array:
        return np.asarray(problem.force(WHEN, z[:n], z[n:]))

    by_r, by_v = problem.force_derivatives(WHEN, x[:n], x[n:])
    text = _wrong(force, lambda y: apply(by_r, y[:n]) + apply(by_v, y[n:]), x, force(x))
    return text and f"force_derivatives is {text}"


def check_given_linearisation(subject: ProblemSubject) -> str:
    """Expect the given linearised constraint to act as its matrix does along a run."""
    problem = subject.offering(Multiplied)
    if problem.linearisation is None:
        raise Inapplicable("it gives no linearisation")
    for begin in range(0, PATHS, PROBES):
        try:
            r = subject.x[: problem.dimension, begin : begin + PROBES]
            dense = DenseJacobian(problem.dg(r))
            check_linearisation(problem.linearised(r), dense, problem.dimension, problem.constraints)
        except ProblemError as error:
            return str(error)
    return ""


def check_delay_derivatives(subject: ProblemSubject) -> str:
    """Expect the partial derivatives in x, v and y, given or by complex step, to be those of f and of u."""
    problem = subject.offering(IndexOne)
    asked = [("drift", problem.drift, problem.linearised_drift)] if not problem.why_not_jacobian() else []
    if problem.constraints:
        asked.append(("constraint", problem.constraint, problem.linearised_constraint))
    if not asked:
        raise Inapplicable(problem.why_not_jacobian())
    sizes, z = np.cumsum([problem.dimension] * 2), np.concatenate(delay_arguments(problem))

    def split(w: Array) -> list[Array]:
        return np.split(w, sizes)

    def value(f: Callable[..., Array], at: Array) -> Array:
        return f(WHEN, *split(at))

    def change(matrices: Sequence[Array], w: Array) -> Array:
        return np.asarray(sum(apply(A, part) for A, part in zip(matrices, split(w), strict=True)))

    for name, f, linearised in asked:
        if text := _wrong(partial(value, f), partial(change, linearised(WHEN, *split(z))), z, value(f, z)):
            return f"the derivatives of {name} are {text}"
    return ""


def check_algebraic_solution(subject: ProblemSubject) -> str:
    """Expect the algebraic components, solved for or given by `solved`, to solve 0 = u along a run."""
    problem = subject.offering(IndexOne)
    if not problem.constraints:
        raise Inapplicable("it has no algebraic components")
    x, v, _ = delay_arguments(problem)
    y = problem.eliminated(WHEN, x, v)
    solved = np.isfinite(y).all(axis=0)
    if not solved.any():
        return "0 = u is solved nowhere beside the start"
    u, sizes = problem.constraint(WHEN, x, v, y)[:, solved], problem.linearised_constraint(WHEN, x, v, y)
    terms = [np.einsum("ijp,jp->ip", np.abs(A), np.abs(part)) for A, part in zip(sizes, (x, v, y), strict=True)]
    text = excess(u, 64 * EPS, *(term[:, solved] for term in terms))
    return text and f"u at the y that solves it is {text}"


def delay_arguments(problem: IndexOne) -> tuple[Array, Array, Array]:
    """Return x, v and y of the solution's size, with one value per path."""
    rng, d = np.random.default_rng(8), problem.dimension
    x, v = problem.initial(PATHS).x + rng.standard_normal((2, d, PATHS))
    return x, v, rng.standard_normal((problem.constraints, PATHS))


def _wrong(f: Callable[[Array], Array], derivative: Callable[[Array], Array], x: Array, size: Array) -> str:
    """Return the smallest error of y -> Df(x) y against differences over `LENGTHS` in words, or an empty string."""
    for y in directions(x):
        given = derivative(y)
        off = (length * given - first(f, x, length * y) for length in LENGTHS)
        texts = [excess(each, FIRST_ERROR, size, given) for each in off]
        if all(texts):
            return texts[-1]
    return ""
