"""The policy of a gate: the table ``[tool.sdaeverify]`` of a project's pyproject.toml."""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..contracts.labels import did_you_mean
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings
from ..contracts.specs import ProblemSpec
from ..errors import UsageError
from ..forms import Problem
from .expected import ExpectedFailure
from .policy_table import read_table
from .tiers import TIERS

FILE = "pyproject.toml"
LOCK = "sdaeverify.lock"
PASS, FAIL = "pass", "fail"
# Below, 1 - alpha has no digits left to tell alpha from.
LEAST_ALPHA = 1e-12


@dataclass(frozen=True, kw_only=True)
class Policy:
    """What is gated, and what fails the gate.

    Attributes
    ----------
    schemes : tuple of str or Scheme
        Patterns and schemes; empty for those that `distribution` registers, or everything if it registers none.
    problems : tuple of str, ProblemSpec or callable
        Patterns, recipes and problem functions; empty for all that are not marked as run on request.
    measures : tuple of str or Measure
        Patterns and measures; empty for all.
    plugins : tuple of str
        Plugin files, absolute.
    alpha : float
        Probability of any false refutation in a run, from 1e-12 on.
    tier : str
        A name of `tiers.TIERS`.
    seed : int
    inconclusive : str
        ``pass`` or ``fail``; empty for what the tier says.
    lock : str
        Lock file, relative to the folder of `file`.
    lock_named : bool
        Whether the policy names it, so that it must be there.
    timeout : float or None
        Seconds that a scheme may take on a block of paths; 0 for no limit, None for the default of a run.
    memory : int or None
        Bytes that each worker may take; 0 for no limit, None for the default of a run.
    level : int or None
        Of the conformance kit.
    expected_failures : tuple of ExpectedFailure
    file : Path or None
        Where the policy is from; None if there is no file.
    distribution : str
        Name of the project in that file.

    Raises
    ------
    UsageError
        If a value is out of its range.
    """

    schemes: tuple[str | Scheme, ...] = ()
    problems: tuple[str | ProblemSpec | Callable[..., Problem], ...] = ()
    measures: tuple[str | Measure, ...] = ()
    plugins: tuple[str, ...] = ()
    alpha: float = 0.01
    tier: str = "ci"
    seed: int = Settings().seed
    inconclusive: str = ""
    lock: str = LOCK
    lock_named: bool = False
    timeout: float | None = None
    memory: int | None = None
    level: int | None = None
    expected_failures: tuple[ExpectedFailure, ...] = ()
    file: Path | None = None
    distribution: str = ""

    def __post_init__(self) -> None:
        _require(LEAST_ALPHA <= self.alpha <= 0.5, "alpha", f"at least {LEAST_ALPHA:g} and at most 0.5", self.alpha)
        _require(0 <= self.seed < 2**63, "seed", "between 0 and 2^63 - 1", self.seed)
        hint = did_you_mean(self.tier, TIERS) if isinstance(self.tier, str) else ""
        _require(
            isinstance(self.tier, str) and self.tier in TIERS,
            "tier",
            f"one of {', '.join(TIERS)}",
            repr(self.tier),
            hint,
        )
        fits = self.inconclusive in {"", PASS, FAIL}
        _require(fits, "inconclusive", f"{PASS} or {FAIL}", repr(self.inconclusive))
        fits = self.timeout is None or 0.0 <= self.timeout < float("inf")
        _require(fits, "timeout", "a number of seconds, or 0 for no limit", self.timeout)
        fits = self.level is None or self.level >= 1
        _require(fits, "level", "a level of the conformance kit, from 1 on", self.level)
        # Said before anything is run: what is no lock file is never overwritten.
        fits = Path(self.lock).suffix not in {".toml", ".py"}
        _require(fits, "lock", f"a file of its own, such as {LOCK}", repr(self.lock))

    @property
    def fails_undecided(self) -> bool:
        """Whether a claim that stays undecided fails the gate."""
        return self.inconclusive == FAIL if self.inconclusive else TIERS[self.tier].fails_undecided

    @property
    def lock_file(self) -> Path:
        """The lock file, which need not exist."""
        return (self.file.parent if self.file else Path()) / self.lock


def read_policy(start: Path, config: Path | None = None) -> Policy:
    """Read the policy that holds in a folder.

    Parameters
    ----------
    start : Path
        The nearest pyproject.toml in this folder or above it counts, even if it has no table ``[tool.sdaeverify]``.
    config : Path, optional
        A file to be read instead.

    Returns
    -------
    Policy
        With its defaults where there is no file.

    Raises
    ------
    UsageError
        If the file cannot be read, a key is unknown or a value is not of its type or range; or if `config` is neither
        a policy nor a project.
    """
    file = config if config is not None else _nearest(start)
    if file is None:
        return Policy()
    data = _parsed(file)
    name = _table(data, "project", file).get("name", "")
    table = _table(_table(data, "tool", file), "sdaeverify", file)
    if config is not None and not table and not name:
        raise UsageError(f"--config expects a table [tool.sdaeverify] or [project], and there is neither in {file}")
    try:
        values = read_table(table, file.parent)
        return Policy(**values, file=file, distribution=name if isinstance(name, str) else "")
    except UsageError as error:
        raise UsageError(f"{file}: [tool.sdaeverify]: {error}") from error


def _nearest(start: Path) -> Path | None:
    folder = start.resolve()
    return next((file for each in (folder, *folder.parents) if (file := each / FILE).is_file()), None)


def _parsed(file: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot read the policy {file}: {error.strerror or error}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file} is no TOML file: {error}") from error


def _table(data: Mapping[str, Any], key: str, file: Path) -> Mapping[str, Any]:
    value = data.get(key, {})
    if not isinstance(value, dict):
        raise UsageError(f"{file}: expected a table [{key}], got {value!r}")
    return value


def _require(condition: bool, name: str, expected: str, given: object, hint: str = "") -> None:
    if not condition:
        raise UsageError(f"{name} must be {expected}, got {given}{hint}")
