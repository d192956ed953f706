"""The first violation of a step's contract, of exactness on trivial equations, or of the equation at some state."""

import numpy as np

from ..contracts.scheme import Scheme
from ..forms import Problem
from .contract import contract_violation
from .exactness import PATHWISE, exactness_violation
from .reached_states import departure

# Measures that compare a scheme with the solution at a time, in law or path by path.
TRANSIENT = PATHWISE | {"weak"}


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
        if text := contract_violation(scheme, view) or exactness_violation(scheme):
            return text
        return departure(scheme, view) if _follows(scheme, view) else ""


def _follows(scheme: Scheme, view: Problem) -> bool:
    """Tell whether a scheme claims to follow the equation on this problem in all its quantities."""
    held = [claim for claim in scheme.promises if claim.when <= view.traits and not claim.quantities]
    return any(claim.measure in TRANSIENT for claim in held)
