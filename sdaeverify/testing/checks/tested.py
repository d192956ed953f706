"""The check of claims against what there is: a claim that nothing can test is green for nothing."""

from collections.abc import Iterator

import numpy as np

from ...contracts.matching import match
from ...contracts.scheme import Claim
from ...contracts.settings import Settings
from ...contracts.specs import ProblemSpec
from ...errors import FAULTS
from ...forms import components
from ...gate.untested import known_quantities, unknown_quantities
from ...study import Study, plan
from ..check import Inapplicable
from ..subjects import SchemeSubject

# Names of quantities do not depend on the sample: the smallest there is.
SMALLEST = Settings(paths=40, levels=3, looks=1)
# Problems on which the quantities of a claim are looked for.
FEW = 3


def tested(subject: SchemeSubject) -> str:
    """Expect each claim to hold on a registered problem, and its quantities to be measured there."""
    known = [claim for claim in subject.scheme.promises if claim.measure in subject.registry.measures]
    if not known:
        raise Inapplicable("it claims nothing of a known measure")
    return "; ".join(text for claim in known for text in _untested(subject, claim))


def _untested(subject: SchemeSubject, claim: Claim) -> Iterator[str]:
    what = f"its claim of {claim.measure} {claim}"
    specs = _in_scope(subject, claim)
    if not specs:
        where = f" with {', '.join(sorted(claim.when))}" if claim.when else ""
        yield f"{what} holds on no registered problem{where}"
    elif not subject.registry.measures[claim.measure].measure.lengthy:
        found: set[str] = set()
        for spec in specs[:FEW]:
            if found.issuperset(claim.quantities):
                return
            found |= _quantities(subject, claim, spec)
        yield from (f"{what} is not tested: {why}" for _, why in unknown_quantities(claim, found))


def _in_scope(subject: SchemeSubject, claim: Claim) -> list[ProblemSpec]:
    """Return the problems where a claim holds, the smallest first; those on request if there are no others."""
    entries = subject.registry.problems.values()
    for on_request in (False, True):
        specs = [entry.make() for entry in entries if entry.on_request is on_request]
        found = [(size, spec.label, spec) for spec in specs if (size := _size(subject, claim, spec))]
        if found:
            return [spec for *_, spec in sorted(found, key=lambda each: each[:2])]
    return []


def _size(subject: SchemeSubject, claim: Claim, spec: ProblemSpec) -> int:
    """Return the number of components of a problem where a claim holds; 0 where it does not."""
    measure = subject.registry.measures[claim.measure].measure
    try:
        with np.errstate(all="ignore"):
            problem = spec.build()
            view = match(subject.scheme, problem).problem
            holds = view is not None and claim.when <= view.traits and not measure.refuses(subject.scheme, problem)
            return components(view) if view is not None and holds else 0
    except FAULTS:
        # Somebody else's problem is broken: that is found out where it is checked itself.
        return 0


def _quantities(subject: SchemeSubject, claim: Claim, spec: ProblemSpec) -> set[str]:
    made = plan([subject.scheme], [spec], [subject.registry.measures[claim.measure].measure])
    study = Study(made, SMALLEST)
    for _ in study.run():
        pass
    results = study.results()
    # A scheme that fails as a whole fails other checks; of its quantities nothing is known.
    whole = any(not finding.quantity for result in results for finding in result.findings)
    return set(claim.quantities) if whole else known_quantities(results)
