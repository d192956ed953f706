"""Global weak order on a linear equation with a delay without sampling: first and second moments at the final time.

Those of the scheme come from its step with the history in the state. Those of the solution are the problem's truths:
the second moments of a solution and of its past do not obey an ordinary differential equation, because the past up to
one delay ago has been driven by the noise that drove the solution in between.
"""

from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import Delayed
from ...forms.truths import Moment
from ...numerics.statistics import EPS
from ..step.nodes import SEED
from .affine import AFFINE
from .delay_equation import is_autonomous, is_scalar
from .delay_map import no_lasting_run, probed_step, run_start
from .delay_moments import Start, run_moments
from .delay_step import LinearDelayStep
from .moments import ABOVE_FLOOR, ROUNDING, MomentErrors

# Accuracy that truths are asked to have, relative to the largest moment: further step sizes would not tell more.
KNOWN = 1e-10
FURTHER, FEWEST = 2, 3
POWERS = (1, 2)


def constrained(view: Delayed, steps: Sequence[int]) -> list[int]:
    """Return the numbers of steps that a delay is a multiple of.

    On other meshes the leading coefficient of an error depends on where the delay lies between two mesh points, and
    local orders follow that, too.
    """
    return [count for count in steps if view.mesh(view.horizon / count).delta == 0.0]


def no_delay_moments(scheme: Scheme, view: Delayed, steps: Sequence[int]) -> str:
    """Return why moments cannot be propagated for these numbers of steps, or an empty string."""
    if len(constrained(view, steps)) < FEWEST:
        return "the delay is no multiple of the steps"
    if not is_scalar(view):
        return "moments with a delay are propagated for scalar equations with scalar noise"
    if len(known_moments(view)) < len(POWERS):
        return "the problem's truths do not know E x and E x^2"
    if scheme.law.clip:
        return "its clipped increments have no simple variance"
    if not is_autonomous(view):
        return "its coefficients depend on time"
    h = view.delay / 4.0
    linear = probed_step(scheme, view, h).defect <= AFFINE
    return no_lasting_run(scheme, view, h) if linear else "the step is not linear in the state"


def delay_moment_errors(scheme: Scheme, view: Delayed, steps: Sequence[int]) -> MomentErrors:
    """Return the errors of first and second moments of x at the final time.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Of a pair that `no_delay_moments` has nothing against.
    steps : sequence of int
        Numbers N of steps to the final time, each twice the one before; two more follow. Those are taken that the
        delay is a multiple of.

    Returns
    -------
    MomentErrors
    """
    steps = constrained(view, [*steps, *(steps[-1] * 2**level for level in range(1, FURTHER + 1))])
    exact = known_moments(view)
    found = [_propagated(scheme, view, count) for count in steps]
    errors = np.array([each[:2] for each in found]) - exact
    scale = np.array([max(each[2], np.abs(exact).max()) for each in found])
    return MomentErrors(
        h=view.horizon / np.array(steps),
        first=errors[:, :1],
        second=errors[:, 1:, None],
        floor=scale * (KNOWN / ABOVE_FLOOR + ROUNDING * EPS * np.array(steps)),
        scale=scale,
        defect=np.array([each[3] for each in found]),
        usable=np.array([1.0 - each[4] for each in found]),
    )


def known_moments(view: Delayed) -> Array:
    """Return E x and E x^2 of a scalar x at the final time as far as truths know them, shape (0,), (1,) or (2,).

    Which observables they are is seen by their values.
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


def _propagated(scheme: Scheme, view: Delayed, count: int) -> tuple[float, ...]:
    """Return E x_N, E x_N^2, the largest moment on the way, the step's defect and whether it failed."""
    h = view.horizon / count
    probed, (y, lagged) = probed_step(scheme, view, h), run_start(scheme, view, h, count)
    start = Start(np.append(y, 1.0), lagged)
    found = run_moments(_homogeneous(probed.step, probed.offset), view.mesh(h), start, count)
    mean, second = found.mean[:, 0], found.second[:, 0, 0]
    largest = float(np.abs(found.second[:, :-1, :-1]).max())
    return float(mean[-1]), float(second[-1]), largest, probed.defect, float(probed.failed)


def _homogeneous(step: LinearDelayStep, offset: Array) -> LinearDelayStep:
    """Return the step of the state with a last component that stays 1."""
    k = step.rows
    maps = np.insert(step.maps, k, offset, axis=2)
    constant = np.zeros((len(maps), 1, maps.shape[2]))
    constant[0, 0, k] = 1.0
    both = np.concatenate([maps, constant], axis=1)
    return LinearDelayStep(both[0], both[1:])
