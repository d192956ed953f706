"""Known expectations near and on SO(m) with f = -kappa (x - Id) and sigma^2 = 2, computed or tabulated."""

from collections.abc import Iterator
from functools import cache
from math import sqrt

from sdaeverify import InvariantMean, Moment, Truth

from ._eigenangle_law import STRONGEST, mean_trace, single_angle
from ._polar_law import PolarLaw

# E tr x changes with eps at a rate of order m: for smaller eps the limit value is accurate to 1e-8.
NEGLIGIBLE = 1e-10
SIGMA = sqrt(2.0)
LIMIT = "exp(kappa tr Q) times Haar's measure, Weyl's integration formula"
MOMENT = "diffusion of the eigenangle, eigenfunctions in polynomials"
IDENTITY = "stationary identity of |x|^2, with E tr x: "
COMPUTED = "density in singular values and rotations, quadrature to 1e-8"
TABULATED = "importance sampling with quasi-random points, to {}"
# Values of E tr x by m and eps for kappa = 100, with their accuracy.
SAMPLED = {
    (4, 1e-4): (3.9717384, "1e-7"),
    (4, 1e-3): (3.985870, "1e-6"),
    (4, 5e-3): (4.023898, "2e-6"),
    (4, 5e-2): (4.08285, "1e-5"),
    (5, 1e-4): (4.952652, "2e-6"),
    (5, 1e-3): (4.97424, "1e-5"),
    (5, 5e-3): (5.032300, "5e-6"),
    (5, 5e-2): (5.12237, "5e-5"),
}


def mean_trace_around(eps: float, m: int, kappa: float) -> tuple[float, str] | None:
    """Return E tr x for eps > 0 and its source, or None if it is unknown."""
    if eps < NEGLIGIBLE:
        return mean_trace(m, kappa), COMPUTED
    if m <= 3:
        return PolarLaw(eps, kappa, SIGMA, m).trace(), COMPUTED
    value, accuracy = SAMPLED.get((m, eps if kappa == 100.0 else 0.0), (None, ""))
    return None if value is None else (value, TABULATED.format(accuracy))


@cache
def truths(eps: float, m: int, stiffness: float) -> tuple[Truth, ...]:
    """Return the known expectations; sigma^2 = 2, so that a = stiffness."""
    return tuple(_penalised_truths(eps, m, stiffness) if eps else _constrained_truths(m, stiffness))


def _constrained_truths(m: int, a: float) -> Iterator[Truth]:
    yield InvariantMean(observable="tr x", value=mean_trace(m, a), source=LIMIT)
    if m <= 3 and a <= STRONGEST:
        angle = single_angle(m, a, SIGMA)
        yield Moment(
            observable="tr x",
            value=lambda t: m % 2 + 2.0 * angle.expectation(lambda y: y, 1.0, t),
            source=MOMENT,
        )


def _penalised_truths(eps: float, m: int, kappa: float) -> Iterator[Truth]:
    """Yield E tr x and E |x|^2 if E tr x is known.

    (1 + 2 kappa eps) E|x|^2 = m + eps (2 kappa E tr x + sigma^2 (q + m^2)), q = m (m + 1)/2.
    """
    known = mean_trace_around(eps, m, kappa)
    if known is not None:
        mean, source = known
        yield InvariantMean(observable="tr x", value=mean, source=source)
        square = m + eps * (2.0 * kappa * mean + SIGMA**2 * (m * (m + 1) / 2 + m**2))
        yield InvariantMean(observable="|x|^2", value=square / (1.0 + 2.0 * kappa * eps), source=IDENTITY + source)
