"""Checks of a problem's declarations.

Claims rest on the declared traits of a problem's noise, constraints and delay. The functions in `EVIDENCE` return the
evidence against a trait in one line, or an empty string.
"""

import pickle
from collections.abc import Callable

import numpy as np

from ...arrays import Array
from ...contracts.labels import parse_label
from ...contracts.specs import check_problem_function, matrix_specs, problem_spec
from ...errors import SdaeverifyError
from ...forms import Delayed, Dissipation, IndexOne, known_traits
from ...forms.sde.linear_growth import grows_linearly
from ...forms.traits import COMMUTING, Trait
from ...forms.truths import InvariantMean, MomentEquation
from ...numerics.statistics import EPS
from ...registry.selection import select_measures, select_schemes
from ..check import error_text
from ..subjects import WHEN, ProblemSubject, excess
from .differences import FIRST_ERROR, first
from .problem_functions import delay_arguments

TIMES = (0.0, 0.37, 0.91)
# Number of states drawn from a domain.
STATES = 64


def check_usable(subject: ProblemSubject) -> str:
    """Expect a function with a name, and with parameters whose defaults a label can represent."""
    return error_text(check_problem_function, subject.spec.function)


def check_builds(subject: ProblemSubject) -> str:
    """Expect the function to return a consistent problem."""
    return error_text(subject.spec.build)


def check_label(subject: ProblemSubject) -> str:
    """Expect the label to recreate the problem, because commands that reproduce results contain only the label."""
    spec = subject.spec
    again = problem_spec(spec.function, parse_label(spec.label).parameters)
    return "" if again == spec else f"its label {spec.label} makes another problem, {again.label}"


def check_pickling(subject: ProblemSubject) -> str:
    """Expect the function to be pickled by name, because worker processes receive it that way."""
    spec = subject.spec
    return "" if pickle.loads(pickle.dumps(spec)) == spec else "its pickled copy is another recipe"


def check_docstring(subject: ProblemSubject) -> str:
    """Expect a docstring, because lists of problems show its first line."""
    return "" if (subject.spec.function.__doc__ or "").strip() else "its function has no docstring"


def check_sources(subject: ProblemSubject) -> str:
    """Expect units, and sources of the problem and of each truth."""
    problem = subject.problem
    if missing := [name for name in ("source", "units") if not getattr(problem, name).strip()]:
        return f"its {' and '.join(missing)} is empty"
    silent = [type(truth).__name__ for truth in problem.truths if not truth.source.strip()]
    return f"a {silent[0]} among its truths has no source" if silent else ""


def check_in_matrix(subject: ProblemSubject) -> str:
    """Expect each matrix entry of the function to build, and its named schemes and measures to exist."""
    try:
        for spec in matrix_specs(subject.spec.function):
            spec.build()
            select_schemes(subject.registry, spec.schemes or ("*",))
            select_measures(subject.registry, spec.measures)
    except SdaeverifyError as error:
        return str(error)
    return ""


def check_relaxation(subject: ProblemSubject) -> str:
    """Expect a relaxation time if and only if an invariant law is known, because it sets the length of chains."""
    problem = subject.problem
    known = any(isinstance(truth, InvariantMean | MomentEquation) for truth in problem.truths)
    if not problem.relaxation_time > 0.0:
        return f"its relaxation time is {problem.relaxation_time!r}, expected a positive time"
    if known and not np.isfinite(problem.relaxation_time):
        return "it knows invariant means or moment equations, but no relaxation time"
    if not known and np.isfinite(problem.relaxation_time):
        return "it has a relaxation time, but knows no invariant mean and no moment equation"
    return ""


def check_traits(subject: ProblemSubject) -> str:
    """Expect every declared trait to be true, because a false one leads to refutation of claims never made."""
    # Implied traits come after the trait that implies them, because the author declared only the latter.
    for name in sorted(subject.problem.traits, key=lambda name: (name not in COMMUTING, name)):
        if text := _evidence_against(subject, name):
            return f"trait {name} is false: {text}"
    return ""


def _evidence_against(subject: ProblemSubject, name: str) -> str:
    if name in EVIDENCE:
        return EVIDENCE[name](subject)
    stated = next(trait for trait in subject.problem.traits if trait == name)
    trait = stated if isinstance(stated, Trait) else known_traits(type(subject.problem))[name]
    return trait.against(subject.problem) if trait.against else ""


def _scalar(subject: ProblemSubject) -> str:
    noise_dim = subject.problem.noise_dim
    return "" if noise_dim == 1 else f"it has {noise_dim} Brownian motions"


def _linear_growth(subject: ProblemSubject) -> str:
    return "" if grows_linearly(subject.equation) else "drift or diffusion grows faster than linearly along rays"


def _additive(subject: ProblemSubject) -> str:
    problem, x = subject.problem, subject.x
    own = [problem.own_diffusion(t, x) for t in TIMES]
    values = [subject.equation.diffusion(t, x) if B is None else B for t, B in zip(TIMES, own, strict=True)]
    same = all(np.array_equal(B, np.broadcast_to(values[0][..., :1], B.shape)) for B in values)
    return "" if same else "the diffusion depends on time or on the state"


def _diagonal(subject: ProblemSubject) -> str:
    x, B = subject.x, subject.B
    if B.shape[0] != B.shape[1] or B[~np.eye(len(x), dtype=bool)].any():
        return "the diffusion is no diagonal matrix"
    for k in range(len(x)):
        unit = np.broadcast_to(np.eye(len(x))[:, k : k + 1], x.shape)
        change = np.einsum("jjp->jp", _slope(subject, unit) + 0.0 * B)
        if text := excess(np.delete(change, k, axis=0), FIRST_ERROR, B):
            return f"an entry of the diffusion depends on component {k + 1}, which is another one's: {text}"
    return ""


def _commutative(subject: ProblemSubject) -> str:
    l = subject.equation.noise_dim
    turned = np.stack([_slope(subject, subject.B[:, k]) for k in range(l)], axis=2)
    text = excess(turned - turned.swapaxes(1, 2), 2 * FIRST_ERROR, subject.B)
    return f"DB_j B_k - DB_k B_j is {text}" if text else ""


def _no_milstein_term(subject: ProblemSubject) -> str:
    terms = (_slope(subject, subject.B[:, k]) for k in range(subject.equation.noise_dim))
    return next((f"DB_j B_k is {text}" for term in terms if (text := excess(term, FIRST_ERROR, subject.B))), "")


def _normal_milstein_term(subject: ProblemSubject) -> str:
    if not subject.problem.has_constraints:
        return "there is no constraint"
    view = subject.equation
    x = view.admissible(subject.x)
    B = np.broadcast_to(view.diffusion(WHEN, x), subject.B.shape)
    gradients = np.moveaxis(view.dg(x), -1, 0)
    flat = np.eye(len(x)) - np.linalg.pinv(gradients) @ gradients
    for k in range(view.noise_dim):
        change = first(lambda z: view.diffusion(WHEN, z), x, B[:, k])
        rest = np.einsum("pij,jlp->ilp", flat, np.broadcast_to(change, B.shape))
        if text := excess(rest, 4 * FIRST_ERROR, B):
            return f"a part of DB_j B_k beside normals is {text}"
    return ""


def _gradient(subject: ProblemSubject) -> str:
    """Check that the diffusion is a multiple of Id and the derivative of the drift is symmetric."""
    x, B, f = subject.x, subject.B, subject.equation.drift
    unit = np.eye(len(x))[..., None]
    if B.shape[1] != len(x) or not np.array_equal(B, B[0, 0] * unit + 0.0 * B):
        return "the diffusion is no multiple of Id"
    values = [f(t, x) + 0.0 * x for t in TIMES]
    if not all(np.array_equal(value, values[0]) for value in values):
        return "the drift depends on time"
    columns = [first(lambda z: f(WHEN, z) + 0.0 * z, x, unit[k] + 0.0 * x) for k in range(len(x))]
    J = np.stack(columns, axis=1)
    text = excess(J - J.swapaxes(0, 1), 2 * FIRST_ERROR, values[0])
    return f"Df less its transpose is {text}" if text else ""


def _free(subject: ProblemSubject) -> str:
    problem = subject.problem
    return "it has a constraint" if problem.has_constraints or problem.residuals(subject.start()) else ""


def _constrained(subject: ProblemSubject) -> str:
    return "" if subject.problem.has_constraints else "it has no constraint"


def _index_1(subject: ProblemSubject) -> str:
    problem = subject.problem.capability(IndexOne)
    if problem is None or not problem.constraints:
        return "it has no algebraic components"
    u_y = problem.linearised_constraint(WHEN, *delay_arguments(problem)).y
    regular = np.linalg.matrix_rank(np.moveaxis(u_y, -1, 0)).min() == problem.constraints
    return "" if regular else "du/dy is singular"


def _no_delay(subject: ProblemSubject) -> str:
    delayed = subject.problem.capability(Delayed)
    return "" if delayed is None else f"its delay is {delayed.delay}"


def _delayed_noise(subject: ProblemSubject) -> str:
    problem = subject.problem.capability(IndexOne)
    if problem is None:
        return "it has no delay"
    x, v, y = delay_arguments(problem)
    here, there = (problem.diffusion(WHEN, z, v, w) for z, w in ((x, y), (y.sum() - 2.0 * x, 1.0 - y)))
    return "" if np.array_equal(here, there) else "the diffusion depends on x or on y"


def _dissipative(subject: ProblemSubject) -> str:
    """Check condition (4.1) at random arguments, as it stands and with y eliminated."""
    problem = subject.problem.capability(IndexOne)
    given = None if problem is None else problem.reduced_dissipation
    if problem is None or given is None or not given.C > 0.0:
        return "it gives no constants of condition (4.1) with C > 0"
    own = problem.dissipation
    return _find_overstated(problem.without_y(), given) or (_find_overstated(problem, own) if own else "")


def _find_overstated(problem: IndexOne, k: Dissipation) -> str:
    """Return which constant of condition (4.1) is wrong, or an empty string."""
    (x, v, y), slack = delay_arguments(problem), 1.0 + 64 * EPS
    change = 0.5 * y + 1.0
    alone = (x * problem.drift(0.0, x, 0.0 * v, 0.0 * y)).sum(axis=0)
    moved = _size(problem.drift(0.0, x, v, y) - problem.drift(0.0, 2.0 * v, x, change))
    lipschitz = k.al0 * _size(x - 2.0 * v) + k.al1 * _size(v - x) + k.al2 * _size(y - change)
    growth = k.be0 * _size(x) ** 2 + k.be1 * _size(v) ** 2 + k.be2 * _size(y) ** 2
    if np.any(alone > -k.abar * _size(x) ** 2 + 64 * EPS * _size(x) ** 2):
        return "the drift damps less than abar says"
    if np.any(moved > slack * lipschitz):
        return "the drift changes more than al0, al1 and al2 say"
    large = np.any(_size(problem.diffusion(0.0, x, v, y)) ** 2 > slack * growth)
    return "the diffusion is larger than be0, be1 and be2 say" if large else ""


def _slope(subject: ProblemSubject, y: Array) -> Array:
    return first(lambda z: subject.equation.diffusion(WHEN, z), subject.x, y)


def _size(z: Array) -> Array:
    return np.asarray(np.sqrt((z * z).sum(axis=tuple(range(z.ndim - 1)))))


def _nonnegative(subject: ProblemSubject) -> str:
    domain = subject.problem.domain
    if domain is None or not domain.nonnegative:
        return "its domain does not say so"
    found = domain.draw(subject.equation.dimension, STATES)
    return "" if (found >= 0.0).all() else f"the domain has the state {found[:, found.min(axis=0).argmin()].tolist()}"


EVIDENCE: dict[str, Callable[[ProblemSubject], str]] = {
    "unconstrained": _free,
    "constrained": _constrained,
    "scalar-noise": _scalar,
    "additive-noise": _additive,
    "diagonal-noise": _diagonal,
    "commutative-noise": _commutative,
    "vanishing-milstein-term": _no_milstein_term,
    "normal-milstein-term": _normal_milstein_term,
    "overdamped-gradient": _gradient,
    "algebraic": _index_1,
    "no-delay": _no_delay,
    "nonnegative": _nonnegative,
    "linear-growth": _linear_growth,
    "delayed-noise": _delayed_noise,
    "dissipative": _dissipative,
}
