"""Coefficients of a linear equation dx = (A x + a) dt + sum_j (C_j x + c_j) dW_j, and its second moments.

For z = (x, 1) with A~ = [[A, a], [0, 0]] and C~_j = [[C_j, c_j], [0, 0]] the matrix P = E z z^T obeys, exactly,

    P' = A~ P + P A~^T + sum_j C~_j P C~_j^T     (Arnold 1974, section 8.5).
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms import Equation, Problem
from ...forms.names import article
from ..step.states import cloud
from .affine import AFFINE, at_corners, corners, defect, with_trials
from .second_moments import Operator, on_symmetric, smat, svec

# Size: times that are tried, as parts of the horizon.
TIMES = (0.3, 0.9)
# Theorem: any number below 1 will do. A P + P A^T = -Id + R with |R| <= r < 1 and P > 0 proves decay (Lyapunov).
RESIDUAL = 0.5


class LinearEquation(NamedTuple):
    """Coefficients acting on (x, 1) or, for a linear part, on x.

    Attributes
    ----------
    drift : ndarray, shape (n, n)
        A~ with n = d + 1, or A.
    diffusion : ndarray, shape (n, n, l)
        C~_j, or C_j.
    """

    drift: Array
    diffusion: Array

    @property
    def homogeneous(self) -> "LinearEquation":
        """The linear part, with A and C_j, which differences of two solutions satisfy."""
        return LinearEquation(self.drift[:-1, :-1], self.diffusion[:-1, :-1])

    @property
    def starts_at_rest(self) -> bool:
        """Whether zero is a solution: a = 0 and c_j = 0."""
        return not (self.drift[:, -1].any() or self.diffusion[:, -1].any())

    def generator(self) -> Array:
        """Return the matrix of P -> P' in the coordinates svec, shape (n (n + 1)/2, n (n + 1)/2)."""
        n, unit = len(self.drift), np.eye(len(self.drift))
        noise = Operator(self.diffusion, np.ones(self.diffusion.shape[-1]))
        return on_symmetric(np.kron(self.drift, unit) + np.kron(unit, self.drift), n) + noise.dense()

    @property
    def rate(self) -> float:
        """Bound of the rates of first and second moments, |A| + sum_j |C_j|^2, unit 1/time."""
        A, C = self
        return float(np.linalg.norm(A, 2) + sum(np.linalg.norm(C[..., j], 2) ** 2 for j in range(C.shape[-1])))

    @property
    def abscissa(self) -> float:
        """Largest real part of the eigenvalues of the generator: the growth rate of second moments."""
        return float(np.linalg.eigvals(self.generator()).real.max())

    def decays(self) -> bool | None:
        """Return whether the abscissa is negative; None if rounding errors are too large to decide.

        It is negative if and only if A P + P A^T + sum_j C_j P C_j^T = -Id has a positive definite solution P, which
        is then the integral of P(t) with P(0) = Id over t > 0. The statement remains true for a residual below Id.
        """
        A, C = self
        unit = np.eye(len(A))
        try:
            P = smat(np.linalg.solve(-self.generator(), svec(unit)), len(A))
        except np.linalg.LinAlgError:
            return None
        residual = A @ P + P @ A.T + Operator(C, np.ones(C.shape[-1]))(P) + unit
        if not np.linalg.norm(residual) <= RESIDUAL:
            return None
        # If the equation decays, P is at least (1 - RESIDUAL)/(2 |A|) Id; half of this is allowed for rounding.
        return bool(np.linalg.eigvalsh(P).min() > 0.25 * (1.0 - RESIDUAL) / self.rate)


def why_not_linear_equation(view: Problem) -> str:
    """Return why a problem is not linear with constant coefficients, or an empty string."""
    ito = view.ito()
    if ito is None:
        return f"{article(type(view).__name__)} offers no Ito equation whose coefficients could be linear"
    with np.errstate(all="ignore"):
        x = with_trials(cloud(view, ito))
        for name, (values, *later) in _coefficients(ito, x).items():
            if not np.isfinite(values).all():
                return f"the {name} is not linear in the state: its values are not all finite"
            if (found := defect(x, values, at_corners(values[:, : ito.dimension + 1]))) > AFFINE:
                return f"the {name} is not linear in the state (relative deviation {found:.1g})"
            if not all(np.array_equal(values, other) for other in later):
                return f"the {name} depends on time"
    return ""


# Cached, since it is needed at every step size.
@lru_cache(maxsize=8)
def linear_equation(ito: Equation) -> LinearEquation:
    """Return the coefficients of an equation for which `why_not_linear_equation` is empty."""
    x = corners(ito.dimension)
    drift, diffusion = (at_corners(values[0], last=0.0) for values in _coefficients(ito, x).values())
    return LinearEquation(drift[..., 0], diffusion)


def _coefficients(ito: Equation, x: Array) -> dict[str, list[Array]]:
    # Return values of f and B at the states x, shapes (d, states, 1) and (d, states, l), at time 0 and later times.
    times = (0.0, *(part * ito.horizon for part in TIMES))
    shape = (len(x), ito.noise_dim, x.shape[1])
    return {
        "drift": [np.broadcast_to(ito.drift(t, x), x.shape)[..., None] for t in times],
        "diffusion": [np.broadcast_to(ito.diffusion(t, x), shape).swapaxes(1, 2) for t in times],
    }
