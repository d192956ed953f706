"""Family-wise error control of a run: Holm's step-down procedure over all tests.

There are two families: all rejections that refute a claim, and all rejections that verify one. In each family the
probability of any false verdict is at most alpha. Deterministic verdicts involve no sampling error and are excluded.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import isnan

from ..contracts.finding import Verdict
from ..verdicts.rules import Case, send
from .judging import CellResult

Place = tuple[int, int]


def family_wise(results: Sequence[CellResult], alpha: float) -> list[CellResult]:
    """Return the results with verdicts that hold family-wise.

    Early decisions are taken at a level that is shared among more tests than a run usually has. So the
    procedure usually adds verdicts; in a run with more tests it may revoke one.

    Parameters
    ----------
    results : sequence of CellResult
    alpha : float
        Error probability of each family.

    Returns
    -------
    list of CellResult
    """
    claims = [
        ((i, j), finding)
        for i, result in enumerate(results)
        for j, finding in enumerate(result.findings)
        if finding.claim is not None
    ]
    allowed = {
        Verdict.REFUTED: holm({place: finding.p_refuted for place, finding in claims}, alpha),
        Verdict.VERIFIED: holm({place: finding.p_verified for place, finding in claims}, alpha),
    }
    decided = [list(result.findings) for result in results]
    for (i, j), finding in claims:
        significant = frozenset(verdict for verdict, places in allowed.items() if (i, j) in places)
        decided[i][j] = send(finding, Case(significant=significant))
    changed = {i for (i, j), finding in claims if decided[i][j] is not finding}
    return [
        replace(result, findings=tuple(decided[i])) if i in changed else result for i, result in enumerate(results)
    ]


def holm(p_values: dict[Place, float], alpha: float) -> set[Place]:
    """Return the hypotheses that Holm's procedure rejects at level `alpha`; a p-value of NaN is not a test."""
    tests = sorted((p, place) for place, p in p_values.items() if not isnan(p))
    rejected: set[Place] = set()
    for rank, (p, place) in enumerate(tests):
        if p > alpha / (len(tests) - rank):
            break
        rejected.add(place)
    return rejected
