"""What one step, or where one step tells nothing a few paths, say of a scheme's claim on a problem."""

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

# Paths of measures that look at nothing but paths, and the confidence at which paths refute.
FEW, CONFIDENCE = 64, 0.9999
# A distance from claim to order that is more than rounding: from here on a search climbs.
CLIMB = 0.02
SETTINGS = Settings()
# Ways to refute a claim: by orders, or because the contract of a step or the equation at some state is broken.
WAYS = ORDERS, STEPS = "orders", "steps"


class Target(NamedTuple):
    """What is attacked.

    Attributes
    ----------
    scheme : Scheme
    measure : Measure
    form : str
        Of the examples.
    followed : Followed
        Names of the measures whose claims say that steps follow the equation.
    """

    scheme: Scheme
    measure: Measure
    form: str
    followed: Followed = NONE_FOLLOW


class Sight(NamedTuple):
    """What is seen of a claim on a problem.

    Attributes
    ----------
    claim : str
        The claim that is refuted, or else the first one that was looked at.
    refuted : str
        Why it is refuted, as a sentence; empty if it is not.
    distance : float
        By how much an order, of one step or along paths, is lower than claimed; NaN where none is known.
    verified : bool
        Whether all that is claimed is verified by what was looked at.
    growth : float
        log10 of how much a run of the scheme grows.
    way : str
        By which it is refuted, one of `WAYS`.
    claims : tuple of str
        All claims that were looked at.
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
        """What a search climbs on, by name: numbers that are more than rounding."""
        known = {"distance": self.distance, "growth": self.growth}
        return {name: value for name, value in known.items() if np.isfinite(value) and value > CLIMB}


# Of a claim: what is said of it, and the order that was found.
Seen = tuple[Claim, Opinion, float]


def applies(scheme: Scheme, problem: Problem, measure: Measure) -> Problem | None:
    """Return the view in which a measure's claim of a scheme is put to the test on a problem, or None.

    Parameters
    ----------
    scheme : Scheme
    problem : Problem
        As it was drawn.
    measure : Measure
        Whose claim it is.
    """
    view = match(scheme, problem).problem
    if view is None or measure.refuses(scheme, problem) or draws_own_numbers(scheme, view):
        return None
    scopes = (claim.when <= view.traits for claim in scheme.promises if claim.measure == measure.name)
    return view if any(scopes) else None


def look(target: Target, function: Callable[..., Problem], ways: Sequence[str] = WAYS) -> Sight | None:
    """Return what is seen of a claim, or None where there is none or the example is not of its kind.

    Parameters
    ----------
    target : Target
        A scheme, and the measure about which it claims something.
    function : callable
        The problem function of an example.
    ways : sequence of str
        Those of `WAYS` that are tried until one refutes.
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
            # Numbers that no step can be made with are no example of anything.
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
    """Return the refuted claim, or the one whose order is farthest below it."""
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
    # What raises, or is not run, says nothing of the claim: it does not count as looked at.
    if not len(claimed) or {str(Verdict.ERROR), str(Verdict.NOT_RUN)} & set(claimed["verdict"]):
        return None
    # The row of a refuted quantity is told, and else the first one.
    worst = claimed.sort_values("verdict", key=lambda given: given != str(Verdict.REFUTED), kind="stable").iloc[0]
    refuted = worst["reason"] if Verdict(worst["verdict"]) is Verdict.REFUTED else ""
    slower = (claimed["claimed_order"] - claimed["path_order"]).astype(float).max()
    verified = set(claimed["verdict"]) == {str(Verdict.VERIFIED)}
    way, claims = ORDERS if refuted else "", _distinct(claimed["claim"])
    return Sight(worst["claim"], refuted, float(slower), verified, way=way, claims=claims)


# Measures that one step tells enough of, with what it tells and how far below its claim an order may be.
ONE_STEP: dict[str, tuple[Callable[[Scheme, Problem, Problem], Iterator[Seen]], float]] = {
    Strong.name: (_strong, STRONG_TOLERANCE),
    Weak.name: (_weak, WEAK_TOLERANCE),
}
