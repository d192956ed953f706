"""Observation of a scheme's claim on a problem, by one step or, if one step does not decide, by a few paths."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Claim, Problem, Scheme, verify
from sdaeverify.errors import FAULTS
from sdaeverify.measuring import Finding, Measure, Order, Reason, Verdict
from sdaeverify.studying import DEEP_PATHS, ProblemSpec, plan, violation

from .pilot import growth
from .strategies.example import NAME

# Number of paths for measures that use only paths, and the confidence of their refutations.
FEW, CONFIDENCE = 64, 0.9999
# Least value of a goal that is not rounding, from which hypothesis maximises it.
CLIMB = 0.02
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
    followed : mapping of str to str
        As in `Registry`: `Measure.follows` by name of the measure.
    """

    scheme: Scheme
    measure: Measure
    form: str
    followed: Mapping[str, str]


class Observation(NamedTuple):
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


def observe(target: Target, function: Callable[..., Problem], ways: Sequence[str] = WAYS) -> Observation | None:
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
            (planned,) = plan([target.scheme], [ProblemSpec(NAME, function)], [target.measure]).problems
            view = next((cell.seen for cell in planned.runnable), None)
            if view is None or not _claims(target, view):
                return None
            problems = planned.problem or view, view
            seen = _by_orders(target, function, problems) if ORDERS in ways else _claimed(target, view)
            if seen is None or seen.refuted or STEPS not in ways:
                return seen
            broken = violation(target.scheme, view, followed=target.followed)
            if broken:
                return seen._replace(refuted=Reason(broken).sentence, verified=False, way=STEPS)
            return seen._replace(growth=growth(target.scheme, view))
        except FAULTS:
            # Numbers for which a step raises are not a usable example.
            return None


def _claimed(target: Target, view: Problem) -> Observation:
    claims = _claims(target, view)
    return Observation(claims[0], claims=claims)


def _claims(target: Target, view: Problem) -> tuple[str, ...]:
    """Return the claims about the measure that apply to a problem."""
    own = (claim for claim in target.scheme.promises if claim.measure == target.measure.name)
    return _distinct(str(claim) for claim in own if claim.when <= view.traits)


def _distinct(claims: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(claims))


def _by_orders(
    target: Target, function: Callable[..., Problem], problems: tuple[Problem, Problem]
) -> Observation | None:
    scheme, measure, *_ = target
    if not by_one_step(measure):
        return _along_paths(scheme, function, measure, FEW)
    seen = list(measure.judge_step(scheme, *problems))
    return _worst(seen) if seen else _along_paths(scheme, function, measure, DEEP_PATHS)


def by_one_step(measure: Measure) -> bool:
    """Return whether one step decides claims about a measure."""
    return type(measure).judge_step is not Measure.judge_step


def _worst(seen: list[Finding]) -> Observation:
    """Return the refuted claim, or else the first one with the largest distance of any order below its claim."""
    distances = [_distance(finding.claim, finding.estimate) for finding in seen]
    farthest = max((each for each in distances if np.isfinite(each)), default=nan)
    claims = _distinct(str(finding.claim) for finding in seen)
    for finding in seen:
        if finding.verdict is Verdict.REFUTED:
            return Observation(str(finding.claim), finding.reason.sentence, farthest, way=ORDERS, claims=claims)
    verified = all(finding.verdict is Verdict.VERIFIED for finding in seen)
    return Observation(claims[0], "", farthest, verified, claims=claims)


def _distance(claim: Claim | None, order: float) -> float:
    return claim.value.least - order if claim is not None and isinstance(claim.value, Order) else nan


def _along_paths(
    scheme: Scheme, function: Callable[..., Problem], measure: Measure, paths: int
) -> Observation | None:
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
    return Observation(worst["claim"], refuted, float(slower), verified, way=way, claims=claims)
