"""The inextensible fibre, clamped at one end and hanging in a turbulent flow."""

from sdaeverify import HolonomicSDAE, hookimpl, in_matrix

from .._brief import BRIEF, PROJECTED
from ._chain import clamped_chain
from ._fibre import Fibre
from ._problem import fibre_problem


@in_matrix({"alpha": 4.0, "N": 2, "horizon": 0.01}, schemes=PROJECTED, measures=BRIEF)
def fibre_clamped(
    alpha: float = 0.4, beta: float = 0.1, Dr: float = 0.1, N: int = 7, d: int = 2, horizon: float = 0.25
) -> HolonomicSDAE:
    """Fibre of N points, clamped: dr_i = v_i dt, dv_i = a_i dt + beta Dr^{-2} ds^{-1/2} dw_i + (grad g dmu)_i.

    With ds = 1/(N + 1), edge values x_{i-1/2} = (x_i + x_{i-1})/2, Fr = 3, the flow u = (x_2, -x_1) and

        f_{i-1/2} = -Fr^{-2} e_2 + Dr^{-2} (u(r_{i-1/2}) - v_{i-1/2}),
        a_i = -alpha^{-2} ds^{-4} (r_{i+2} - 4 r_{i+1} + 6 r_i - 4 r_{i-1} + r_{i-2}) + (f_{i+1/2} + f_{i-1/2})/2,
        (grad g dmu)_i = ds^{-2} [(r_{i+1} - r_i) dmu_{i+1/2} - (r_i - r_{i-1}) dmu_{i-1/2}],

    |r_i - r_{i-1}| = ds. The fibre starts straight down and at rest; r_{-1} and r_0 are fixed at (+-ds/2) e_2, and
    the last end is free of stress. The default parameters are those of the source's section 4.2, for which Euler's
    explicit steps are stable up to h = 1.34e-5; with alpha = 4 up to 1.33e-3. The matrix contains a soft short fibre.
    For another Fr or flow, or for matrix-valued drag and turbulence, see `Fibre` and `fibre_problem`.

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
    Lindner et al. (2018), (2.8) and section 4.2.
    """
    return fibre_problem(Fibre(chain=clamped_chain(N, d), alpha=alpha, beta=beta, Dr=Dr), horizon)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [fibre_clamped]
