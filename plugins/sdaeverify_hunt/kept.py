"""Results of a hunt as results of cells, which are saved as a run and printed by ``show``."""

from collections.abc import Iterable, Iterator, Mapping
from typing import NoReturn

from sdaeverify import Claim, Scheme, UsageError
from sdaeverify.measuring import Finding, Measure, Method, Reason, Verdict
from sdaeverify.studying import Cell, CellResult, Completed, ProblemSpec

from .report import Attack, HuntReport

QUANTITY = "claim"
# A counterexample is decided by one step or by paths of the example, which the file of the example repeats.
METHOD = Method("random problems", None)


def random_problem(form: str = "SDE") -> NoReturn:
    """Represent the random problems of a form in the tables of a run.

    Parameters
    ----------
    form : str

    Raises
    ------
    UsageError
        Always, because the problems are drawn by a hunt.
    """
    raise UsageError(f"random problems of {form} are drawn by `sdaeverify hunt`")


def hunt_work(
    report: HuntReport, schemes: Iterable[Scheme], measures: Mapping[str, Measure], words: Iterable[str]
) -> Completed:
    """Return the results of a hunt as a completed examination.

    A claim with a confirmed counterexample is refuted. All others are inconclusive, because a search proves nothing.

    Parameters
    ----------
    report : HuntReport
    schemes : iterable of Scheme
        Schemes of the report.
    measures : mapping of str to Measure
        Measures by name.
    words : iterable of str
        Options of the command that repeats the hunt.
    """
    known = {scheme.label: scheme for scheme in schemes}
    results = [_result(each, known[each.scheme], measures[each.measure]) for each in report.attacks if each.tried]
    return Completed(results, ("hunt", "{scheme}", "-m", "{measure}", *words))


def _result(attack: Attack, scheme: Scheme, measure: Measure) -> CellResult:
    spec = ProblemSpec("random-problem", random_problem, (("form", attack.form),))
    return CellResult(Cell(scheme, spec, measure), tuple(_findings(attack, scheme)), seconds=attack.seconds)


def _findings(attack: Attack, scheme: Scheme) -> Iterator[Finding]:
    """Yield a finding for each claim that applies to an example."""
    claims = [claim for claim in scheme.promises if claim.measure == attack.measure and attack.claims.get(str(claim))]
    for number, claim in enumerate(claims, 1):
        refuted = attack.confirmed and attack.claim == str(claim)
        name = QUANTITY if len(claims) == 1 else f"{QUANTITY} {number}"
        verdict = Verdict.REFUTED if refuted else Verdict.INCONCLUSIVE
        yield Finding(quantity=name, verdict=verdict, reason=_reason(attack, claim), claim=claim, method=METHOD)


def _reason(attack: Attack, claim: Claim) -> Reason:
    if attack.example is not None and attack.claim == str(claim):
        return Reason(f"{attack.reason.rstrip('.')}; {'confirmed by a run' if attack.confirmed else 'not confirmed'}")
    count = attack.claims[str(claim)]
    return Reason(f"no counterexample among {count} random problems, which is no proof")
