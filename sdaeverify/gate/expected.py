"""Expected failures: patterns of claims, in a policy or a test, and of checks of the conformance kit."""

from collections.abc import Iterable, Mapping
from typing import Annotated, Any, TypeVar

import msgspec

from ..contracts.labels import matches
from ..contracts.spelling import did_you_mean
from ..errors import UsageError, is_blank

Text = Annotated[str, msgspec.Meta(min_length=1)]
Validated = TypeVar("Validated", bound=msgspec.Struct)


class ExpectedFailure(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Pattern of labels for which a failure is expected.

    Attributes
    ----------
    reason : str
        Why the failure is expected; shown with every match.
    scheme, problem : str
        Globs of labels, in which only ``*`` and ``?`` are special.
    strict : bool
        Whether a match that passes is a failure.

    Raises
    ------
    UsageError
        If there is no reason.
    """

    reason: Text
    scheme: Text = "*"
    problem: Text = "*"
    strict: bool = True

    def __post_init__(self) -> None:
        if is_blank(self.reason):
            raise UsageError(f"the expected failure {self} has no reason; say why it is expected")

    def matches(self, **names: str) -> bool:
        """Return whether each given name matches the glob of its field."""
        return all(matches(getattr(self, kind), name) for kind, name in names.items())

    def __str__(self) -> str:
        globs = (name for name in self.__struct_fields__ if name not in {"reason", "strict"})
        return ", ".join(f"{name}={glob}" for name in globs if (glob := getattr(self, name)) != "*") or "everything"


class FailingClaim(ExpectedFailure, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Pattern of findings; a step that raises, hangs, dies or breaks its contract is not excused by it.

    Attributes
    ----------
    measure, quantity : str
        Globs of names.
    """

    measure: Text = "*"
    quantity: Text = "*"


class FailingCheck(ExpectedFailure, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Pattern of checks of the conformance kit.

    Attributes
    ----------
    check : str
        Glob of the name of the check.
    """

    check: Text = "*"


Pattern = TypeVar("Pattern", bound=ExpectedFailure)


def read_expected(given: Any, kind: type[Pattern]) -> tuple[Pattern, ...]:
    """Validate expected failures, given as patterns or as mappings with their fields.

    Parameters
    ----------
    given : sequence of mapping, or None
        None if no failure is expected.
    kind : type
        `FailingClaim` or `FailingCheck`.

    Raises
    ------
    UsageError
        If an entry has no reason, an unknown field, or a value of the wrong type.
    """
    entries = [given] if isinstance(given, str) or not isinstance(given, Iterable) else list(given)
    return tuple(_read(entry, kind) for entry in ([] if given is None else entries))


def require_matches(expected: Iterable[ExpectedFailure], asked: Iterable[Mapping[str, str]], what: str) -> None:
    """Check that each expected failure matches at least one name, since an unmatched one hides a misspelling.

    Parameters
    ----------
    expected : iterable of ExpectedFailure
    asked : iterable of mapping of str to str
        All known names, each as keyword arguments of `ExpectedFailure.matches`.
    what : str
        Noun for a match, used in the message.

    Raises
    ------
    UsageError
        If an expected failure matches no name.
    """
    names = list(asked)
    for one in expected:
        if not any(one.matches(**each) for each in names):
            raise UsageError(f"the expected failure {one} matches no {what}{_hint(one, names)}")


def validate(data: object, kind: type[Validated]) -> Validated:
    """Return data, parsed from a file or given from Python, as a record of type `kind`.

    Raises
    ------
    UsageError
        If a value is invalid; the message names its path in `data`.
    """
    try:
        return msgspec.convert(data, kind)
    except msgspec.ValidationError as error:
        what, _, place = str(error).removeprefix("Object contains ").partition(" - at `$")
        path = place.strip(".`")
        # Expected failures are the only nested records.
        known = (FailingClaim if path else kind).__struct_encode_fields__
        listed = f"; known are {', '.join(known)}"
        hint = (did_you_mean(what.split("`")[1], known) or listed) if "unknown field" in what else ""
        raise UsageError(f"{path}: {what}{hint}" if path else f"{what}{hint}") from error


def _read(entry: Any, kind: type[Pattern]) -> Pattern:
    if isinstance(entry, kind):
        return entry
    if not isinstance(entry, Mapping):
        raise UsageError(f"expected_failures expects a sequence of mappings, each with a reason, got {entry!r} in it")
    try:
        return validate(dict(entry), kind)
    except UsageError as error:
        raise UsageError(f"the expected failure {dict(entry)}: {error}") from error


def _hint(one: ExpectedFailure, names: list[Mapping[str, str]]) -> str:
    for kind in dict.fromkeys(kind for each in names for kind in each):
        known = sorted({each[kind] for each in names})
        if not any(matches(getattr(one, kind), name) for name in known):
            return did_you_mean(getattr(one, kind), known)
    return ""
