"""SDEs that every scheme solves exactly and whose solutions stay in a domain: rest, and motion along a line."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...arrays import Array, Parts
from ...noise.brownian import BROWNIAN
from ..domain import Domain
from ..trivial import SOURCE, Trivial, Trivials

# Duration of the motion from one state to the other, in units of time; the longest run of the checks takes 8.5.
TAKES = 10.0
# Number of points at which the segment is tested for inclusion in the domain.
CUTS = 65


def trivial_equations_in(form: Callable[..., Any], domain: Domain) -> Trivials:
    """Return the problems dx = 0 and, if a segment between two states is in the domain, dx = c dt.

    Parameters
    ----------
    form : callable
        Constructor of the problem: `SDE`.
    domain : Domain
    """
    d = domain.dimension
    # Numbers of components and Brownian motions.
    shapes = [(2, 2), (2, 1), (1, 1)] if d is None else [(d, d), (d, 1)]
    return tuple(tuple(_along(form, domain, shape, moves=moves) for shape in shapes) for moves in (False, True))


def _along(form: Callable[..., Any], domain: Domain, shape: tuple[int, int], *, moves: bool) -> Trivial:
    (d, l), ends = shape, domain.draw(shape[0], 2)
    start, c = ends[:, 0], moves * (ends[:, 1] - ends[:, 0]) / TAKES
    way = start[:, None] + c[:, None] * np.linspace(0.0, TAKES, CUTS)
    c = c if domain.contains(way).all() else 0.0 * c
    problem = form(
        drift=lambda _t, x: c[:, None] + 0.0 * x,
        diffusion=lambda _t, x: np.zeros((d, l, x.shape[1])),
        diffusion_derivative=lambda _t, x, _y: np.zeros((d, l, x.shape[1])),
        start=start,
        noise_dim=l,
        noise=frozenset(BROWNIAN),
        horizon=1.0,
        domain=domain,
        traits=frozenset({"additive-noise", "diagonal-noise"} if d == l else {"additive-noise"}),
        source=SOURCE,
    )

    def solution(t: float, W: Array) -> Parts:
        return {"x": start[:, None] + t * c[:, None] + 0.0 * W[:1]}

    return Trivial(f"{'dx = c dt' if moves else 'dx = 0'} with {domain}", problem, solution)
