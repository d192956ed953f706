"""Compare steps of runs of 10 or 50 steps with those of runs of 2^k steps.

All levels of a run have N_0 2^k steps, 8 2^k by default, and local errors are probed at powers of two. A step may
nevertheless depend on the number of steps T/h. Its distance from Euler's step, with the same standard normals,
is for all step sizes the sum of a few powers of h,

    Phi_h(x; xi) - [x + f h + B dW] = a h + b h^(3/2) + c h^2 + d h^(5/2) + ...,

so that its values at four step sizes determine the value at a step size between them.
"""

import numpy as np

from ..arrays import Array
from ..contracts.scheme import Scheme
from ..forms import Problem
from ..numerics.statistics import EPS
from ..probe.local.delay_links import remove_delay
from ..probe.step.one_step import OneStep
from ..probe.step.states import cloud
from .trial import Trial

# Numbers of steps, each with the numbers of steps of the runs it is compared with.
COUNTS = {10: (4, 8, 16, 32), 50: (16, 32, 64, 128)}
SHORT = {1000: (256, 512, 1024, 2048)}
POWERS = np.array([1.0, 1.5, 2.0, 2.5])
# Accepted difference relative to the largest distance from Euler's step; shipped schemes reach at most 0.045.
UNLIKE = 0.1
# Rounding of differences of steps as large as the state, times the weights of the four step sizes.
ROUNDINGS = 1e4


def why_not_counted(scheme: Scheme, view: Problem) -> str:
    """Return why steps of different sizes cannot be compared, or an empty string."""
    if scheme.discontinuous_in_noise:
        return "a step is discontinuous in its noise, so that its size is not a power series"
    step = OneStep(*remove_delay(scheme, view))
    return step.why_not_comparable() or step.why_not_entered(run=False)


def depends_on_count(scheme: Scheme, view: Problem) -> str:
    """Return the number of steps at which a step differs from those of other sizes, in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_counted` must be empty for the pair.
    """
    step = OneStep(*remove_delay(scheme, view))
    for count, others in COUNTS.items():
        off = unlike(step, count, others)
        if off > UNLIKE:
            text = f"a step of T/{count} differs from steps of T/{others[1]} and T/{others[2]} by {off:.2g} of the"
            return f"{text} distance from Euler's step: its error depends on the number of steps"
    return ""


def always_depends_on_count(scheme: Scheme, view: Problem) -> str:
    """Return that steps of all numbers differ from those of runs of 2^k steps, in one line, or an empty string.

    A right scheme may differ on a stiff problem at long steps, where its error is no sum of few powers, but not at
    steps as short as those of the last number.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    """
    if why_not_counted(scheme, view):
        return ""
    step, counts = OneStep(*remove_delay(scheme, view)), COUNTS | SHORT
    with np.errstate(all="ignore"):
        always = all(unlike(step, count, others) > UNLIKE for count, others in counts.items())
        return depends_on_count(scheme, view) if always else ""


def unlike(step: OneStep, count: int, others: tuple[int, ...]) -> float:
    """Return the distance of a step from its interpolation in h, relative to their distances from Euler's step.

    The median over paths is returned: on a few paths the largest step of the interpolation may be too long for powers
    of h, whereas a dependence on the number of steps shows on all paths.

    Parameters
    ----------
    step : OneStep
    count : int
        Number of steps of the run whose step is compared.
    others : tuple of int
        Numbers of steps of the runs whose steps are interpolated.
    """
    h = np.array([step.view.horizon / steps for steps in (count, *others)])
    beside, rounding = zip(*(_beside_euler(step, float(size)) for size in h), strict=True)
    powers = h[:, None] ** POWERS
    expected = np.tensordot(np.linalg.solve(powers[1:].T, powers[0]), np.stack(beside[1:]), 1)
    off, *sizes = (np.sqrt((part**2).sum(axis=0)) for part in (beside[0] - expected, *beside[1:]))
    # On paths where a step fails the quotient is NaN; this may be the case on all paths.
    found = off / (np.max(sizes, axis=0) + ROUNDINGS * max(rounding))
    known = found[np.isfinite(found)]
    return float(np.median(known)) if known.size else 0.0


def _beside_euler(step: OneStep, h: float) -> tuple[Array, float]:
    """Return a step minus Euler's step, shape (d, P), and a rounding error of the state."""
    x = cloud(step.view, step.equation)
    noise = Trial(step.scheme, step.view, h, x).noise
    # The second step of a run. Steps of several kinds in turn are of the same kind where the same number of steps was
    # made before them, and a first step may be special.
    return step(x, h, h, noise) - step.euler(x, h, h, noise), EPS * float(np.abs(x).max())
