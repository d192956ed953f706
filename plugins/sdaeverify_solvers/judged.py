"""Claims about runs of a solver with their tests, and findings that are corrected for all tests of a run."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from sdaeverify import Settings
from sdaeverify.measuring import (
    Coverage,
    Estimate,
    Evidence,
    Finding,
    Method,
    Opinion,
    PathTests,
    Verdict,
    decide,
    finding,
)
from sdaeverify.studying import holm


class Asked(NamedTuple):
    """A claim with its tests on paths, before the correction for all tests of a run.

    Attributes
    ----------
    measure : str
    covered : Coverage
    tests : PathTests
    estimate : Estimate
    resolution : float
        Largest undetected error of the limit, as part of the quantity's size; NaN if the limit is not tested.
    evidence : Evidence
    """

    measure: str
    covered: Coverage
    tests: PathTests
    estimate: Estimate
    resolution: float
    evidence: Evidence


def judge(asked: Sequence[Asked], confidence: float = Settings().confidence) -> list[Finding]:
    """Return the findings of a run, with verdicts corrected for all of its tests by Holm's procedure.

    Parameters
    ----------
    asked : sequence of Asked
    confidence : float, optional
        One minus the probability of any false verdict.
    """
    alpha = 1.0 - confidence
    level = alpha / max(len(asked), 1)
    refuted = holm({(i, 0): each.tests.refuted for i, each in enumerate(asked)}, alpha)
    verified = holm({(i, 0): each.tests.verified for i, each in enumerate(asked)}, alpha)
    return [
        _found(each, _opinion(each, level, refuted=(i, 0) in refuted, verified=(i, 0) in verified))
        for i, each in enumerate(asked)
    ]


def _opinion(asked: Asked, level: float, *, refuted: bool, verified: bool) -> Opinion:
    opinion = decide(asked.tests, replace(asked.evidence, level=level))
    if refuted:
        return opinion._replace(verdict=Verdict.REFUTED)
    if verified and Verdict.VERIFIED not in opinion.excluded:
        return opinion._replace(verdict=Verdict.VERIFIED)
    return opinion


def _found(asked: Asked, opinion: Opinion) -> Finding:
    low, high = asked.estimate.interval(asked.evidence.settings.confidence)
    found = finding(asked.covered, opinion, estimate=asked.estimate.value, method=Method("paths", 3))
    return replace(found, low=low, high=high, resolution=asked.resolution)
