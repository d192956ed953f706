"""Hunts as tests with the marker ``hunt``: a search for counterexamples to the claims of each scheme.

Register the marker ``hunt`` with pytest, so that the quick run of a project can exclude hunts::

    [tool.pytest.ini_options]
    addopts = ["-m", "not hunt"]
    markers = ["hunt: counterexamples are looked for, run with -m hunt"]
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from sdaeverify import Scheme, UsageError
from sdaeverify.commands import visible
from sdaeverify.studying import load_registry, select_schemes

from .hunting import hunt
from .options import read_options

if TYPE_CHECKING:
    import pytest

# Name of the marker, and default duration of a hunt per scheme in minutes.
MARKER, MINUTES = "hunt", 0.5


class CounterexampleError(AssertionError):
    """A claim does not hold on a random problem."""


@dataclass(frozen=True)
class HuntCheck:
    """Hunt of a scheme, as a parameter of a test.

    Attributes
    ----------
    options : mapping
        Options of the hunt.
    """

    sdaeverify_part: ClassVar[str] = "hunts"

    options: Mapping[str, Any]

    def __call__(self, subject: Scheme) -> None:
        """Raise if a counterexample is found and confirmed.

        Raises
        ------
        CounterexampleError
            If a claim is refuted on a random problem, and again by a run on its plugin file, whose text ends the
            message.
        """
        __tracebackhide__ = True
        report = hunt(subject, **self.options)
        if report.found:
            told = [visible(attack.outcome) for attack in report.found]
            raise CounterexampleError("\n".join([*told, "", report.found[0].example.source]))  # type: ignore[union-attr]

    def __repr__(self) -> str:
        return "hunt"


def parametrize_with_hunts(schemes: Sequence[str | Scheme], **options: Any) -> "pytest.MarkDecorator":
    """Return a decorator for a test function of ``subject`` and ``check`` that runs a hunt for each scheme.

    ::

        @parametrize_with_hunts([MyScheme()], minutes=2.0)
        def test_no_counterexample(subject, check):
            check(subject)

    Parameters
    ----------
    schemes : sequence of Scheme or str
        Schemes, and patterns of registered schemes.
    **options
        As in `hunt`; half a minute for each scheme if neither ``minutes`` nor ``examples`` is given. With
        ``examples`` the outcome does not depend on the speed of the machine.

    Returns
    -------
    pytest.MarkDecorator

    Raises
    ------
    UsageError
        If no scheme is named, a name is unknown, or an option is wrong.
    """
    import pytest  # noqa: PLC0415 - the kit itself needs no pytest

    if not schemes:
        raise UsageError("schemes is empty; name the schemes that are to be hunted")
    timed = options if {"minutes", "examples"} & set(options) else {**options, "minutes": MINUTES}
    # Check the options at collection, before any test runs.
    read_options(timed)
    found = select_schemes(load_registry(), schemes)
    marks = getattr(pytest.mark, MARKER)
    cases = [pytest.param(scheme, HuntCheck(timed), id=visible(scheme.label), marks=marks) for scheme in found]
    return pytest.mark.parametrize(("subject", "check"), cases)
