"""Checks of what a scheme says of itself: nothing is run."""

import dataclasses
import pickle

from ...contracts.labels import dataclass_parameters, did_you_mean, parse_label, read_values
from ...contracts.specs import check_scheme
from ...errors import SdaeverifyError
from ...forms import unknown_traits
from ..check import Inapplicable
from ..subjects import SchemeSubject


def usable(subject: SchemeSubject) -> str:
    """Expect a frozen dataclass with a name, a form, claims, and parameters that a label can show."""
    try:
        check_scheme(subject.scheme)
    except SdaeverifyError as error:
        return str(error)
    return ""


def named_again(subject: SchemeSubject) -> str:
    """Expect the label to make the scheme again: the command that reproduces a result has nothing else."""
    scheme = subject.scheme
    parameters = dataclass_parameters(type(scheme))
    texts = parse_label(scheme.label).parameters or {}
    values = read_values(f"scheme {scheme.name!r}", parameters, texts)
    again = type(scheme)(**values)
    return "" if again == scheme else f"its label {scheme.label} makes another scheme, {again!r}"


def pickled(subject: SchemeSubject) -> str:
    """Expect an equal value after pickling: that is how worker processes get it."""
    scheme = subject.scheme
    copy = pickle.loads(pickle.dumps(scheme))
    if copy != scheme or hash(copy) != hash(scheme):
        return "its pickled copy is another value: compare and hash its parameters alone"
    return "" if copy.label == scheme.label else f"its pickled copy has the label {copy.label}"


def unchangeable(subject: SchemeSubject) -> str:
    """Expect a value that nobody can change: a step that changes its scheme depends on the order of calls."""
    scheme = subject.scheme
    for name in ("name", *(field.name for field in dataclasses.fields(scheme))):
        try:
            setattr(scheme, name, getattr(scheme, name))
        except dataclasses.FrozenInstanceError:
            continue
        return f"its attribute {name} can be set"
    return ""


def described(subject: SchemeSubject) -> str:
    """Expect a docstring of the class: a list of schemes shows its first line."""
    kind = type(subject.scheme)
    text = vars(kind).get("__doc__") or ""
    # A dataclass without docstring is given its signature.
    return "" if _says(text) and not text.startswith(f"{kind.__name__}(") else "its class has no docstring"


def sourced(subject: SchemeSubject) -> str:
    """Expect a source, of the scheme or of each of its claims: where it is from."""
    scheme = subject.scheme
    claims = [claim.source for claim in scheme.promises]
    known = _says(scheme.source) or (claims and all(map(_says, claims)))
    return "" if known else "its class variable source is empty, and so is a claim's, or there is none"


def claimed(subject: SchemeSubject) -> str:
    """Expect claims that can be verified: each has a source and names a known measure and known traits."""
    scheme, measures = subject.scheme, subject.registry.measures
    if not scheme.promises:
        raise Inapplicable("it claims nothing")
    for claim in scheme.promises:
        if claim.measure not in measures:
            return f"a claim is about measure {claim.measure!r}, unknown{did_you_mean(claim.measure, measures)}"
        if not _says(claim.source):
            return f"its claim of {claim.measure} {claim} has no source"
        if unknown := unknown_traits(claim.when):
            return f"its claim of {claim.measure} holds for unknown traits {', '.join(unknown)}"
    return ""


def _says(text: object) -> bool:
    return isinstance(text, str) and bool(text.strip())
