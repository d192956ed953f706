"""First violation of a step's contract, of exactness on trivial equations, or of the equation at some state.

A short step must follow the equation at all times and at every state that solutions reach, not only where orders are
probed: see `step_law`. A step that clips its state, or omits a term on one side of a threshold, follows the equation
everywhere else, and a few states in the bulk of the law do not show the error. The same holds for a step that omits
rare noise: see `far_noise`.
"""

from collections.abc import Mapping

import numpy as np

from ..contracts.measure import ALONG_PATHS, IN_LAW
from ..contracts.scheme import Scheme
from ..contracts.tally import Tally, packed
from ..forms import Problem
from ..probe.local.far_noise import noise_departure
from ..probe.local.run_memory import run_memory
from ..probe.local.solved_instead import solved_instead
from ..probe.local.step_law import law_departure, law_resolution, state_words
from ..probe.step.nodes import SEED
from ..probe.step.one_step import OneStep
from ..probe.step.states import reached_states
from .contract import contract_violation
from .exactness import exactness_violation
from .step_counts import always_depends_on_count

# Name of the evidence from comparing single steps with the equation.
LAW = "step law"
# Steps per horizon, coarse and fine, and paths from each state: the largest normal increments of all paths are near
# 4.
STEPS, PATHS = (8, 64), 64
STATES = 64


def departure(scheme: Scheme, view: Problem, *, paths: bool = False, run: bool = True) -> str:
    """Return where short steps, or the memory of a run, deviate from the equation, in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    paths : bool
        Whether the scheme has claims on paths; see `noise_departure`.
    run : bool
        Whether to make the run that shows how the memory of a run deviates.

    Returns
    -------
    str
        Also empty if a step cannot be probed, see `step_law` and `run_memory`.
    """
    if text := law_departure(scheme, view) or noise_departure(scheme, view, paths=paths):
        return text
    memory = run_memory(scheme, view) if run else None
    return "" if memory is None else memory.departure


def violation(
    scheme: Scheme, view: Problem, *, followed: Mapping[str, str], run: bool = True, motions: float | None = None
) -> str:
    """Return the first violation in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form. The contract is checked on it, exactness on trivial problems of the same form.
        Whether a step follows the equation at all states is checked if the scheme claims it.
    followed : mapping of str to str
        `Measure.follows` by name of the measure.
    run : bool
        As for `departure`.
    motions : float, optional
        As for `exactness_violation`; those of the problem if omitted, infinity if claims are about a class.

    Returns
    -------
    str

    Raises
    ------
    Exception
        Any error that a step raises at states of the view; the checks cannot be made then.
    """
    with np.errstate(all="ignore"):
        if text := contract_violation(scheme, view) or domain_violation(scheme, view):
            return text
        text = exactness_violation(scheme, view.noise_dim if motions is None else motions, followed=followed)
        paths = ALONG_PATHS in _followed(scheme, view, followed)
        if not text and follows(scheme, view, followed):
            text = departure(scheme, view, paths=paths, run=run) or always_depends_on_count(scheme, view)
        named = solved_instead(scheme, view, paths=paths) if text else ""
        return f"{text}: {named}" if named else text


def follows(scheme: Scheme, view: Problem, followed: Mapping[str, str]) -> bool:
    """Return whether a scheme claims, in all quantities of this problem, to follow the equation.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    followed : mapping of str to str
        `Measure.follows` by name of the measure.
    """
    return bool(_followed(scheme, view, followed) & {ALONG_PATHS, IN_LAW})


def _followed(scheme: Scheme, view: Problem, followed: Mapping[str, str]) -> set[str]:
    """Return what the claims of a scheme that cover all quantities of this problem imply that steps follow."""
    held = [claim for claim in scheme.promises if claim.when <= view.traits and not claim.quantities]
    return {followed.get(claim.measure, "") for claim in held}


def compared_steps(scheme: Scheme, view: Problem, followed: Mapping[str, str]) -> Tally:
    """Return the number of times at which steps were compared with the equation, and the largest undetected error.

    Empty if the scheme does not claim to follow the equation in all quantities: steps are not compared then.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    followed : mapping of str to str
        As for `follows`.
    """
    found = law_resolution(scheme, view) if follows(scheme, view, followed) else None
    return Tally() if found is None else packed(LAW, found)


def domain_violation(scheme: Scheme, view: Problem) -> str:
    """Return the state from which a step leaves the scheme's domain, in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; its domain lies in that of the scheme.
    """
    step = OneStep(scheme, view)
    if scheme.domain is None or step.why_not_comparable() or step.untold(scheme.start(view, 1, view.horizon)):
        return ""
    x = reached_states(view, step.equation).points
    x = np.tile(x[:, :: max(1, x.shape[1] // STATES)], PATHS)
    rng = np.random.Generator(np.random.Philox(key=SEED + 20))
    for h in (view.horizon / count for count in STEPS):
        noise = scheme.law.increment(view.drawn(rng, h, x.shape[1]), h)
        left = ~scheme.domain.contains(step(x, step.time, h, noise))
        if left.any():
            where = f"on {left.sum()} of {left.size} paths, from {state_words(x[:, left.argmax()])} with h = {h:.2g}"
            return f"a step leaves the states with {scheme.domain} that the scheme is for, {where}"
    return ""
