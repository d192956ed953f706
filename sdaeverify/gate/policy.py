"""The policy of a gate: the table ``[tool.sdaeverify]`` of a project's pyproject.toml."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import structs

from ..contracts.settings import Settings, require
from ..contracts.spelling import did_you_mean
from ..errors import UsageError
from ..registry.sources import absolute_plugin, plugins_of_tables
from ..workers.limits import read_memory
from .expected import FailingClaim, Text, validate
from .tiers import TIERS, Tier

Texts = Annotated[tuple[Text, ...], msgspec.Meta(min_length=1)]


FILE = "pyproject.toml"
LOCK = "sdaeverify.lock"
PASS, FAIL = "pass", "fail"
# Duration of a hunt.
TIME, UNITS = re.compile(r"(\d+(?:\.\d+)?) ?(s|min|h)"), {"s": 1.0, "min": 60.0, "h": 3600.0}
# Below this value, alpha is lost to rounding in 1 - alpha.
LEAST_ALPHA = 1e-12


class PolicyTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, rename="kebab"):
    """Keys of the table ``[tool.sdaeverify]``; from Python, objects can be given instead of their names.

    Attributes
    ----------
    schemes : tuple of str or Scheme
        Patterns and schemes; if empty, those registered by `distribution` and `plugins`, or all without these.
    problems : tuple of str, ProblemSpec or callable
        Patterns, specifications and problem functions; if empty, all that are not run on request only.
    measures : tuple of str or Measure
        Patterns and measures; if empty, all.
    plugins : tuple of str
        Absolute paths of plugin files, and texts of sources, whose tables have their names.
    alpha : float
        Probability of any false refutation in a run, from 1e-12 on.
    tier : str
        A name of `tiers.TIERS`.
    seed : int
    inconclusive : str
        ``pass`` or ``fail`` for undecided claims; if empty, the default of the tier.
    lock : str
        Lock file, relative to the folder of `file`, which must exist; if empty, the default file, which need not.
    timeout : float or None
        Time limit in seconds of a scheme on a block of paths; 0 for no limit, None for the default of a run.
    memory : str
        Memory limit of each worker; ``0`` for no limit, empty for the default of a run.
    level : int or None
        Level of the conformance kit; None for the newest.
    resolution : float
        Largest error of the limit, as part of the quantity's size, that a verified claim may leave undetected;
        infinite for no such requirement.
    orders : bool
        Whether claims are also tested by the order conditions of classes of equations and by random members of forms,
        independently of `problems`.
    hunt : str
        Duration of the search for counterexamples at tier nightly, such as ``30 s`` or ``5 min``; if empty, there is
        no search.
    examinations : dict of str to dict
        Examinations of plugins by name, each with its table of options. Together with the cells they share `alpha`.
    expected_failures : tuple of FailingClaim
    """

    schemes: Texts = ()
    problems: Texts = ()
    measures: Texts = ()
    plugins: Texts = ()
    alpha: float = 0.01
    tier: Text = "ci"
    seed: int = Settings().seed
    inconclusive: Text = ""
    lock: Text = ""
    timeout: float | None = None
    memory: Text = ""
    level: int | None = None
    resolution: float = inf
    orders: bool = True
    hunt: Text = ""
    examinations: dict[str, dict[str, Any]] = msgspec.field(default_factory=dict)
    expected_failures: tuple[FailingClaim, ...] = ()


class Policy(PolicyTable, frozen=True, kw_only=True):
    """Policy of a gate: its table and the file that holds it.

    Attributes
    ----------
    file : Path or None
        File of the policy; None if there is no file.
    distribution : str
        Name of the project in that file.

    Raises
    ------
    UsageError
        If a value is out of its range.
    """

    file: Path | None = None
    distribution: str = ""

    def __post_init__(self) -> None:
        require(LEAST_ALPHA <= self.alpha <= 0.5, "alpha", f"at least {LEAST_ALPHA:g} and at most 0.5", self.alpha)
        require(0 <= self.seed < 2**63, "seed", "between 0 and 2^63 - 1", self.seed)
        hint = did_you_mean(self.tier, TIERS) if isinstance(self.tier, str) else ""
        known = isinstance(self.tier, str) and self.tier in TIERS
        require(known, "tier", f"one of {', '.join(TIERS)}", f"{self.tier!r}{hint}")
        fits = self.inconclusive in {"", PASS, FAIL}
        require(fits, "inconclusive", f"{PASS} or {FAIL}", repr(self.inconclusive))
        fits = self.timeout is None or 0.0 <= self.timeout < float("inf")
        require(fits, "timeout", "a number of seconds, or 0 for no limit", self.timeout)
        if self.memory not in {"", "0"}:
            read_memory("memory", self.memory)
        fits = self.level is None or self.level >= 1
        require(fits, "level", "a level of the conformance kit, from 1 on", self.level)
        require(self.resolution > 0.0, "resolution", "a positive fraction of a quantity's size", self.resolution)
        require(not self.hunt or self.hunt_seconds > 0.0, "hunt", "a time such as '30 s' or '5 min'", repr(self.hunt))
        # Checked before the run, because only a lock file may be overwritten.
        fits = Path(self.lock).suffix not in {".toml", ".py"}
        require(fits, "lock", f"a separate file, such as {LOCK}", repr(self.lock))

    @property
    def budget(self) -> Tier:
        """Tier named by `tier`."""
        return TIERS[self.tier]

    @property
    def settings(self) -> Settings:
        """Settings of the tier with the policy's seed; cells and each examination get an equal share of alpha."""
        share = self.alpha / (1 + len(self.examinations))
        return replace(self.budget.settings, seed=self.seed, confidence=1.0 - share)

    @property
    def hunt_seconds(self) -> float:
        """Duration of a hunt in seconds; 0 without a hunt or if the text is not a duration."""
        found = TIME.fullmatch(self.hunt)
        return float(found[1]) * UNITS[found[2]] if found else 0.0

    @property
    def fails_undecided(self) -> bool:
        """Whether an undecided claim fails the gate."""
        return self.inconclusive == FAIL if self.inconclusive else self.budget.fails_undecided

    @property
    def asks_classes(self) -> bool:
        """Whether claims are also tested by order conditions of classes and by random members of forms."""
        return self.orders

    @property
    def lock_file(self) -> Path:
        """Path of the lock file, which need not exist."""
        return (self.file.parent if self.file else Path()) / (self.lock or LOCK)


def read_policy(start: Path, config: Path | None = None) -> Policy:
    """Read the policy that applies to a folder.

    Parameters
    ----------
    start : Path
        The nearest pyproject.toml in this folder or above is used, even without a table ``[tool.sdaeverify]``.
    config : Path, optional
        File to read instead.

    Returns
    -------
    Policy
        Default policy if there is no file.

    Raises
    ------
    UsageError
        If the file cannot be read, a key is unknown or a value is out of its type or range; or if `config` has
        neither the table of a policy nor that of a project.
    """
    file = config if config is not None else _nearest(start)
    if file is None:
        return Policy()
    data = _parse_toml(file)
    name = _table(data, "project", file).get("name", "")
    table = _table(_table(data, "tool", file), "sdaeverify", file)
    if config is not None and not table and not name:
        raise UsageError(f"--config expects a table [tool.sdaeverify] or [project], and there is neither in {file}")
    folder = file.parent.absolute()
    try:
        own, made = plugins_of_tables(table, folder)
        values = structs.asdict(validate(own, PolicyTable))
        values["plugins"] = (*(absolute_plugin(each, folder) for each in values["plugins"]), *made)
        return Policy(**values, file=file, distribution=name if isinstance(name, str) else "")
    except UsageError as error:
        raise UsageError(f"{file}: [tool.sdaeverify]: {error}") from error


def _nearest(start: Path) -> Path | None:
    folder = start.resolve()
    return next((file for each in (folder, *folder.parents) if (file := each / FILE).is_file()), None)


def _parse_toml(file: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot read the policy {file}: {error.strerror or error}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file} is not a TOML file: {error}") from error


def _table(data: Mapping[str, Any], key: str, file: Path) -> Mapping[str, Any]:
    value = data.get(key, {})
    if not isinstance(value, dict):
        raise UsageError(f"{file}: expected a table [{key}], got {value!r}")
    return value
