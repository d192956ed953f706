"""The first violation of a step's contract, of exactness on trivial equations, or of the equation at some state.

A short step follows the equation at every state that solutions reach and at all times, not at those alone where
orders are probed: see `step_law`. A step that clips its state, or loses a term on one side of a threshold, follows it
everywhere else, and a few states in the middle of the law do not show it.
"""

import numpy as np

from ..contracts.measure import measures_following
from ..contracts.scheme import Scheme
from ..forms import Problem
from ..probe.local.run_memory import run_memory
from ..probe.local.step_law import law_departure
from .contract import contract_violation
from .exactness import exactness_violation


def departure(scheme: Scheme, view: Problem) -> str:
    """Return where short steps, or the memory of a run, leave the equation, in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.

    Returns
    -------
    str
        Empty, too, where a step cannot be probed, see `step_law` and `run_memory`.
    """
    if text := law_departure(scheme, view):
        return text
    memory = run_memory(scheme, view)
    return "" if memory is None else memory.departure


def violation(scheme: Scheme, view: Problem) -> str:
    """Return the first violation in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form; the contract is tried on it, exactness on trivial problems of the same form, and whether
        a step follows the equation at all states where a scheme claims to.

    Returns
    -------
    str

    Raises
    ------
    Exception
        What a step raises at states of the view: nothing can be said of such a scheme.
    """
    with np.errstate(all="ignore"):
        if text := contract_violation(scheme, view) or exactness_violation(scheme, view.noise_dim):
            return text
        return departure(scheme, view) if follows(scheme, view) else ""


def follows(scheme: Scheme, view: Problem) -> bool:
    """Tell whether a scheme claims to follow the equation on this problem in all its quantities.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    """
    held = [claim for claim in scheme.promises if claim.when <= view.traits and not claim.quantities]
    return not measures_following("paths", "law").isdisjoint(claim.measure for claim in held)
