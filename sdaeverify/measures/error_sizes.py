"""Sizes of errors as `Measure.error_sizes` gives them: along paths, of one step, and of expectations."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..arrays import Array, Mask
from ..contracts.error_sizes import ErrorSizes, deterministic, estimate_sizes, without_error
from ..contracts.measure import Evidence
from ..numerics.statistics import EPS
from ..probe.linear.affine import AFFINE
from ..probe.linear.moments import ABOVE_FLOOR as MOMENTS_ABOVE_FLOOR
from ..probe.linear.moments import MomentErrors
from ..probe.local.romberg import weights
from ..probe.local.strong_defects import ROUNDING, SELF, LocalStrong
from ..probe.local.strong_order import strong_order
from ..probe.local.weak_order import FLOORS, LocalWeak, weak_order
from ..probe.operator.functional_orders import ABOVE_FLOOR, error_floors, functional_orders
from ..probe.operator.transition_errors import TransitionErrors
from ..verdicts.path_tests import RESOLVED
from ..verdicts.sound_levels import sound_levels_of
from .means import Means
from .path_errors.order import EXACT, is_exact, usable_levels
from .path_errors.quantity import Quantity

Sizes = Mapping[str, ErrorSizes]
# A defect of so many times its rounding is known to a per cent.
CLEAR = 100.0
UNSEEN = "no error beyond what is known of it"


def of_paths(evidence: Evidence, quantity: Quantity) -> ErrorSizes:
    """Return E e_l on the levels that can be fitted."""
    if is_exact(evidence, quantity):
        return without_error(EXACT)
    levels, left_out = usable_levels(evidence, quantity)
    return estimate_sizes(quantity.h[levels], quantity.error[:, levels, 1], quantity.counts, str(left_out))


def of_means(evidence: Evidence, means: Means) -> ErrorSizes:
    """Return the mean differences of an observable on the levels where they are told from 0."""
    sound, remarks = sound_levels_of(evidence)
    seen = [level for level in sound if level < means.errors and means.least_signal(np.array([level])) >= RESOLVED]
    if len(seen) < min(len(sound), means.errors):
        remarks = remarks.then(f"mean differences of less than {RESOLVED:.0f} standard errors")
    differences = means.sums[:, :-1] - means.sums[:, -1:] if means.coupled else -np.diff(means.sums, axis=1)
    return estimate_sizes(means.h[seen], differences[:, seen], means.counts, str(remarks))


def of_step(record: LocalStrong, names: Sequence[str]) -> Iterator[tuple[str, ErrorSizes]]:
    """Yield the defects of one step against two half steps, at worst over the states, of each component."""
    rounding = CLEAR * ROUNDING * record.scale.max(axis=0)
    means = {"mean": record.mean} if record.means else {}
    for index, name in enumerate(names):
        floor = _above_plateau(record.h, rounding, strong_order(record, index).plateau_h)
        for kind, defects in {"root mean square": record.rms, **means}.items():
            yield f"one step: {kind} of {name}", _sizes_above(record.h, defects[SELF, index].max(axis=0), floor)


def of_step_expectations(record: LocalWeak) -> ErrorSizes:
    """Return the largest defect of an expectation in one step, relative to the size of its function."""
    order = weak_order(record)
    if np.isinf(order.orders).all():
        return without_error(UNSEEN)
    relative = np.abs(record.defect) / record.scale
    rounding = np.full(len(record.h), FLOORS * EPS * np.abs(weights(int(record.trees))).sum())
    return _sizes_above(record.h, relative.max(axis=(0, 1)), _above_plateau(record.h, rounding, order.plateau_h))


def of_moments(record: MomentErrors) -> Iterator[tuple[str, ErrorSizes]]:
    """Yield the norms of the errors of first and second moments at T, if the step is linear."""
    if record.defect.max() > AFFINE:
        return
    floor = np.where(record.usable > 0.0, MOMENTS_ABOVE_FLOOR * record.floor, np.inf)
    yield "first moments at T", _sizes_above(record.h, np.linalg.norm(record.first, axis=1), floor)
    yield "second moments at T", _sizes_above(record.h, np.linalg.norm(record.second, axis=(1, 2)), floor)


def of_operator(record: TransitionErrors, names: Sequence[str], kind: str) -> Iterator[tuple[str, ErrorSizes]]:
    """Yield the errors of expectations by the transition operator, of the observables that tell something.

    Parameters
    ----------
    record : TransitionErrors
        Errors at each step size, of each observable.
    names : sequence of str
        Observables, in the record's order.
    kind : str
        What the names of the errors begin with.
    """
    floors, orders = ABOVE_FLOOR * error_floors(record), functional_orders(record)
    for index, name in enumerate(names):
        if orders[index].informative:
            yield f"{kind}: {name}", _sizes_above(record.h, np.abs(record.errors[:, index]), floors[:, index])


def _above_plateau(h: Array, floor: Array, plateau_h: float) -> Array:
    """Return floors below which a defect is rounding, infinite where a solver's tolerance hides it."""
    return np.where(h > plateau_h, floor, np.inf)


def _sizes_above(h: Array, sizes: Array, floor: Array) -> ErrorSizes:
    seen: Mask = np.isfinite(sizes) & (sizes > floor)
    if not seen.any() and np.isfinite(sizes).all() and np.isfinite(floor).all():
        return without_error(UNSEEN)
    return deterministic(h, sizes, seen, "" if seen.all() else UNSEEN)
