"""Steps after the horizon, on which claims about all times rest: stationary laws and mean-square stability.

Powers of one step, and detailed balance, stand for steps at all times. A step that is another one from some time
after the horizon on has another law, or grows, and no time in the horizon shows it.
"""

import numpy as np

from ..contracts.finding import Finding, Reason, Verdict
from ..contracts.scheme import Scheme
from ..contracts.tally import Tally, packed, unpacked
from ..errors import FAULTS
from ..forms import Problem
from ..probe.local.delay_links import remove_delay
from ..probe.step.one_step import OneStep
from ..probe.step.times import LateChange, late_change
from ..verdicts.coverage import why_not_claimed
from ..verdicts.rules import withhold

LATE = "steps after the horizon"


def late_steps(scheme: Scheme, view: Problem, measure: str) -> Tally:
    """Return whether steps after the horizon differ from earlier ones, for a scheme with a claim of a measure.

    Empty if states cannot be compared, or if a step cannot be made from them.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    measure : str
        Name of the measure.
    """
    if why_not_claimed(scheme, view, measure):
        return Tally()
    try:
        step = OneStep(*remove_delay(scheme, view))
        return Tally() if step.why_not_comparable() else packed(LATE, late_change(step))
    except FAULTS:
        return Tally()


def withhold_late(found: Finding, tally: Tally) -> Finding:
    """Return a finding, not verified if steps after the horizon differ from earlier ones."""
    known = unpacked(LATE, LateChange, tally)
    if known is None or not np.isfinite(known.late) or found.verdict is not Verdict.VERIFIED:
        return found
    text = "a step at t = {late:.3g} differs from one at t = {early:.3g} with the same noise, and the claim is about "
    text += "all times"
    return withhold(found, Reason(text, numbers={"late": float(known.late), "early": float(known.early)}))
