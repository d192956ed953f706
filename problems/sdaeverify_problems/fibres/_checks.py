"""Checks of the user's data of a fibre, with messages of one line."""

import numpy as np
from numpy.typing import ArrayLike

from sdaeverify import Array, ProblemError

from ._chain import Chain
from ._fibre import Fibre

PROBES = 3
# Coordinates may be accumulated along the chain, or read from a file with ten digits.
LENGTH_TOLERANCE = 1e-9


def rows(chain: Chain, name: str, values: ArrayLike) -> Array:
    """Return initial data of shape (N, d) as an array of shape (n,).

    Raises
    ------
    ProblemError
        If the data have another shape.
    """
    array, expected = np.asarray(values, dtype=float), (chain.N, chain.d)
    if array.shape != expected:
        raise ProblemError(f"{name} has shape {array.shape}, expected {expected}: points, components")
    return array.ravel()


def check_lengths(chain: Chain, r: Array) -> None:
    """Check that the edges of the initial positions, shape (n,), have length ds.

    Raises
    ------
    ProblemError
        If an edge does not have the length ds.
    """
    lengths = np.linalg.norm(chain.edges(r[:, None]), axis=1)[:, 0]
    worst = int(np.argmax(np.abs(lengths - chain.ds)))
    if not abs(lengths[worst] - chain.ds) <= LENGTH_TOLERANCE * chain.ds:
        before = worst + (chain.root is None)
        where = "the clamp r_0" if before == 0 else f"point {before}"
        text = f"{lengths[worst]:.10g} from {where} to point {before + 1}, expected ds = {chain.ds:.10g}"
        raise ProblemError(f"the initial chain violates the length constraint: {text}")


def check_functions(fibre: Fibre, r: Array, v: Array) -> None:
    """Check the shapes that u, C and D return on `PROBES` paths at the initial data, each of shape (n,).

    Raises
    ------
    ProblemError
        If a returned array has an unexpected shape.
    """
    chain = fibre.chain
    r, v = (np.repeat(x[:, None], PROBES, axis=1) for x in (r, v))
    x, y, tau = fibre.edges(chain.positions(r), chain.velocities(v))
    vector, matrix = x.shape, (chain.d, *x.shape)
    _check_shape("flow u(r, t)", fibre.flow(x, 0.0), vector)
    if fibre.C is not None:
        _check_shape("C(r, tau, t)", fibre.C(x, tau, 0.0), matrix)
    if fibre.D is not None:
        _check_shape("D(r, v, tau, t)", fibre.D(x, y, tau, 0.0), matrix)


def _check_shape(name: str, value: object, expected: tuple[int, ...]) -> None:
    given = np.shape(value) if isinstance(value, np.ndarray) else type(value).__name__
    *components, edges, paths = expected
    allowed = {(*components, e, p) for e in (1, edges) for p in (1, paths)}
    if given not in allowed:
        text = f"expected {expected}: components, edges and paths, the last two of length 1 where nothing changes"
        raise ProblemError(f"{name} returned {given}, {text}")
