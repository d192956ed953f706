"""Mean-square stability of a scheme on an equation with a delay: exact verdicts, the history being in the state.

The set of stable step sizes need not be an interval: on meshes that the delay is no multiple of, stability at one
step size does not imply it at a smaller one. The scan takes several positions of the delay between mesh points.
"""

from collections.abc import Sequence
from math import ceil

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import Delayed
from ..linear.delay_equation import UNIT, at_rest, is_autonomous, is_scalar, linear_delay
from ..linear.delay_map import limits, no_lasting_step, probed_step
from .delay_radius import radius
from .spectral import SpectralRadius
from .stability import Row, StabilityRecord, radii, refined_scan
from .windows import crossings

# Step sizes of the scan: down to this part of the delay, or of the equation's own time where that is shorter; one for
# each factor 2 where histories are longer than the one, and none where they are longer than the other.
FINE, OWN, LONG, LONGEST = 1.0 / 64.0, 0.1, 512, 1 << 17
PER_DECADE, LONGER, MOST = 12, 16, 1e3
SMALLEST_M, POSITIONS = range(1, 25), (0.0, 0.23, 0.49, 0.77)
UNKNOWN = SpectralRadius(np.nan, np.inf)


def no_delay_stability(scheme: Scheme, view: Delayed) -> str:
    """Return why mean-square stability cannot be asked for, or an empty string."""
    if scheme.law.clip:
        return "its clipped increments have no simple variance"
    if not is_autonomous(view):
        return "its coefficients depend on time"
    if not limits(scheme, view, view.delay / 4.0):
        return "a step is linear neither at small states nor at large ones"
    return no_lasting_step(scheme, view, view.delay / 4.0)


def delay_stability(scheme: Scheme, view: Delayed, step_sizes: Sequence[float], scale: float) -> StabilityRecord:
    """Return the spectral radius on a wide grid and at some step sizes, and where it crosses 1.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Of a pair that `no_delay_stability` has nothing against.
    step_sizes : sequence of float
    scale : float
        Size of the states at which the step is taken for linear, see `limits`.

    Returns
    -------
    StabilityRecord
        Of an equation in more than one dimension, neither growth rate nor stability are known: NaN.
    """

    def found(h: float) -> Row:
        probed, mesh = probed_step(scheme, view, h, scale), view.mesh(h)
        rho, width = radius(probed.step, mesh) if mesh.m <= LONGEST else UNKNOWN
        return h, rho, width, probed.defect, float(probed.failed), np.inf

    with np.errstate(all="ignore"):
        abscissa, decays = _equation(view, scale)
        scan, run = refined_scan(found, _scan(view, scale)), radii([found(h) for h in step_sizes])
        boundaries = crossings(lambda h: found(h)[1], scan.h, scan.sign)
    return StabilityRecord(*scan, *run, boundaries, abscissa, decays, float(at_rest(view)))


def _equation(view: Delayed, scale: float) -> tuple[float, float]:
    if not is_scalar(view):
        return np.nan, np.nan
    equation = linear_delay(view, scale)
    return equation.growth_rate, {True: 1.0, False: 0.0, None: np.nan}[equation.stable]


def _scan(view: Delayed, scale: float) -> Array:
    rate = 0.0
    if is_scalar(view):
        A, B, c, d, _ = linear_delay(view, scale)
        rate = abs(A) + abs(B) + (abs(c) + abs(d)) ** 2
    delay = view.delay
    least = min(FINE * delay, OWN / rate if rate else np.inf)
    low = max(least, delay / LONG)
    count = round(PER_DECADE * np.log10(delay / low))
    shorter = np.geomspace(least, low, ceil(np.log2(low / least)) + 1)[:-1]
    between = np.array([delay / (m - part) for m in SMALLEST_M for part in POSITIONS if m - part >= 1.0])
    # Beyond the delay, bounded terms of the unknown take part in the solve: at large states that is no linear step.
    longer = np.geomspace(delay, MOST * delay, LONGER)[1:]
    parts = [shorter, np.geomspace(low, delay, count)[:-1], between, longer]
    return np.unique(np.concatenate(parts[: 3 if scale > UNIT else 4]))
