"""The torus of Laurent (2022), section 4.1, as the zeros of a polynomial of degree four."""

from collections.abc import Mapping
from math import inf

from sdaeverify import ConstrainedLangevin, hookimpl, in_matrix

from .._brief import LIMIT
from ._geometry import Quartic
from ._problem import torus_problem

STIFFNESS = 25.0
SOURCE = "stationary Fokker-Planck equation, tabulated Galerkin solution; E |x|^2 to 1e-8, from eps = 0.1 on to 2e-6"
# Invariant means of |x|^2, x_1, zeta and zeta^2 for stiffness 25, by eps.
TABLE = {
    1e-6: (4.12244885, 2.01038279, 3.0462e-5, 2.35167e-3),
    1e-4: (4.12234154, 2.01033069, 3.03710e-3, 0.234519),
    1e-3: (4.12139741, 2.00987097, 0.0295656, 2.287883),
    3e-3: (4.11948402, 2.00893189, 0.0837641, 6.510749),
    1e-2: (4.11430620, 2.00633435, 0.2337753, 18.40518),
    2e-2: (4.10946821, 2.00381613, 0.3794574, 30.27578),
    5e-2: (4.10240316, 1.99991241, 0.6062270, 49.49163),
    0.1: (4.0981068, 1.9973350, 0.756980, 62.8699),
    1.0: (4.092687, 1.993658, 0.97454, 83.296),
    10.0: (4.092061, 1.993178, 1.00325, 86.115),
}


@in_matrix({"eps": 0.0}, schemes=LIMIT, measures=("drift", "weak"))
def torus(eps: float = 0.1, stiffness: float = STIFFNESS, horizon: float = 0.125) -> ConstrainedLangevin:
    """Langevin dynamics with zeta = (|x|^2 + R^2 - r^2)^2 - 4 R^2 (x_1^2 + x_2^2), R = 3, r = 1, sigma = sqrt(2).

    f = -stiffness (x - (R - r, 0, 0)), from (R - r, 0, 0). No invariant density is known for eps > 0: means exist
    only for stiffness 25 and ten tabulated values of eps. In the limit they are computed from exp(-V) on the surface.

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time.
    stiffness : float
        Stiffness of the potential, unit 1/time, from 16 to 2500.
    horizon : float
        Final time. Steps of constrained Euler need h <= 1/50, otherwise the projection may have no root.

    Source
    ------
    Laurent (2022), section 4.1.
    """
    return torus_problem(
        Quartic(),
        eps,
        stiffness,
        horizon,
        (lambda: tabulated_means(eps, stiffness), SOURCE),
        lambda other: torus(other, stiffness, horizon),
    )


def tabulated_means(eps: float, stiffness: float) -> Mapping[str, float]:
    """Return the tabulated invariant means, empty if eps or the stiffness is not in the table."""
    row = TABLE.get(eps if stiffness == STIFFNESS else inf, ())
    return dict(zip(("|x|^2", "x_1", "zeta", "zeta^2"), row, strict=False))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [torus]
