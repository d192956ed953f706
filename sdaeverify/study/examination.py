"""What a gate counts beside the cells of a study: results that a plugin finds by means of its own.

A plugin registers examinations by the hook ``sdaeverify_examinations``; a policy asks for one by its name, with a
table of its own::

    [tool.sdaeverify.examinations.adaptive]
    solvers = ["my-heun"]
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from typing import Any, ClassVar, Protocol

from ..contracts.settings import Settings
from ..contracts.spelling import did_you_mean
from ..errors import UsageError
from ..registry.load import Registry
from .judging import CellResult
from .run import Advanced

HOOK = "sdaeverify_examinations"


class Work(Protocol):
    """An examination under way."""

    @property
    def total(self) -> int:
        """Number of its jobs."""

    def run(self, executor: Executor | None = None, window: int = 1) -> Iterator[Advanced]:
        """Do them, on an executor if there is one, with so many jobs sent ahead as `window` says."""

    @property
    def results(self) -> list[CellResult]:
        """What was found, family-wise errors corrected at the confidence of its settings."""

    @property
    def command(self) -> tuple[str, ...]:
        """Words of the command that finds a result again, with ``{scheme}`` and ``{problem}`` for its labels."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What else is worth a line: what was asked for and cannot be examined."""


class Examination(ABC):
    """Base of what a plugin examines by means of its own: a subclass sets its name and writes `begin`.

    Attributes
    ----------
    name : str
        Of its table in the policy.
    """

    name: ClassVar[str]

    @abstractmethod
    def begin(self, registry: Registry, asked: Mapping[str, Any], settings: Settings) -> Work:
        """Return the work.

        Parameters
        ----------
        registry : Registry
        asked : mapping of str to object
            The table of the policy.
        settings : Settings
            Seed and confidence of the gate; its sample size and step sizes are those of schemes.

        Raises
        ------
        UsageError
            If the table asks for what there is not.
        """


def begin_all(registry: Registry, asked: Mapping[str, Mapping[str, Any]], settings: Settings) -> list[Work]:
    """Return the examinations that a policy asks for.

    Parameters
    ----------
    registry : Registry
    asked : mapping of str to mapping
        By name, the table of each.
    settings : Settings

    Raises
    ------
    UsageError
        If a name is unknown, or a table asks for what there is not.
    """
    known = registry.things(HOOK)
    if unknown := next((name for name in asked if name not in known), ""):
        listed = f" (known: {', '.join(known)})" if known else ""
        raise UsageError(f"no examination is named {unknown}{did_you_mean(unknown, known)}{listed}")
    return [known[name].begin(registry, table, settings) for name, table in asked.items()]
