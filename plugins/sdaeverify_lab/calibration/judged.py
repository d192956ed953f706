"""Results of the strong measure on sequences of paths: published intervals, and verdicts at each look."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Claim, Problem, Scheme, Settings
from sdaeverify.measuring import Evidence, Finding, Measure, Tally, Verdict
from sdaeverify.studying import match

from ..cases import CalibrationCase
from .repeated import POOLED, UNIT, one, pool

# Excess of the claimed order: a true claim, and a false one.
ABOVE = (0.0, 0.5)
OUTCOME = {Verdict.VERIFIED: 1.0, Verdict.REFUTED: -1.0}
LOOKS = tuple(2**look for look in range(POOLED.bit_length()))


class JudgedSequences(NamedTuple):
    """Results of the strong measure on S sequences.

    Attributes
    ----------
    low, high, asymptotic, half : ndarray, shape (S,)
        Ends of the 95 % interval of the slope from all paths, and the asymptotic order with its half-width.
    outcome, paths : ndarray, shape (S, 2, 2)
        1 for verified, -1 for refuted, 0 for neither, and the number of paths used; for the true order and for half
        an order more, from paths alone and with local orders.
    """

    low: Array
    high: Array
    asymptotic: Array
    half: Array
    outcome: Array
    paths: Array


def judge_sequences(
    case: CalibrationCase, pair: tuple[Scheme, Problem], measure: Measure, noted: tuple[Tally, Tally]
) -> JudgedSequences:
    """Judge every sequence of a block.

    Parameters
    ----------
    case : CalibrationCase
    pair : tuple of Scheme and Problem
    measure : Measure
        Measure of errors along paths.
    noted : tuple of Tally
        Stacked evidence on the full state, and health of the block.

    Returns
    -------
    JudgedSequences
    """
    (strong, health), (scheme, problem) = noted, pair
    view = match(scheme, problem).problem
    assert view is not None
    # Only these looks and sides share the error probability, because there are no further tests.
    settings = Settings(paths=UNIT * POOLED, block=UNIT, max_looks=len(LOOKS), tests_reserved=1)
    probed = measure.probe(scheme, view, settings)
    evidence = Evidence(scheme, problem, view, settings, Tally(), health, level=settings.level)
    looks = [pool(strong, count, POOLED) for count in LOOKS]
    sequences = range(len(looks[0].sums["paths"]))
    with np.errstate(all="ignore"):
        published = [
            _published_intervals(measure, replace(evidence, tally=one(looks[-1], index))) for index in sequences
        ]
        verdicts = [
            list(_verdicts(case, measure, evidence, ([one(look, index) for look in looks], probed)))
            for index in sequences
        ]
    found = np.array(verdicts).reshape(-1, len(ABOVE), 2, 2)
    low, high, asymptotic, half = np.array(published).T
    return JudgedSequences(low, high, asymptotic, half, found[..., 0], found[..., 1])


def _published_intervals(measure: Measure, evidence: Evidence) -> tuple[float, float, float, float]:
    finding = _finding(measure, replace(evidence, settings=replace(evidence.settings, confidence=0.95)))
    asymptotic, half = (finding.details[name] for name in ("asymptotic_order", "asymptotic_half_width"))
    return finding.low, finding.high, float(str(asymptotic)), float(str(half))


def _verdicts(
    case: CalibrationCase, measure: Measure, evidence: Evidence, noted: tuple[list[Tally], Tally]
) -> Iterator[tuple[float, float]]:
    """Yield outcome and number of paths for each claim, from paths alone and with local orders."""
    looks, probed = noted
    for above in ABOVE:
        claim = Claim(measure=measure.name, value=case.order + above, source="calibration")
        for local in (Tally(), probed):
            yield _sequential(measure, replace(evidence, claims=(claim,)), [look.merge(local) for look in looks])


def _sequential(measure: Measure, evidence: Evidence, looks: list[Tally]) -> tuple[float, float]:
    for tally in looks:
        now = replace(evidence, tally=tally)
        finding = _finding(measure, now)
        if finding.settled:
            break
    return OUTCOME.get(finding.verdict, 0.0), float(now.paths)


def _finding(measure: Measure, evidence: Evidence) -> Finding:
    return measure.judge(evidence).findings[0]
