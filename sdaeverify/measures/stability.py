"""Mean-square stability: the step sizes for which second moments stay bounded on a linear problem.

The spectral radius of the scheme's second-moment operator decides (T2). No paths are sampled, because a sample of
E |x_n|^2 gives wrong verdicts if rare paths dominate it. Two claims are supported:

``A-stable``
    on a problem that is mean-square stable, the scheme is stable for every step size of a wide scan;
``conditional``
    on such a problem it is stable for all small step sizes.

Without a claim, only the step sizes of the run are examined: the largest stable one is reported.
"""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np
import scipy

from ..arrays import Array
from ..contracts.claimed import Word
from ..contracts.finding import Finding, Judgement, LevelFinding, Method, Opinion, Reason, Verdict
from ..contracts.measure import Evidence, Measure
from ..contracts.scheme import Claim, Scheme, flatten
from ..contracts.settings import Settings
from ..contracts.spelling import counted
from ..contracts.tally import Tally, packed, unpacked
from ..errors import FAULTS, one_line
from ..forms import Delayed, Problem
from ..forms.truths import MeanSquareStability
from ..probe.linear.affine import AFFINE
from ..probe.linear.delay_equation import LARGE, SMALL, UNIT
from ..probe.linear.delay_step import limits
from ..probe.stability.spectral import DENSE
from ..probe.stability.stability import (
    StabilityRecord,
    delay_stability,
    stability,
    why_not_delay_stability,
    why_not_in_runs,
    why_not_stability,
)
from ..probe.stability.windows import describe_windows, find_undecided, smallest_boundary
from ..registry.hookspecs import hookimpl
from ..verdicts.coverage import coverage, why_not_claimed
from ..verdicts.opinions import finding, judge_claim, leave_open
from .late_steps import late_steps, withhold_late

QUANTITY = "second moment"
# By the size of the states for which a step with a delay is linear.
LIMITS = {UNIT: QUANTITY, SMALL: f"{QUANTITY} at small states", LARGE: f"{QUANTITY} at large states"}
# Step size for the test of linearity, relative to the delay.
# Size: where linearity is tested; any step size would do.
QUARTER = 0.25
A_STABLE, CONDITIONAL = Word("A-stable"), Word("conditional")
METHOD = Method("spectral radius", 2)
UNSCANNED = "only the step sizes of the run were examined, because the scheme made no claim then"
UNLIKE_RUNS = "the step cannot be probed: steps of a run differ from those that enter begins"


class Stability(Measure):
    """Mean-square stability of a scheme on a linear problem."""

    name: ClassVar[str] = "stability"
    value_of: ClassVar[str] = "largest stable h"
    detail_columns: ClassVar[Mapping[str, str]] = {
        "windows": "step sizes at which second moments tend to 0; without a claim, only among those of the run",
        "undecided": "step sizes of the scan at which the spectral radius is not distinguishable from 1",
        "growth_rate": "growth rate of second moments of the equation, negative where it is stable",
        "proved_below": "step size below which the scheme proves stability",
    }
    level_columns: ClassVar[Mapping[str, str]] = {
        "certified_width": "bound of the error of the spectral radius",
        "linearity_defect": "by how much the step is not linear",
        "failed": "whether a step failed",
        "pole": "least noise, in standard deviations, at which the step has a pole; inf for none",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: no linear constant coefficients, or a step that cannot be probed."""
        view = scheme.view_of(problem)
        if view is None:
            return "the problem has no view of the scheme's form"
        try:
            if delayed := view.capability(Delayed):
                return why_not_delay_stability(scheme, delayed)
            return why_not_stability(scheme, view) or _unasked(scheme, view)
        except FAULTS as error:
            # A problem may have no coefficients far from its solutions.
            return f"it cannot be tested whether the step is linear: {one_line(error)}"

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the spectral radius at the step sizes of the run and, for a claim, on a wide range of them."""
        sizes = [view.horizon / count for count in settings.steps]
        claimed = not why_not_claimed(scheme, view, self.name)
        delayed = view.capability(Delayed) is not None
        if not delayed and why_not_in_runs(scheme, view):
            return Tally()
        found = late_steps(scheme, view, self.name)
        if not delayed:
            return found.merge(packed(QUANTITY, stability(scheme, view, sizes, scan=claimed)))
        for scale in limits(scheme, view, QUARTER * view.delay):
            record = delay_stability(scheme, view, sizes, scale, scan=claimed)
            found = found.merge(packed(LIMITS[scale], record))
        return found

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding on the windows of stability, and the spectral radius at the run's step sizes.

        If an equation with a delay is linear only in the limits of small and of large states, there is a finding for
        each.
        """
        records = {name: unpacked(name, StabilityRecord, evidence.tally) for name in LIMITS.values()}
        known = {name: record for name, record in records.items() if record is not None}
        judged = (_finding(evidence, name, record) for name, record in known.items())
        findings = [withhold_late(found, evidence.tally) for found in judged]
        rows = tuple(row for name, record in known.items() for row in _levels(name, record))
        covered = coverage(evidence, self.name, QUANTITY)
        return Judgement(tuple(findings or [finding(covered, leave_open(covered, UNLIKE_RUNS))]), rows)


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Stability()]


def _unasked(scheme: Scheme, view: Problem) -> str:
    """Return that second moments are expensive and no claim is about them, or an empty string."""
    if any(claim.measure == Stability.name for claim in scheme.promises):
        return ""
    k = len(flatten(scheme.start(view, 1, view.horizon)))
    if k * (k + 1) // 2 <= DENSE:
        return ""
    return f"no claim about second moments, and their matrix with {k * (k + 1) // 2} rows is costly"


def _finding(evidence: Evidence, name: str, record: StabilityRecord) -> Finding:
    covered = coverage(evidence, Stability.name, name)
    opinion = judge_claim(covered, lambda claim: _opinion(claim, record, evidence), {A_STABLE.text, CONDITIONAL.text})
    linear = not _nonlinear(record)
    return finding(
        covered,
        opinion._replace(tier=2),
        # If the equation itself is not stable, there is no largest stable step size.
        estimate=_boundary(record) if linear and record.decays > 0.0 else np.nan,
        method=METHOD,
        details={
            "windows": _windows(record) if linear else "",
            "undecided": len(find_undecided(record.scan.sign)),
            "growth_rate": float(record.abscissa),
            "proved_below": evidence.scheme.stable_below(evidence.view),
        },
    )


def _boundary(record: StabilityRecord) -> float:
    return smallest_boundary(record.windows) if record.scan.h.size else record.most


def _windows(record: StabilityRecord) -> str:
    if record.scan.h.size:
        return describe_windows(record.windows)
    return f"h <= {record.most:.6g} in the run" if record.most else "none in the run"


def _levels(name: str, record: StabilityRecord) -> Iterator[LevelFinding]:
    for h, rho, error, defect, failed, pole in zip(*record.run, strict=True):
        details = {
            "certified_width": float(error),
            "linearity_defect": float(defect),
            "failed": bool(failed),
            "pole": float(pole),
        }
        yield LevelFinding(name, None, float(rho), 0.0, details, float(h))


def _opinion(claim: Claim, record: StabilityRecord, evidence: Evidence) -> Opinion:
    if reason := _nonlinear(record) or _problem_doubt(record, evidence):
        return Opinion(Verdict.INCONCLUSIVE, Reason(reason))
    if not record.decays:
        rate = f"growth rate {float(record.abscissa):.3g}"
        return Opinion(Verdict.OUT_OF_SCOPE, Reason(f"nothing to test: the exact solution is not stable ({rate})"))
    if not record.scan.h.size:
        return Opinion(Verdict.INCONCLUSIVE, Reason(UNSCANNED))
    sign = record.scan.sign
    unstable = sign > 0 if claim.value == A_STABLE else sign[:1] > 0
    if unstable.any():
        return Opinion(Verdict.REFUTED, Reason(_unstable(record, int(np.argmax(unstable)))))
    if doubt := _doubt(record, sign if claim.value == A_STABLE else sign[:1]):
        return Opinion(Verdict.INCONCLUSIVE, Reason(doubt))
    return Opinion(Verdict.VERIFIED, Reason(_stable(record)))


def _nonlinear(record: StabilityRecord) -> str:
    scan, run = record.scan, record.run
    h, defect = np.concatenate([scan.h, run.h]), np.concatenate([scan.defect, run.defect])
    worst = int(np.argmax(defect))
    if defect[worst] <= AFFINE:
        return ""
    return f"the step is not linear in the state: relative deviation {defect[worst]:.2g} at h = {h[worst]:.3g}"


def _problem_doubt(record: StabilityRecord, evidence: Evidence) -> str:
    if np.isnan(record.decays):
        return "not testable here: the exact solution is only marginally stable (growth rate 0 to round-off)"
    stable = bool(record.decays)
    truths = [truth for truth in evidence.problem.truths if isinstance(truth, MeanSquareStability)]
    if record.at_rest and any(truth.stable != stable for truth in truths):
        return f"growth rate {float(record.abscissa):.3g} of the coefficients contradicts the declared stability"
    return ""


def _doubt(record: StabilityRecord, sign: Array) -> str:
    scan = record.scan
    poles = np.flatnonzero(np.isfinite(scan.pole))
    if len(poles):
        first = poles[0]
        z, far = scan.pole[first], scipy.special.erfc(scan.pole[first] / np.sqrt(2.0))
        text = (
            f"second moment infinite at h = {scan.h[first]:.3g}: the step has a pole at {z:.3g} standard deviations"
        )
        return f"{text} (probability {far:.1g}); without it, spectral radius {scan.rho[first]:.6g}"
    if failed := np.count_nonzero(scan.failed[: len(sign)]):
        return f"no root at {failed} step sizes, the smallest h = {scan.h[np.argmax(scan.failed > 0.0)]:.3g}"
    open_ = find_undecided(sign)
    if not len(open_):
        return ""
    first = open_[0]
    if np.isnan(scan.rho[first]):
        return f"spectral radius not known at {counted(len(open_), 'step size')}, the first h = {scan.h[first]:.3g}"
    bounds = f"{scan.rho[first]:.12g}, known to {scan.error[first]:.1g}, at h = {scan.h[first]:.3g}"
    return f"spectral radius not distinguishable from 1 at {counted(len(open_), 'step size')}: {bounds}"


def _unstable(record: StabilityRecord, place: int) -> str:
    scan = record.scan
    boundary = smallest_boundary(record.windows)
    text = f"spectral radius {scan.rho[place]:.6g} at h = {scan.h[place]:.3g}"
    return f"stable only for h < {boundary:.6g}; {text}" if boundary > 0.0 else f"unstable for small h: {text}"


def _stable(record: StabilityRecord) -> str:
    h, boundary = record.scan.h, smallest_boundary(record.windows)
    if boundary < np.inf:
        return f"stable for h < {boundary:.6g}, tested down to {h[0]:.3g}"
    apart = 100.0 * float((h[1:] / h[:-1]).max() - 1.0)
    return f"stable at all {len(h)} step sizes from {h[0]:.3g} to {h[-1]:.3g}, neighbours at most {apart:.2g} % apart"
