"""Continuation in the noise for implicit Euler steps in GGL form, if Newton's method fails."""

import numpy as np

from ._equations import Equations, Unknowns
from ._line_search import replace_paths
from ._newton import Root, Stop, solve_equations


def continue_in_stages(equations: Equations, root: Root, stop: Stop, stages: int) -> Root:
    """Solve the failed paths by continuation, with the noise B dw k/s in stages k = 1, ..., s.

    If B dw is large, Newton's iteration may end at a minimum of |F|^2 that is not a root. Without noise the old state
    is near the root, and every stage starts near the next root.

    Parameters
    ----------
    equations : Equations
    root : Root
        Result of `solve_equations`.
    stop : Stop
    stages : int

    Returns
    -------
    Root
        With the iterations and halvings of all stages.
    """
    failed = np.flatnonzero(~root.found)
    some = equations.of(failed)
    nothing = np.zeros_like(root.x.lam[:, failed])
    x, found = Unknowns(np.zeros_like(some.r), some.v, nothing, nothing), root.found.copy()
    iterations, halvings = root.iterations.copy(), root.halvings.copy()
    for stage in range(1, stages + 1):
        part = solve_equations(some._replace(kick=stage / stages * some.kick), x, stop)
        x, found[failed] = part.x, part.found
        iterations[failed] += part.iterations
        halvings[failed] += part.halvings
    return Root(replace_paths(root.x, failed, x), found, iterations, halvings)
