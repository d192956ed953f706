"""The public names for authors of measures; no other import from the framework is needed.

A measure is a subclass of `Measure`, registered by the hook ``sdaeverify_measures``. It defines its question to a
scheme on a problem in up to four methods:

``refuses``
    returns why the question does not apply to a pair;
``observer``
    returns an `Observer` that records, on one block of paths, the components of all step sizes (`Snapshot`) in a
    `Tally` of sums over groups of paths, which blocks, machines and runs can merge; the truth is computed as well
    unless ``truths`` excludes it;
``probe``
    evaluates one step without sampling, see `sdaeverify.probing`; a record of numbers is `packed` into a tally,
    and `unpacked` where it is judged;
``judge``
    a pure function from `Evidence` to a `Judgement`: a `Finding` for each quantity, a `LevelFinding` for each of its
    step sizes.

A measure of a scalar per path, whose mean a claim bounds, is a `ScalarMeasure`: it needs one function.

The steps from a claim to a finding are the same for all of them::

    covered = coverage(evidence, self.name, "x")          # the strongest claim about x, or why there is none
    order = order_of(h, sums, counts)                      # a slope with its standard error, by the jackknife
    opinion = judge_claim(covered, lambda claim: decide(order_tests(claim, order, evidence), evidence))
    found = finding(covered, opinion, estimate=order.value, method=Method("paths", 3))

An `Opinion` is a `Verdict` with a `Reason`. Code that depends on a reason tests its `Kind`, never its text. Verdicts
from paths are corrected for all tests of a run by their p-values, and need the controls of the problem;
opinions from one step (`local_opinion`) are guarded by paths (`guard`).
"""

from .contracts.claimed import Bound, Order
from .contracts.finding import Finding, Judgement, Kind, LevelFinding, Method, Opinion, Reason, Verdict
from .contracts.measure import Evidence, Measure, Observer, Snapshot
from .contracts.tally import Tally, packed, unpacked
from .measures.scalar import ScalarMeasure
from .numerics.statistics import Estimate, group_sums, jackknife, order_of
from .verdicts.coverage import Coverage, coverage, why_not_claimed
from .verdicts.fitted_levels import FEWEST, FITTED, sound_levels
from .verdicts.opinions import (
    NOT_PROBED,
    decide,
    finding,
    guard,
    judge_claim,
    local_doubt,
    local_opinion,
    no_fit,
)
from .verdicts.path_tests import PathTests, order_tests, with_sample

__all__ = [
    "FEWEST",
    "FITTED",
    "NOT_PROBED",
    "Bound",
    "Coverage",
    "Estimate",
    "Evidence",
    "Finding",
    "Judgement",
    "Kind",
    "LevelFinding",
    "Measure",
    "Method",
    "Observer",
    "Opinion",
    "Order",
    "PathTests",
    "Reason",
    "ScalarMeasure",
    "Snapshot",
    "Tally",
    "Verdict",
    "coverage",
    "decide",
    "finding",
    "group_sums",
    "guard",
    "jackknife",
    "judge_claim",
    "local_doubt",
    "local_opinion",
    "no_fit",
    "order_of",
    "order_tests",
    "packed",
    "sound_levels",
    "unpacked",
    "why_not_claimed",
    "with_sample",
]
