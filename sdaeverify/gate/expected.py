"""Failures that are expected: the same language for claims, in a policy or a test, and for checks of the kit."""

from collections.abc import Iterable, Mapping
from typing import Annotated, Any, TypeVar

import msgspec

from ..contracts.labels import matches
from ..contracts.spelling import did_you_mean
from ..errors import UsageError, is_blank

Text = Annotated[str, msgspec.Meta(min_length=1)]
Validated = TypeVar("Validated", bound=msgspec.Struct)


class ExpectedFailure(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A pattern of what is expected to fail.

    Attributes
    ----------
    reason : str
        Why; it is shown with everything that matches.
    scheme, problem : str
        Globs of labels, in which ``*`` and ``?`` alone are special.
    strict : bool
        Whether it is a failure that something matches and passes.

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
        """Tell whether something is meant that has these names: a field of the pattern each."""
        return all(matches(getattr(self, kind), name) for kind, name in names.items())

    def __str__(self) -> str:
        globs = (name for name in self.__struct_fields__ if name not in {"reason", "strict"})
        return ", ".join(f"{name}={glob}" for name in globs if (glob := getattr(self, name)) != "*") or "everything"


class FailingClaim(ExpectedFailure, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A pattern of findings; a step that raises, hangs, dies or breaks its contract fails all the same.

    Attributes
    ----------
    measure, quantity : str
        Globs of names.
    """

    measure: Text = "*"
    quantity: Text = "*"


class FailingCheck(ExpectedFailure, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A pattern of checks of the conformance kit.

    Attributes
    ----------
    check : str
        Glob of the name.
    """

    check: Text = "*"


Pattern = TypeVar("Pattern", bound=ExpectedFailure)


def read_expected(given: Any, kind: type[Pattern]) -> tuple[Pattern, ...]:
    """Return the expected failures that an author gives: patterns, or mappings with their fields.

    Parameters
    ----------
    given : sequence of mapping, or None
        None for no expected failure.
    kind : type
        `FailingClaim` or `FailingCheck`.

    Raises
    ------
    UsageError
        If one has no reason, an unknown field, or a value that is none of the field.
    """
    entries = [given] if isinstance(given, str) or not isinstance(given, Iterable) else list(given)
    return tuple(_read(entry, kind) for entry in ([] if given is None else entries))


def require_matches(expected: Iterable[ExpectedFailure], asked: Iterable[Mapping[str, str]], what: str) -> None:
    """Check that each expected failure means something: one of nothing hides a misspelt name.

    Parameters
    ----------
    expected : iterable of ExpectedFailure
    asked : iterable of mapping of str to str
        Names of all that there is, as `ExpectedFailure.matches` takes them.
    what : str
        One of these, in words.

    Raises
    ------
    UsageError
        If one means nothing.
    """
    names = list(asked)
    for one in expected:
        if not any(one.matches(**each) for each in names):
            raise UsageError(f"the expected failure {one} matches no {what}{_hint(one, names)}")


def validate(data: object, kind: type[Validated]) -> Validated:
    """Return data, as it is parsed from a file or given by an author, as a record.

    Raises
    ------
    UsageError
        That names the path of what is wrong in `data`.
    """
    try:
        return msgspec.convert(data, kind)
    except msgspec.ValidationError as error:
        what, _, place = str(error).partition(" - at `$")
        path = place.strip(".`")
        # Nothing but expected failures is nested.
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
