"""Global weak order without sampling: first and second moments of a linear problem at the final time.

With z = (x, 1), E z z^T after N steps is the N-th power of the step's second-moment operator applied to the initial
value. For the solution it is exp(T G), where G is the generator of the second-moment equation. The last column
contains the first moments.

Observables that are quadratic in the state, q(x) = c + l . x + x^T S x, have E q = c + l . E x + <S, E x x^T>.

With a delay the moments of the scheme follow from its step with the history in the state. Those of the solution are
moments declared by the problem: second moments of a solution and its past do not satisfy an ordinary differential
equation, because the past up to one delay ago has been driven by the same noise as the solution.
"""

from collections.abc import Callable, Sequence
from math import ceil, log2
from typing import NamedTuple

import numpy as np
import scipy

from ...arrays import Array
from ...contracts.scheme import Scheme, flatten
from ...forms import Delayed, Problem
from ...forms.truths import Moment
from ...numerics.statistics import EPS
from ..operator.functional_orders import FunctionalOrder, order_of
from ..stability.spectral import DENSE
from ..stability.stability import why_not_in_runs, why_not_stability
from ..step.nodes import SEED
from ..step.one_step import OneStep
from ..step.times import changing
from .affine import AFFINE, trial_states
from .delay_equation import is_autonomous, is_scalar
from .delay_step import LinearDelayStep, Start, probe_step, run_moments, run_start, why_not_lasting_run
from .equation import linear_equation
from .linear_map import MemoryStep
from .observable_part import restrict_to_observed
from .second_moments import smat, svec
from .step_moments import step_moments

# Rounding error of a matrix power or exponential, in units of EPS times the number of steps times the largest moment.
# Rounding: EPS for each operation of a product.
ROUNDING = 16.0
# Size: further step sizes.
FURTHER = 6
# Shortest step size in units of time; on long horizons it is needed as well, because the errors of a scheme with its
# own time scale show no order at longer steps.
# Size: of the shortest step.
SHORT = 2.0**-8
# Errors above this multiple of the floor are known to two digits: a local order then has an error below 0.03.
# Rounding: log2 of 1.01/0.99 is 0.029.
ABOVE_FLOOR = 100.0
# Assumed accuracy of declared moments relative to the largest moment; more step sizes would give no more information.
# Measured by tests/probe/test_delay_moment_errors.py: those of delay-test are right to a hundredth of it.
KNOWN = 1e-10
# Size: further step sizes, and step sizes with an order.
DELAY_FURTHER, FEWEST = 2, 3
# Scales of the trial states at which a quadratic function is checked.
# Size: of the trial states.
SCALES = (1.0, 8.0)
# Size: moments that are compared.
POWERS = (1, 2)


class MomentErrors(NamedTuple):
    """Errors of the moments at time T for H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
    first : ndarray, shape (H, d)
        E x of the scheme minus that of the solution.
    second : ndarray, shape (H, d, d)
        The same for E x x^T.
    exact : ndarray, shape (d + 1, d + 1)
        E z z^T of the solution at T.
    size : ndarray, shape (d + 1,)
        Larger root mean square of each component of z at 0 and T; for components that are 0, that of the largest one.
    floor : ndarray, shape (H,)
        Bound of the error of the errors: rounding and quadrature.
    defect : ndarray, shape (H,)
        Relative deviation from linearity in the state: above rounding if the step is not linear.
    usable : ndarray, shape (H,)
        1 if every step has a root and a finite second moment, else 0.
    """

    h: Array
    first: Array
    second: Array
    exact: Array
    size: Array
    floor: Array
    defect: Array
    usable: Array

    @property
    def errors(self) -> Array:
        """Errors of d first moments followed by d (d + 1)/2 second moments, shape (H, M)."""
        i, j = np.triu_indices(self.first.shape[1])
        return np.concatenate([self.first, self.second[:, i, j]], axis=1)

    @property
    def linear(self) -> bool:
        """Whether the step is linear at all step sizes; steps that overflow or have no root count as linear."""
        return bool(self.defect.max() <= AFFINE)

    @property
    def known(self) -> bool:
        """Whether errors are defined at all step sizes: the steps are linear, and have a root and a second moment."""
        return self.linear and bool(self.usable.all())


def why_not_moments(scheme: Scheme, view: Problem) -> str:
    """Return why moments cannot be propagated, or an empty string."""
    if reason := why_not_stability(scheme, view) or why_not_in_runs(scheme, view):
        return reason
    k, step = len(flatten(scheme.start(view, 1, view.horizon))), OneStep(scheme, view)
    if (k + 1) * (k + 2) // 2 > DENSE:
        return f"{k} components are too many for a dense matrix"
    return "" if step.why_not_probed() else changing(step)


def moment_errors(scheme: Scheme, view: Problem, steps: Sequence[int]) -> MomentErrors:
    """Return the errors of first and second moments at the final time.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_moments` is empty for the pair.
    steps : sequence of int
        Numbers N of steps to the final time, each twice the previous one. Six more are appended, or as many as lead
        to 2^-8 of the unit of time: exact moments cost no more for many steps, and local orders converge.

    Returns
    -------
    MomentErrors
    """
    further = max(FURTHER, ceil(log2(view.horizon / (steps[-1] * SHORT * view.time_unit))))
    return moment_errors_at(scheme, view, [*steps, *(steps[-1] * 2**level for level in range(1, further + 1))])


def moment_errors_at(scheme: Scheme, view: Problem, steps: Sequence[int]) -> MomentErrors:
    """Return the errors of first and second moments at the final time for some numbers of steps.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        As of `moment_errors`.
    steps : sequence of int
        Numbers N of steps to the final time.
    """
    one_step, h = OneStep(scheme, view), [view.horizon / count for count in steps]
    start, exact = _exact(one_step)
    with np.errstate(all="ignore"):
        found = [_propagate(one_step, size, count) for size, count in zip(h, steps, strict=True)]
        P, largest, rule_error, *noticed = map(np.array, zip(*found, strict=True))
        differences, scale = P - exact, np.maximum(largest, np.abs(exact).max())
        floor = scale * (np.array(steps) * (ROUNDING * EPS + rule_error))
    errors = differences[:, :-1, -1], differences[:, :-1, :-1]
    return MomentErrors(np.array(h), *errors, exact, _sizes(exact, start), floor, *noticed)


def _sizes(*moments: Array) -> Array:
    """Return the larger root mean square of each component; for components that are 0, that of the largest one."""
    largest = np.max([np.diag(P) for P in moments], axis=0)
    return np.asarray(np.sqrt(np.where(largest > 0.0, largest, largest.max())))


def moment_orders(record: MomentErrors) -> tuple[FunctionalOrder, ...]:
    """Return the order shown by each moment: d first moments followed by d (d + 1)/2 second ones.

    Empty if the step is not linear, or has no root or no second moment.
    """
    if not record.known:
        return ()
    d = record.first.shape[1]
    i, j = np.triu_indices(d)
    rows, columns = np.append(np.arange(d), i), np.append(np.full(d, d), j)
    means = zip(record.errors.T, record.size[rows] * record.size[columns], record.exact[rows, columns], strict=True)
    return tuple(order_of(record.h, each, record.floor, float(size), float(exact)) for each, size, exact in means)


def _exact(one_step: OneStep) -> tuple[Array, Array]:
    """Return E z z^T of the solution at 0 and at T."""
    ito = one_step.equation
    equation, z = linear_equation(ito), np.append(ito.initial(1)[:, 0], 1.0)
    start = np.outer(z, z)
    # Balanced, because constant terms of large states appear together with rates of order one.
    generator = ito.horizon * equation.generator()
    balanced, (scale, _) = scipy.linalg.matrix_balance(generator, permute=False, separate=True)
    grown = scale * (scipy.linalg.expm(balanced) @ (svec(start) / scale))
    return start, smat(grown, len(z))


def _propagate(one_step: OneStep, h: float, count: int) -> tuple[Array, float, float, float, float]:
    """Return E z z^T of the comparable components at T, the largest moment, and the error of the cubature rule.

    The last two values are the step's defect and whether it is usable, as in `MomentErrors`.
    """
    found, step = step_moments(one_step, h), MemoryStep(one_step, h)
    if found.defect > AFFINE:
        d = one_step.equation.dimension + 1
        return np.full((d, d), np.nan), np.nan, np.nan, found.defect, 0.0
    z = np.append(flatten(step.start)[:, 0], 1.0)
    operator, Q = restrict_to_observed(step, found.operator)
    z, L = Q @ z, step.reading() @ Q.T
    P = smat(np.linalg.matrix_power(operator.dense(), count) @ svec(np.outer(z, z)), len(z))
    usable = float(not found.failed and np.isinf(found.pole))
    scale = float(max(np.abs(P).max(), np.outer(z, z).max()))
    return L @ P @ L.T, scale, found.rule_error, found.defect, usable


def aligned_steps(view: Delayed, steps: Sequence[int]) -> list[int]:
    """Return the numbers of steps for which the delay is a multiple of the step size.

    On other meshes the leading error coefficient depends on the position of the delay between two mesh points, which
    affects local orders.
    """
    return [count for count in steps if view.mesh(view.horizon / count).delta == 0.0]


def why_not_delay_moments(scheme: Scheme, view: Delayed, steps: Sequence[int]) -> str:
    """Return why moments cannot be propagated for these numbers of steps, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem in the scheme's form.
    steps : sequence of int
        Numbers of steps to the horizon.
    """
    if len(aligned_steps(view, steps)) < FEWEST:
        return "the delay is no multiple of the steps"
    if not is_scalar(view):
        return "moments with a delay are computed only for scalar equations with scalar noise"
    if len(known_moments(view)) < len(POWERS):
        return "the problem's truths do not provide E x and E x^2"
    if scheme.law.clip:
        return "the variance of its clipped increments is not available"
    if not is_autonomous(view):
        return "its coefficients depend on time"
    h = view.delay / 4.0
    linear = probe_step(scheme, view, h).defect <= AFFINE
    return why_not_lasting_run(scheme, view, h) if linear else "the step is not linear in the state"


def delay_moment_errors(scheme: Scheme, view: Delayed, steps: Sequence[int]) -> MomentErrors:
    """Return the errors of first and second moments of x at the final time, for a scalar equation with delay.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem in the scheme's form; `why_not_delay_moments` is empty for the pair.
    steps : sequence of int
        Numbers N of steps to the final time, each twice the previous one; two more are appended. Those are used for
        which the delay is a multiple of the step size.

    Returns
    -------
    MomentErrors
    """
    steps = aligned_steps(view, [*steps, *(steps[-1] * 2**level for level in range(1, DELAY_FURTHER + 1))])
    mean, square = known_moments(view)
    first, second, largest, defect, usable = np.array([_run(scheme, view, count) for count in steps]).T
    exact, h = np.array([[square, mean], [mean, 1.0]]), view.horizon / np.array(steps)
    scale = np.maximum(largest, np.abs(exact[:, 0]).max())
    floor = scale * (KNOWN / ABOVE_FLOOR + ROUNDING * EPS * np.array(steps))
    errors, start = ((first - mean)[:, None], (second - square)[:, None, None]), np.append(view.past(0.0), 1.0)
    return MomentErrors(h, *errors, exact, _sizes(exact, np.outer(start, start)), floor, defect, usable)


def known_moments(view: Delayed) -> Array:
    """Return the declared moments E x and E x^2 of a scalar x at the final time, shape (0,), (1,) or (2,).

    The observables x and x^2 are identified by their values, not by their names.
    """
    x, y = np.random.Generator(np.random.Philox(key=SEED + 8)).standard_normal((2, 1, 4))
    parts = {"x": x, "y": np.repeat(y, view.constraints, axis=0)}
    values = {name: observable(view.horizon, parts) for name, observable in view.observables.items()}
    moments = [truth for truth in view.truths if isinstance(truth, Moment)]
    found = (
        next((t.value(view.horizon) for t in moments if np.array_equal(values[t.observable], x[0] ** power)), None)
        for power in POWERS
    )
    return np.array([value for value in found if value is not None])


def _run(scheme: Scheme, view: Delayed, count: int) -> tuple[float, ...]:
    """Return E x_N, E x_N^2, the largest second moment of the run, the step's defect and whether it is usable."""
    h = view.horizon / count
    probed, (y, lagged) = probe_step(scheme, view, h), run_start(scheme, view, h, count)
    start = Start(np.append(y, 1.0), lagged)
    found = run_moments(_homogeneous(probed.step, probed.offset), view.mesh(h), start, count)
    mean, second = found.mean[:, 0], found.second[:, 0, 0]
    largest = float(np.abs(found.second[:, :-1, :-1]).max())
    return float(mean[-1]), float(second[-1]), largest, probed.defect, 1.0 - probed.failed


def _homogeneous(step: LinearDelayStep, offset: Array) -> LinearDelayStep:
    """Return the step of the state extended by a last component that is always 1."""
    k = step.rows
    maps = np.insert(step.maps, k, offset, axis=2)
    constant = np.zeros((len(maps), 1, maps.shape[2]))
    constant[0, 0, k] = 1.0
    both = np.concatenate([maps, constant], axis=1)
    return LinearDelayStep(both[0], both[1:])


# Observables that are quadratic in the state: their expectations follow from the moments.


class QuadraticForm(NamedTuple):
    """Coefficients of q(x) = c + l . x + x^T S x.

    Attributes
    ----------
    constant : float
    linear : ndarray, shape (d,)
    square : ndarray, shape (d, d)
        Symmetric matrix S.
    """

    constant: float
    linear: Array
    square: Array

    def of_moments(self, first: Array, second: Array) -> Array:
        """Return l . m + <S, P> for moments, or errors of moments, m of shape (..., d) and P of shape (..., d, d)."""
        return np.asarray(first @ self.linear + np.einsum("...ij,ij", second, self.square))

    def largest(self, size: Array) -> float:
        """Return a bound of the terms of q - c, given root mean squares of the components, shape (d,)."""
        return float(np.abs(self.linear) @ size + size @ np.abs(self.square) @ size)

    @property
    def size(self) -> float:
        """Sum of the moduli of the coefficients, the largest factor of an error in all moments."""
        return float(np.abs(self.linear).sum() + np.abs(self.square).sum())


def quadratic_form(view: Problem, observable: str) -> QuadraticForm | None:
    """Return an observable at the final time as a quadratic function of the state; None if it is not quadratic.

    Parameters
    ----------
    view : Problem
        Its Ito equation defines the state.
    observable : str
    """
    ito = view.ito()
    if ito is None or observable not in view.observables:
        return None

    def q(x: Array) -> Array:
        with np.errstate(all="ignore"):
            value = view.observables[observable](view.horizon, ito.parts(x))
        return np.broadcast_to(np.asarray(value, dtype=float), x.shape[1:])

    try:
        return fit_quadratic(q, ito.dimension)
    except (KeyError, IndexError, ValueError):
        # The observable depends on components that the equation lacks, such as multipliers.
        return None


class ObservableErrors(NamedTuple):
    """Errors of the mean of one observable at H step sizes.

    Attributes
    ----------
    h, errors, floors : ndarray, shape (H,)
        Step sizes, errors with their signs, and how far these can be off.
    size, exact : float
        Of the terms of the observable together, and its mean under the solution.
    """

    h: Array
    errors: Array
    floors: Array
    size: float
    exact: float


def observable_errors(record: MomentErrors, form: QuadraticForm) -> ObservableErrors | None:
    """Return the errors of the mean of one quadratic observable, or None where moments are not known.

    Parameters
    ----------
    record : MomentErrors
        Errors of the moments of the components in the form.
    form : QuadraticForm
    """
    if not record.known or record.first.shape[1] != len(form.linear) or not form.size:
        return None
    errors, size = form.of_moments(record.first, record.second), record.size[:-1]
    exact = form.of_moments(record.exact[:-1, -1], record.exact[:-1, :-1])
    return ObservableErrors(record.h, errors, form.size * record.floor, form.largest(size), float(exact))


def observable_order(record: MomentErrors, form: QuadraticForm) -> FunctionalOrder | None:
    """Return the order of a quadratic observable from the errors of moments; None if they do not determine it.

    Parameters
    ----------
    record : MomentErrors
        Of the components that the form is about.
    form : QuadraticForm
    """
    found = observable_errors(record, form)
    return None if found is None else order_of(*found)


def fit_quadratic(q: Callable[[Array], Array], d: int) -> QuadraticForm | None:
    """Return the coefficients of a function of states, shape (d, P) -> (P,); None if it is not quadratic."""
    unit = np.eye(d)
    c, up, down = float(q(np.zeros((d, 1)))[0]), q(unit), q(-unit)
    both = q((unit[:, :, None] + unit[:, None, :]).reshape(d, -1)).reshape(d, d)
    linear, diagonal = 0.5 * (up - down), 0.5 * (up + down) - c
    square = np.where(unit > 0.0, np.diag(diagonal), 0.5 * (both - up[:, None] - up + c))
    x = np.concatenate([size * trial_states(d) for size in SCALES], axis=1)
    terms = linear[:, None] * x, x * (square @ x)
    size = abs(c) + sum(np.abs(term).sum(axis=0) for term in terms) + np.abs(x).max(axis=0)
    found = QuadraticForm(c, linear, square)
    return found if (np.abs(q(x) - c - sum(term.sum(axis=0) for term in terms)) <= AFFINE * size).all() else None
