"""The inextensible fibre with two free ends in a turbulent flow."""

from sdaeverify import HolonomicSDAE, hookimpl, in_matrix

from .._brief import BRIEF, PROJECTED
from ._chain import free_chain
from ._fibre import Fibre
from ._problem import fibre_problem


@in_matrix({"alpha": 4.0, "N": 2, "d": 3, "horizon": 0.01}, schemes=PROJECTED[1:], measures=BRIEF)
def fibre_free(
    alpha: float = 0.4, beta: float = 0.1, Dr: float = 0.1, N: int = 7, d: int = 2, horizon: float = 0.25
) -> HolonomicSDAE:
    """Fibre of N points, free of stress at both ends: dv_i = a_i dt + beta Dr^{-2} ds^{-1/2} dw_i + (grad g dmu)_i.

    a_i, g, Fr and the flow are those of the clamped fibre, with ds = 1/N and N - 1 constraints; beyond both ends the
    chain is straight, r_0 = 2 r_1 - r_2. The fibre starts along the first axis, r_i = s_i e_1, and at rest. The
    matrix contains a soft short fibre in three dimensions.

    Parameters
    ----------
    alpha : float
        Bending number, positive; small values mean a stiff fibre.
    beta : float
        Strength of the turbulence.
    Dr : float
        Drag number, positive.
    N : int
        Number of points, at least 2.
    d : int
        Dimension of space, 2 or 3.
    horizon : float
        Final time, in the unit in which Fr and Dr are given; the length of the fibre is 1.

    Source
    ------
    Lindner et al. (2018), (2.2b) and (2.8).
    """
    return fibre_problem(Fibre(chain=free_chain(N, d), alpha=alpha, beta=beta, Dr=Dr), horizon)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [fibre_free]
