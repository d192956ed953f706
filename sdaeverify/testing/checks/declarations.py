"""Checks of a scheme's declarations, and of its claims against the registry."""

import dataclasses
import pickle
from collections.abc import Iterator, Sequence

import numpy as np

from ...contracts.claimed import Word
from ...contracts.labels import dataclass_parameters, parse_label, read_values
from ...contracts.matching import match
from ...contracts.scheme import Claim, is_text
from ...contracts.settings import Settings
from ...contracts.specs import ProblemSpec, check_scheme
from ...contracts.spelling import did_you_mean
from ...errors import FAULTS
from ...forms import components
from ...gate.untested import known_quantities, unknown_quantities, unknown_words
from ...study import CellResult, Study, plan
from ..check import Inapplicable, error_text
from ..subjects import SchemeSubject

# The smallest sample, because names of quantities do not depend on it.
SMALLEST = Settings(paths=40, levels=3, max_looks=1)
# Largest number of problems searched for the quantities of a claim.
FEW = 3


def check_usable(subject: SchemeSubject) -> str:
    """Expect a frozen dataclass with a name, a form, claims, and parameters that a label can represent."""
    return error_text(check_scheme, subject.scheme)


def check_label(subject: SchemeSubject) -> str:
    """Expect the label to recreate the scheme, because commands that reproduce results contain only the label."""
    scheme = subject.scheme
    parameters = dataclass_parameters(type(scheme))
    texts = parse_label(scheme.label).parameters or {}
    values = read_values(f"scheme {scheme.name!r}", parameters, texts)
    again = type(scheme)(**values)
    return "" if again == scheme else f"its label {scheme.label} makes another scheme, {again!r}"


def check_pickling(subject: SchemeSubject) -> str:
    """Expect an equal value after pickling, because worker processes receive a pickled copy."""
    scheme = subject.scheme
    copy = pickle.loads(pickle.dumps(scheme))
    if copy != scheme or hash(copy) != hash(scheme):
        return "its pickled copy is another value: compare and hash its parameters alone"
    return "" if copy.label == scheme.label else f"its pickled copy has the label {copy.label}"


def check_frozen(subject: SchemeSubject) -> str:
    """Expect an immutable value: a step that changes its scheme depends on the order of calls."""
    scheme = subject.scheme
    for name in ("name", *(field.name for field in dataclasses.fields(scheme))):
        try:
            setattr(scheme, name, getattr(scheme, name))
        except dataclasses.FrozenInstanceError:
            continue
        return f"its attribute {name} can be set"
    return ""


def check_docstring(subject: SchemeSubject) -> str:
    """Expect a docstring of the class, because lists of schemes show its first line."""
    kind = type(subject.scheme)
    text = vars(kind).get("__doc__") or ""
    # dataclasses replaces a missing docstring by the signature.
    return "" if is_text(text) and not text.startswith(f"{kind.__name__}(") else "its class has no docstring"


def check_source(subject: SchemeSubject) -> str:
    """Expect a source of the scheme, or a claim, which always has one."""
    known = is_text(subject.scheme.source) or subject.scheme.promises
    return "" if known else "its class variable source is empty, and it claims nothing that would have one"


def check_claims(subject: SchemeSubject) -> str:
    """Expect claims that can be verified: each names a known measure and known traits."""
    scheme, measures = subject.scheme, subject.registry.measures
    if not scheme.promises:
        raise Inapplicable("it claims nothing")
    for claim in scheme.promises:
        if claim.measure not in measures:
            return f"a claim is about measure {claim.measure!r}, unknown{did_you_mean(claim.measure, measures)}"
    return ""


def check_claims_tested(subject: SchemeSubject) -> str:
    """Expect each claim to apply to a registered problem, and its quantities to be measured there."""
    known = [claim for claim in subject.scheme.promises if claim.measure in subject.registry.measures]
    if not known:
        raise Inapplicable("it claims nothing of a known measure")
    return "; ".join(text for claim in known for text in _why_not_tested(subject, claim))


def _why_not_tested(subject: SchemeSubject, claim: Claim) -> Iterator[str]:
    what = f"its claim of {claim.measure} {claim}"
    specs = _in_scope(subject, claim)
    if not specs:
        where = f" with {', '.join(sorted(claim.when))}" if claim.when else ""
        yield f"{what} holds on no registered problem{where}"
    elif not subject.registry.measures[claim.measure].thing.lengthy:
        found, word = set[str](), isinstance(claim.value, Word)
        for spec in specs[:FEW]:
            if found.issuperset(claim.quantities) and not word:
                return
            results, word = _results(subject, claim, spec), False
            if why := unknown_words(claim, results):
                yield f"{what} is not tested: {why}"
                return
            found |= _quantities(claim, results)
        yield from (f"{what} is not tested: {why}" for _, why in unknown_quantities(claim, found))


def _in_scope(subject: SchemeSubject, claim: Claim) -> list[ProblemSpec]:
    """Return the problems to which a claim applies, smallest first; those run on request only as a fallback."""
    entries = subject.registry.problems.values()
    for on_request in (False, True):
        specs = [spec for entry in entries if entry.on_request is on_request for spec in entry.variants]
        found = [(size, spec.label, spec) for spec in specs if (size := _size(subject, claim, spec))]
        if found:
            return [spec for *_, spec in sorted(found, key=lambda each: each[:2])]
    return []


def _size(subject: SchemeSubject, claim: Claim, spec: ProblemSpec) -> int:
    """Return the number of components of a problem to which a claim applies; 0 if it does not."""
    measure = subject.registry.measures[claim.measure].thing
    try:
        with np.errstate(all="ignore"):
            problem = spec.build()
            view = match(subject.scheme, problem).problem
            holds = view is not None and claim.when <= view.traits and not measure.refuses(subject.scheme, problem)
            return components(view) if view is not None and holds else 0
    except FAULTS:
        # A broken problem is reported by its own checks.
        return 0


def _results(subject: SchemeSubject, claim: Claim, spec: ProblemSpec) -> list[CellResult]:
    made = plan(
        [subject.scheme], [spec], [subject.registry.measures[claim.measure].thing], followed=subject.registry.followed
    )
    study = Study(made, SMALLEST)
    for _ in study.run():
        pass
    return study.results()


def _quantities(claim: Claim, results: Sequence[CellResult]) -> set[str]:
    # A scheme that fails as a whole fails other checks, and its quantities are unknown.
    whole = any(not finding.quantity for result in results for finding in result.findings)
    return set(claim.quantities) if whole else known_quantities(results)
