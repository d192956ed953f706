"""Mean-square stability for small steps, which follows from a positive order.

On a linear equation with constant coefficients, an affine step maps the second moments by a matrix M(h). If the
second moments have an error of O(h^(1+q)) in one step, q > 0, then M(h) = I + h L + O(h^(1+min(q, 1))) with the
matrix L of the equation of the second moments. The spectral radius is 1 + a h + o(h) with the growth rate a of that
equation. If the equation is stable in mean square, a < 0, all steps below some size are stable.

A positive strong order is sufficient, too, because second moments then converge at each time T: M(h)^n -> exp(T L) if
n h -> T. If a < 0, choose T such that |exp(T L)| < 1/2. For all small h a power of M(h) then has a norm below 1, and
the spectral radius of M(h) is below 1.
"""

from sdaeverify import Claim

STABLE = Claim(
    measure="stability",
    value="conditional",
    source="second moments of a positive weak order: spectral radius 1 + a h + o(h), growth rate a < 0",
)
