"""Claims that cannot hold because moments of the scheme tend to infinity as the step size tends to 0."""

from ..contracts.measure import STATIONARY, Measure, rests_on_moments
from ..contracts.scheme import Claim
from ..contracts.tally import Tally, unpacked
from ..probe.explosion import NAME, Explosion


def why_moments_diverge(claim: Claim | None, measure: Measure, probed: Tally) -> str:
    """Return why a claim cannot hold in its sense, or an empty string.

    Parameters
    ----------
    claim : Claim or None
    measure : Measure
        Measure of the claim.
    probed : Tally
        Evidence of the cell from single steps, without paths.
    """
    found = unpacked(NAME, Explosion, probed)
    if claim is None or found is None or not found.explodes:
        return ""
    step = f"a step of {float(found.h):.2g} takes |x| from {float(found.before):.0e} to {float(found.after):.0e}"
    if not rests_on_moments(claim, measure):
        return ""
    if measure.follows == STATIONARY:
        return f"rare paths of the scheme explode ({step}), so that it has no invariant law"
    return f"E|x_n|^p grows without bound as h falls ({step}): claim the order with sense='in probability'"
