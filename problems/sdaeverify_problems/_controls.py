"""Pairs of shipped schemes, a positive and a negative control of each order, for each kind of noise."""

from sdaeverify import Control


def _control(measure: str, order: float, positive: str, negative: str) -> Control:
    return Control(measure=measure, order=order, positive=positive, negative=negative)


STRONG_HALF = _control("strong", 0.5, "euler-maruyama", "displaced-euler")
WEAK_HALF = _control("weak", 0.5, "balanced-euler", "displaced-euler")
WEAK_ONE = _control("weak", 1.0, "euler-maruyama", "balanced-euler")

# Any noise: no shipped scheme has strong order 1 for all of them.
GENERAL = (STRONG_HALF, WEAK_HALF, WEAK_ONE)
# Any noise if increments contain H, whose signs a scheme of weak order 2 uses.
NONCOMMUTING = (*GENERAL, _control("weak", 2.0, "platen-weak-2-general", "euler-maruyama"))
# Any noise if increments contain H and Levy areas.
WITH_LEVY_AREAS = (*NONCOMMUTING, _control("strong", 1.0, "milstein-areas", "euler-maruyama"))
# One Brownian motion with a coefficient that depends on the state.
SCALAR = (
    *GENERAL,
    _control("strong", 1.0, "milstein", "euler-maruyama"),
    _control("weak", 2.0, "platen-weak-2", "euler-maruyama"),
)
# One such Brownian motion, or diagonal noise, if increments contain H.
WITH_AREAS = (*SCALAR, _control("strong", 1.5, "sri1w1", "milstein"))
# DB_j B_k = 0, so that Euler-Maruyama has strong order 1.
VANISHING = (*GENERAL, _control("strong", 1.0, "euler-maruyama", "balanced-euler"))
# DB_j B_k = 0, one Brownian motion, and a coefficient that depends on the state.
VANISHING_SCALAR = (*VANISHING, SCALAR[-1], _control("strong", 1.5, "sri1w1", "euler-maruyama"))
# DB_j B_k = 0 and several Brownian motions.
VANISHING_SEVERAL = (*VANISHING, NONCOMMUTING[-1])
ADDITIVE = (
    *VANISHING,
    _control("strong", 1.5, "sra1", "euler-maruyama"),
    _control("weak", 2.0, "sra1", "euler-maruyama"),
)
# An invariant law that can be computed for every scheme without sampling.
INVARIANT_ONE = _control("invariant", 1.0, "euler-maruyama", "displaced-euler")
# Linear equations, or noise in the velocity alone: SRA1 has order 2.
STRONG_TWO = _control("strong", 2.0, "sra1", "heun-additive")
STATIONARY = (*ADDITIVE, STRONG_TWO, INVARIANT_ONE, _control("invariant", 2.0, "sra1", "euler-maruyama"))
# Additive noise, an invariant law, and increments that contain K.
SMOOTH_LANGEVIN = (*STATIONARY, _control("strong", 3.0, "quicsort", "sra1"))
# Additive noise with two Brownian motions: schemes with H need four normals per step, too many for an accurate
# operator.
STATIONARY_PAIR = (*ADDITIVE, INVARIANT_ONE, _control("invariant", 2.0, "heun-additive", "euler-maruyama"))
