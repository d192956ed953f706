"""Verdicts on a scheme's claims about random members of its forms."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from math import inf, nan
from typing import NamedTuple

import numpy as np

from sdaeverify import Claim, Problem, Scheme
from sdaeverify.errors import FAULTS, one_line
from sdaeverify.measuring import Finding, Measure, Order, Verdict
from sdaeverify.studying import named_mistake, violation

from ..class_row import RANDOM_MEMBERS, ClassRow
from .classes import MemberClass, accepts, member_classes, member_of

# Members on which each claim is tested. One member shows every wrong coefficient with probability one; a second keeps
# the defect away from rounding. A refutation also needs two, since one draw may be near a degenerate equation.
MEMBERS = 2
# Of orders; further digits depend on the member.
DIGITS = 3


class Answer(NamedTuple):
    """The findings of one measure on several members.

    Attributes
    ----------
    findings : tuple of tuple of Finding
        For each member, its findings with a claim.
    """

    findings: tuple[tuple[Finding, ...], ...]

    @property
    def refuting(self) -> tuple[Finding, ...]:
        """The first refuted finding of each member that refutes a claim."""
        first = (next((each for each in own if each.verdict is Verdict.REFUTED), None) for own in self.findings)
        return tuple(each for each in first if each is not None)

    @property
    def open(self) -> Finding | None:
        """The first finding that is neither verified nor refuted."""
        flat = (each for own in self.findings for each in own)
        return next((each for each in flat if each.verdict not in {Verdict.VERIFIED, Verdict.REFUTED}), None)

    @property
    def held(self) -> int:
        """Number of members on which all claims are verified."""
        return sum(all(each.verdict is Verdict.VERIFIED for each in own) for own in self.findings)

    @property
    def order(self) -> float:
        """The order that exceeds its claim by the smallest amount; NaN if no claim is about an order."""
        found = ((each, claim.value) for own in self.findings for each in own if (claim := each.claim))
        orders = ((float(str(each.details.get("local_order", each.estimate))), value) for each, value in found)
        excess = [(order - value.least, order) for order, value in orders if isinstance(value, Order)]
        return round(min(excess, default=(nan, nan))[1], DIGITS) + 0.0


def member_rows(scheme: Scheme, kind: MemberClass, measures: Iterable[Measure], seed: int) -> Iterator[ClassRow]:
    """Yield the verdict on each measure's claims about a class.

    Parameters
    ----------
    scheme : Scheme
    kind : MemberClass
    measures : iterable of Measure
        Measures that cannot judge a member yield nothing.
    seed : int
        Of the run; it determines the members.
    """
    claims, measures = member_classes(scheme, seed).get(kind, ()), list(measures)
    followed = {measure.name: measure.follows for measure in measures}
    broken = cache(lambda: _broken(scheme, kind, followed, seed))
    for measure in measures:
        own = [claim for claim in claims if claim.measure == measure.name]
        with np.errstate(all="ignore"):
            answer = _ask(scheme, kind, measure, seed, range(MEMBERS)) if own else Answer(())
            if any(answer.findings):
                judged = _judge(scheme, kind, measure, seed, answer)
                judged = broken() or judged if judged[0] is Verdict.VERIFIED else judged
                row = _row(scheme, kind, own, answer, judged)
                member = member_of(kind, seed, 0)
                named = member_mistake(scheme, kind, member) if row.verdict is Verdict.REFUTED else ""
                yield replace(row, motions=member.noise_dim, mistake=named)


def _broken(scheme: Scheme, kind: MemberClass, followed: Mapping[str, str], seed: int) -> tuple[Verdict, str] | None:
    """Return the verdict and reason for a step that breaks its contract on members, or departs from their equations.

    The probes of measures make steps at nodes and few states. A verified claim also needs what a run needs first.
    """
    for member in (member_of(kind, seed, index) for index in range(MEMBERS)):
        # With a delay, the run that tests memory costs more than all other checks.
        run = member.recall(member.horizon / 64.0, 1) is None
        try:
            text = violation(scheme, member, followed=followed, run=run, motions=inf)
        except FAULTS as error:
            return Verdict.INCONCLUSIVE, f"a step on a random member raises {one_line(error)}"
        if not text:
            return None
    return Verdict.REFUTED, text


def refuting_class(scheme: Scheme, kind: MemberClass, measure: Measure, seed: int) -> MemberClass:
    """Return a minimal class of features that refutes a claim: omitting any one of them, the claim is not refuted.

    A feature is kept if the scheme refuses members without it.

    Parameters
    ----------
    scheme : Scheme
    kind : MemberClass
        A class on whose members a claim is refuted.
    measure : Measure
        Of the claim.
    seed : int
        Of the run.
    """
    with np.errstate(all="ignore"):
        for feature in kind.features:
            narrower = kind.narrowed(feature)
            if accepts(scheme, narrower, seed) and _ask(scheme, narrower, measure, seed, [0]).refuting:
                kind = narrower
    return kind


def _ask(scheme: Scheme, kind: MemberClass, measure: Measure, seed: int, indices: Sequence[int]) -> Answer:
    members = (member_of(kind, seed, index) for index in indices)
    found = (measure.judge_member(scheme, member) for member in members)
    return Answer(tuple(tuple(each for each in own if each.claim is not None) for own in found))


def _judge(scheme: Scheme, kind: MemberClass, measure: Measure, seed: int, answer: Answer) -> tuple[Verdict, str]:
    """Return the verdict on the claims of a measure, and its reason.

    If some but fewer than `MEMBERS` members refute a claim, one more member is tested.
    """
    refuting, asked = answer.refuting, len(answer.findings)
    if 0 < len(refuting) < MEMBERS:
        refuting, asked = (*refuting, *_ask(scheme, kind, measure, seed, [MEMBERS]).refuting), asked + 1
    if len(refuting) >= MEMBERS:
        needed = [kind.of.features[each] for each in refuting_class(scheme, kind, measure, seed).features]
        only = f"; only with {' and '.join(needed)}" if needed else ""
        return Verdict.REFUTED, f"{refuting[0].reason}{only}"
    if refuting:
        return Verdict.INCONCLUSIVE, f"1 of {asked} random members, possibly a degenerate one, refutes the claim"
    if answer.open is not None:
        return Verdict.INCONCLUSIVE, str(answer.open.reason)
    return Verdict.VERIFIED, f"{answer.held} of {asked} random members"


def _row(
    scheme: Scheme, kind: MemberClass, claims: Sequence[Claim], answer: Answer, judged: tuple[Verdict, str]
) -> ClassRow:
    verdict, reason = judged
    orders = {claim: claim.value.least for claim in claims if isinstance(claim.value, Order)}
    promise = max(orders, key=lambda claim: orders[claim], default=claims[0])
    return ClassRow(
        scheme.label,
        kind.name,
        0,
        promise.measure,
        verdict,
        order=answer.order,
        claim=orders.get(promise, nan),
        held=answer.held,
        of=len(answer.findings),
        premise=reason,
        promise=promise,
        conditions=RANDOM_MEMBERS,
    )


def member_mistake(scheme: Scheme, kind: MemberClass, member: Problem) -> str:
    """Return in a sentence which known mistake of a form explains a scheme's steps on a member, or an empty text.

    Parameters
    ----------
    scheme : Scheme
    kind : MemberClass
    member : Problem
        Of the class, in the scheme's form.
    """
    return named_mistake(scheme, member, kind.of.mistakes) if kind.of.mistakes else ""
