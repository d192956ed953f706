"""A named check of the conformance kit, and what becomes of it on one subject."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contracts.finding import Status
from ..errors import FAULTS, SdaeverifyError, one_line

# The newest level of the kit: a plugin that names an older one is not put to checks that are younger.
LEVEL = 2


class Inapplicable(Exception):  # noqa: N818 - nothing is wrong
    """Raised by a check that has nothing to ask of its subject; its text is the reason."""


@dataclass(frozen=True)
class Check:
    """One question of the kit.

    Attributes
    ----------
    name : str
        Lower case with hyphens; unique among the checks of schemes, or of problems.
    category : str
        ``api``, ``behaviour`` or ``truths``.
    since : int
        Level of the kit that it came with.
    function : callable, subject -> str
        Returns what is wrong in one line, or an empty string; its docstring says what it asks and why.
    each_problem : bool
        Whether a scheme is asked it on each problem by itself.
    """

    name: str
    category: str
    since: int
    function: Callable[[Any], str]
    each_problem: bool = False

    @property
    def question(self) -> str:
        """What it asks, in one line."""
        return (self.function.__doc__ or "").strip().partition("\n")[0]


def run_check(check: Check, subject: Any) -> tuple[Status, str, float]:
    """Put a check to a subject; whatever it raises is a failure.

    Parameters
    ----------
    check : Check
    subject : object
        What the check's function takes.

    Returns
    -------
    Status
        ``passed``, ``failed`` or ``skipped``.
    str
        The reason.
    float
        Seconds it took.
    """
    begun = time.perf_counter()
    try:
        # Numbers that are not finite are evidence here: a check looks for them where they matter.
        with np.errstate(all="ignore"):
            reason = check.function(subject)
        status = Status.FAILED if reason else Status.PASSED
    except Inapplicable as words:
        status, reason = Status.SKIPPED, str(words)
    except FAULTS as error:
        # What the framework raises is a sentence that says who raised what.
        told = one_line(error) if isinstance(error, SdaeverifyError) else f"raises {one_line(error)}"
        status, reason = Status.FAILED, told
    return status, reason, time.perf_counter() - begun


def error_text(call: Callable[..., object], *arguments: object) -> str:
    """Return what a call refuses its arguments for, or an empty string."""
    try:
        call(*arguments)
    except SdaeverifyError as error:
        return str(error)
    return ""
