"""The first violation of the contract of a step, or of the exactness that every scheme has on trivial equations."""

import numpy as np

from ..contracts.scheme import Scheme
from ..forms import Problem
from .contract import contract_violation
from .exactness import exactness_violation


def violation(scheme: Scheme, view: Problem) -> str:
    """Return the first violation in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form; the contract is tried on it, exactness on trivial problems of the same form.

    Returns
    -------
    str

    Raises
    ------
    Exception
        What a step raises at states of the view: nothing can be said of such a scheme.
    """
    with np.errstate(all="ignore"):
        return contract_violation(scheme, view) or exactness_violation(scheme)
