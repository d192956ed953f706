"""A step with a delay as a map of its state and all the lagged values it will need: an oracle, slow and plain."""

import numpy as np

from facade import LinearDelayStep, Mesh, Operator, arguments


def queue_operator(step: LinearDelayStep, mesh: Mesh) -> Operator:
    """Return the operator of second moments of (y_n, v_n, ..., v_{n+m-1}), all of which are known before the step.

    Parameters
    ----------
    step : LinearDelayStep
    mesh : Mesh

    Returns
    -------
    Operator
        Of dimension k + m d. It has the nonzero eigenvalues of the recursion's operator on (y_n, x_{n-1}, ...,
        x_{n-m}).
    """
    k, d, (m, delta) = step.rows, step.dimension, mesh
    n = k + m * d
    factors = np.zeros((len(step.noise) + 1, n, n))
    factors[:, :k] = step.maps @ arguments(k, d, mesh)
    if m > 0:
        factors[0, k : n - d, k + d :] = np.eye((m - 1) * d)
        factors[:, n - d :] = delta * factors[:, :d]
        factors[0, n - d :, :d] += (1.0 - delta) * np.eye(d)
    return Operator(factors.transpose(1, 2, 0), np.ones(len(factors)))
