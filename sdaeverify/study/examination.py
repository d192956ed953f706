"""Examinations: results that a plugin finds by its own means and a gate counts in addition to the cells of a study.

A plugin registers examinations by the hook ``sdaeverify_examinations``; a policy requests one by its name, with its
own table::

    [tool.sdaeverify.examinations.adaptive]
    solvers = ["my-heun"]
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from ..contracts.settings import Settings
from ..contracts.spelling import did_you_mean
from ..errors import UsageError
from ..registry.load import Registry
from .judging import CellResult
from .run import Advanced

HOOK = "sdaeverify_examinations"


class Work(Protocol):
    """An examination in progress."""

    @property
    def total(self) -> int:
        """Number of its jobs."""

    def run(self, executor: Executor | None = None, window: int = 1) -> Iterator[Advanced]:
        """Do the jobs, on an executor if there is one, with at most `window` jobs submitted ahead."""

    @property
    def results(self) -> list[CellResult]:
        """Results, with family-wise errors corrected at the confidence of the settings."""

    @property
    def command(self) -> tuple[str, ...]:
        """Words of the command that reproduces a result, with ``{scheme}`` and ``{problem}`` for its labels."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks, one line each, such as requested items that cannot be examined."""


@dataclass(frozen=True)
class Completed:
    """Results that were found by other means, as a completed examination.

    Attributes
    ----------
    results : list of CellResult
    command : tuple of str
        Words of the command that reproduces a result, with ``{scheme}``, ``{problem}`` and ``{measure}``.
    notes : tuple of str
    """

    results: list[CellResult]
    command: tuple[str, ...]
    notes: tuple[str, ...] = ()
    total: ClassVar[int] = 0

    def run(self, executor: Executor | None = None, window: int = 1) -> Iterator[Advanced]:  # noqa: ARG002
        """Do nothing, because the examination is complete."""
        yield from ()


class Examination(ABC):
    """Base of the examinations of a plugin: a subclass sets its name and writes `begin`.

    Attributes
    ----------
    name : str
        Name of its table in the policy.
    """

    name: ClassVar[str]

    @abstractmethod
    def begin(self, registry: Registry, asked: Mapping[str, Any], settings: Settings) -> Work:
        """Return the examination as `Work`, not yet started.

        Parameters
        ----------
        registry : Registry
        asked : mapping of str to object
            The table of the policy.
        settings : Settings
            Seed and confidence of the gate; its sample size and step sizes apply to schemes only.

        Raises
        ------
        UsageError
            If the table requests something that does not exist.
        """


def begin_all(registry: Registry, asked: Mapping[str, Mapping[str, Any]], settings: Settings) -> list[Work]:
    """Return the examinations that a policy requests.

    Parameters
    ----------
    registry : Registry
    asked : mapping of str to mapping
        The table of each examination, by name.
    settings : Settings

    Raises
    ------
    UsageError
        If a name is unknown, or a table requests something that does not exist.
    """
    known = registry.things(HOOK)
    if unknown := next((name for name in asked if name not in known), ""):
        listed = f" (known: {', '.join(known)})" if known else ""
        raise UsageError(f"no examination is named {unknown}{did_you_mean(unknown, known)}{listed}")
    return [known[name].begin(registry, table, settings) for name, table in asked.items()]
