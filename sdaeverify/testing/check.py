"""A named check of the conformance kit, and its result on a subject."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contracts.finding import Status
from ..errors import FAULTS, SdaeverifyError, one_line

# Newest level of the kit. A plugin that names an older level is exempt from newer checks.
LEVEL = 2


class Inapplicable(Exception):  # noqa: N818 - nothing is wrong
    """Raised by a check that does not apply to its subject; the message is the reason."""


@dataclass(frozen=True)
class Check:
    """A check of the kit.

    Attributes
    ----------
    name : str
        Lower case with hyphens; unique among the checks of schemes, or of problems.
    category : str
        ``api``, ``behaviour`` or ``truths``.
    since : int
        Level of the kit that introduced the check.
    function : callable, subject -> str
        Returns the fault in one line, or an empty string. Its docstring states the expectation and the reason.
    each_problem : bool
        Whether the check of a scheme is repeated on each problem.
    """

    name: str
    category: str
    since: int
    function: Callable[[Any], str]
    each_problem: bool = False

    @property
    def question(self) -> str:
        """The expectation in one line, from the docstring of `function`."""
        return (self.function.__doc__ or "").strip().partition("\n")[0]


def run_check(check: Check, subject: Any) -> tuple[Status, str, float]:
    """Run a check on a subject; every exception counts as a failure.

    Parameters
    ----------
    check : Check
    subject : object
        Argument of the check's function.

    Returns
    -------
    Status
        ``passed``, ``failed`` or ``skipped``.
    str
        Reason of a failure or a skip.
    float
        Elapsed time in seconds.
    """
    begun = time.perf_counter()
    try:
        # Values that are not finite are evidence, which the checks themselves examine.
        with np.errstate(all="ignore"):
            reason = check.function(subject)
        status = Status.FAILED if reason else Status.PASSED
    except Inapplicable as words:
        status, reason = Status.SKIPPED, str(words)
    except FAULTS as error:
        # Errors of the framework already say who raised what.
        told = one_line(error) if isinstance(error, SdaeverifyError) else f"raises {one_line(error)}"
        status, reason = Status.FAILED, told
    return status, reason, time.perf_counter() - begun


def error_text(call: Callable[..., object], *arguments: object) -> str:
    """Return the message of the framework's error that a call raises, or an empty string."""
    try:
        call(*arguments)
    except SdaeverifyError as error:
        return str(error)
    return ""
