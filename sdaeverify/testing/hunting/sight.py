"""Observation of a scheme's claim on a problem, by one step or, if one step does not decide, by a few paths."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np

from ...api import verify
from ...conformance.own_numbers import draws_own_numbers
from ...conformance.violation import violation
from ...contracts.claimed import Order
from ...contracts.finding import Opinion, Reason, Verdict
from ...contracts.matching import match
from ...contracts.measure import NONE_FOLLOW, Evidence, Followed, Measure
from ...contracts.scheme import Claim, Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally
from ...errors import FAULTS
from ...forms import Problem
from ...measures.path_errors.errors import STATE
from ...measures.strong import Strong
from ...measures.strong.findings import TOLERANCE as STRONG_TOLERANCE
from ...measures.strong.findings import judge_order, local_orders, probe_strong
from ...measures.weak import Weak
from ...measures.weak.probe import TOLERANCE as WEAK_TOLERANCE
from ...measures.weak.probe import judge_probe, probe_weak, weak_probe
from ...verdicts.coverage import claim_for, coverage
from ...verdicts.path_tests import DEEP_PATHS
from .pilot import growth

# Number of paths for measures that use only paths, and the confidence of their refutations.
FEW, CONFIDENCE = 64, 0.9999
# Least value of a goal that is not rounding, from which hypothesis maximises it.
CLIMB = 0.02
SETTINGS = Settings()
# Ways to refute a claim: by orders, or by a step that breaks the contract or does not follow the equation.
WAYS = ORDERS, STEPS = "orders", "steps"


class Target(NamedTuple):
    """Scheme, measure and form under attack.

    Attributes
    ----------
    scheme : Scheme
    measure : Measure
    form : str
        Form of the examples.
    followed : Followed
        Names of the measures whose claims imply that steps follow the equation.
    """

    scheme: Scheme
    measure: Measure
    form: str
    followed: Followed = NONE_FOLLOW


class Sight(NamedTuple):
    """Observation of a claim on a problem.

    Attributes
    ----------
    claim : str
        Refuted claim, or else the first examined one.
    refuted : str
        Reason of the refutation as a sentence; empty if the claim is not refuted.
    distance : float
        Defect of an order, of one step or along paths, below the claim; NaN if unknown.
    verified : bool
        Whether all claims are verified.
    growth : float
        log10 of the growth of a run; see `growth`.
    way : str
        Way of the refutation, an element of `WAYS`.
    claims : tuple of str
        All examined claims.
    """

    claim: str
    refuted: str = ""
    distance: float = nan
    verified: bool = False
    growth: float = 0.0
    way: str = ""
    claims: tuple[str, ...] = ()

    @property
    def goals(self) -> dict[str, float]:
        """Quantities that the search maximises, by name, if they exceed rounding."""
        known = {"distance": self.distance, "growth": self.growth}
        return {name: value for name, value in known.items() if np.isfinite(value) and value > CLIMB}


# A claim, the opinion on it, and the estimated order.
Seen = tuple[Claim, Opinion, float]


def applies(scheme: Scheme, problem: Problem, measure: Measure) -> Problem | None:
    """Return the view in which a measure tests a claim of a scheme on a problem, or None if it does not.

    Parameters
    ----------
    scheme : Scheme
    problem : Problem
        Problem as drawn.
    measure : Measure
        Measure of the claim.
    """
    view = match(scheme, problem).problem
    if view is None or measure.refuses(scheme, problem) or draws_own_numbers(scheme, view):
        return None
    scopes = (claim.when <= view.traits for claim in scheme.promises if claim.measure == measure.name)
    return view if any(scopes) else None


def look(target: Target, function: Callable[..., Problem], ways: Sequence[str] = WAYS) -> Sight | None:
    """Return the observation of a claim on an example, or None if no claim applies to it.

    Parameters
    ----------
    target : Target
        Scheme, and measure of its claims.
    function : callable
        Problem function of the example.
    ways : sequence of str
        Elements of `WAYS`, tried in order until one refutes.
    """
    with np.errstate(all="ignore"):
        try:
            problem = function()
            view = applies(target.scheme, problem, target.measure)
            if view is None:
                return None
            seen = _by_orders(target, function, (problem, view)) if ORDERS in ways else _claimed(target, view)
            if seen is None or seen.refuted or STEPS not in ways:
                return seen
            broken = violation(target.scheme, view, followed=target.followed)
            if broken:
                return seen._replace(refuted=Reason(broken).sentence, verified=False, way=STEPS)
            return seen._replace(growth=growth(target.scheme, view))
        except FAULTS:
            # Numbers for which a step raises are not a usable example.
            return None


def _claimed(target: Target, view: Problem) -> Sight:
    claims = (each for each in target.scheme.promises if each.measure == target.measure.name)
    held = _distinct(str(claim) for claim in claims if claim.when <= view.traits)
    return Sight(held[0], claims=held)


def _distinct(claims: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(claims))


def _by_orders(target: Target, function: Callable[..., Problem], problems: tuple[Problem, Problem]) -> Sight | None:
    scheme, measure, *_ = target
    if measure.name not in ONE_STEP:
        return _along_paths(scheme, function, measure, FEW)
    one_step, _ = ONE_STEP[measure.name]
    seen = list(one_step(scheme, *problems))
    return _worst(seen) if seen else _along_paths(scheme, function, measure, DEEP_PATHS)


def _worst(seen: list[Seen]) -> Sight:
    """Return the refuted claim, or else the first one with the largest distance of any order below its claim."""
    distances = [_distance(claim, order) for claim, _, order in seen]
    farthest = max((each for each in distances if np.isfinite(each)), default=nan)
    claims = _distinct(str(claim) for claim, *_ in seen)
    for claim, opinion, _ in seen:
        if opinion.verdict is Verdict.REFUTED:
            return Sight(str(claim), opinion.reason.sentence, farthest, way=ORDERS, claims=claims)
    verified = all(opinion.verdict is Verdict.VERIFIED for _, opinion, _ in seen)
    return Sight(claims[0], "", farthest, verified, claims=claims)


def _distance(claim: Claim, order: float) -> float:
    return claim.value.least - order if isinstance(claim.value, Order) else nan


def _evidence(scheme: Scheme, problem: Problem, view: Problem, tally: Tally) -> Evidence:
    return Evidence(scheme, problem, view, SETTINGS, tally, Tally())


def _strong(scheme: Scheme, problem: Problem, view: Problem) -> Iterator[Seen]:
    evidence = _evidence(scheme, problem, view, probe_strong(scheme, view, SETTINGS))
    for name, order in local_orders(evidence).items():
        claim = coverage(evidence, Strong.name, name).claim
        opinion = judge_order(evidence, claim, order)
        if claim is not None and opinion is not None:
            yield claim, opinion, order.order


def _weak(scheme: Scheme, problem: Problem, view: Problem) -> Iterator[Seen]:
    evidence = _evidence(scheme, problem, view, probe_weak(scheme, view, SETTINGS))
    for name in (STATE, *view.observables):
        claim = claim_for(scheme, view.traits, Weak.name, name).claim
        opinion, _ = judge_probe(evidence, claim, name)
        if claim is not None and opinion is not None:
            yield claim, opinion, weak_probe(evidence).order


def _along_paths(scheme: Scheme, function: Callable[..., Problem], measure: Measure, paths: int) -> Sight | None:
    rows = verify([scheme], [function], [measure], paths=paths, confidence=CONFIDENCE).verdicts
    claimed: Any = rows[(rows.scheme == scheme.label) & rows["claim"].fillna("").astype(bool)]
    # Rows in error or not run say nothing about the claim and do not count as examined.
    if not len(claimed) or {str(Verdict.ERROR), str(Verdict.NOT_RUN)} & set(claimed["verdict"]):
        return None
    # Report the row of a refuted quantity, or else the first one.
    worst = claimed.sort_values("verdict", key=lambda given: given != str(Verdict.REFUTED), kind="stable").iloc[0]
    refuted = worst["reason"] if Verdict(worst["verdict"]) is Verdict.REFUTED else ""
    slower = (claimed["claimed_order"] - claimed["path_order"]).astype(float).max()
    verified = set(claimed["verdict"]) == {str(Verdict.VERIFIED)}
    way, claims = ORDERS if refuted else "", _distinct(claimed["claim"])
    return Sight(worst["claim"], refuted, float(slower), verified, way=way, claims=claims)


# Measures that one step decides, with the function that examines them and the tolerance below a claimed order.
ONE_STEP: dict[str, tuple[Callable[[Scheme, Problem, Problem], Iterator[Seen]], float]] = {
    Strong.name: (_strong, STRONG_TOLERANCE),
    Weak.name: (_weak, WEAK_TOLERANCE),
}
