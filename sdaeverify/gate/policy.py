"""A gate's policy: the table ``[tool.sdaeverify]`` of a project's pyproject.toml, and the failures it expects."""

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from math import inf, isfinite
from pathlib import Path
from typing import Any

from ..contracts.finding import Finding
from ..contracts.labels import did_you_mean, matches
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings, require
from ..contracts.specs import ProblemSpec
from ..errors import UsageError, is_blank
from ..forms import Problem
from ..study import Cell
from ..workers.amounts import read_memory
from .tiers import TIERS, Tier


@dataclass(frozen=True, kw_only=True)
class ExpectedFailure:
    """A pattern of findings that are expected to fail.

    A step that raises, hangs, dies or breaks its contract fails all the same.

    Attributes
    ----------
    reason : str
        Why; it is shown with every finding that matches.
    scheme, problem, measure, quantity : str
        Globs of labels and names, in which ``*`` and ``?`` alone are special.
    strict : bool
        Whether a finding that matches fails the gate once it is verified.

    Raises
    ------
    UsageError
        If there is no reason.
    """

    reason: str
    scheme: str = "*"
    problem: str = "*"
    measure: str = "*"
    quantity: str = "*"
    strict: bool = True

    def __post_init__(self) -> None:
        if is_blank(self.reason):
            raise UsageError(f"the expected failure {self} has no reason; say why it is expected")

    def matches(self, cell: Cell, finding: Finding) -> bool:
        """Tell whether a finding is meant."""
        pairs = (
            (self.scheme, cell.scheme.label),
            (self.problem, cell.spec.label),
            (self.measure, cell.measure.name),
            (self.quantity, finding.quantity),
        )
        return all(matches(glob, text) for glob, text in pairs)

    def __str__(self) -> str:
        named = ("scheme", "problem", "measure", "quantity")
        given = [f"{name}={getattr(self, name)}" for name in named if getattr(self, name) != "*"]
        return ", ".join(given) or "everything"


def expectation(cell: Cell, finding: Finding, expected: Iterable[ExpectedFailure]) -> ExpectedFailure | None:
    """Return the first expected failure that a finding matches, or None.

    Parameters
    ----------
    cell : Cell
    finding : Finding
        Of one quantity in the cell.
    expected : iterable of ExpectedFailure
        Those of the policy, in its order.
    """
    return next((one for one in expected if one.matches(cell, finding)), None)


# How the keys of ``[tool.sdaeverify]`` are read: each has one type, and a key that is not known is an error.


FAILURES = "expected-failures"


def read_table(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the keywords of a policy.

    Parameters
    ----------
    table : mapping of str to object
        As it is parsed from TOML.
    folder : Path
        Plugin files are relative to it.

    Raises
    ------
    UsageError
        If a key is unknown or a value has another type.
    """
    _require_known(table, READERS)
    values = {key.replace("-", "_"): READERS[key](key, value) for key, value in table.items()}
    if "plugins" in values:
        values["plugins"] = tuple(str(folder.absolute() / file) for file in values["plugins"])
    return {**values, "lock_named": "lock" in table}


def _require_known(table: Mapping[str, Any], known: Iterable[str]) -> None:
    for key in table:
        if key not in known:
            raise UsageError(f"unknown key {key!r}{did_you_mean(str(key), known)} (known: {', '.join(known)})")


def _require_fit(key: str, expected: str, value: object, *, fits: bool) -> None:
    if not fits:
        raise UsageError(f"{key} expects {expected}, got {value!r}")


def _text(key: str, value: Any) -> str:
    _require_fit(key, "a text", value, fits=isinstance(value, str) and bool(value.strip()))
    return str(value)


def _texts(key: str, value: Any) -> tuple[str, ...]:
    fits = isinstance(value, list) and value and all(isinstance(text, str) and text.strip() for text in value)
    _require_fit(key, "a list of texts", value, fits=bool(fits))
    return tuple(value)


def _number(key: str, value: Any) -> float:
    fits = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    _require_fit(key, "a number", value, fits=fits)
    return float(value)


def _integer(key: str, value: Any) -> int:
    _require_fit(key, "a whole number", value, fits=isinstance(value, int) and not isinstance(value, bool))
    return int(value)


def _switch(key: str, value: Any) -> bool:
    _require_fit(key, "true or false", value, fits=isinstance(value, bool))
    return bool(value)


def _memory(key: str, value: Any) -> int:
    text = _text(key, value)
    return 0 if text == "0" else read_memory(key, text)


def _failures(key: str, value: Any) -> tuple[ExpectedFailure, ...]:
    fits = isinstance(value, list) and all(isinstance(entry, dict) for entry in value)
    _require_fit(key, f"tables [[tool.sdaeverify.{key}]]", value, fits=fits)
    return tuple(expected_failure(f"{key}[{number}]", entry) for number, entry in enumerate(value, start=1))


def expected_failure(where: str, entry: Mapping[str, Any]) -> ExpectedFailure:
    """Read an expected failure.

    Parameters
    ----------
    where : str
        In which words it is to be found.
    entry : mapping
        With the fields of `ExpectedFailure`.

    Raises
    ------
    UsageError
        If it has no reason, an unknown field, or a value that is none of the field.
    """
    names = [field.name for field in fields(ExpectedFailure)]
    try:
        _require_known(entry, names)
        if "reason" not in entry:
            raise UsageError("has no reason; say why the failure is expected")
        values: dict[str, Any] = {key: (_switch if key == "strict" else _text)(key, entry[key]) for key in entry}
        return ExpectedFailure(**values)
    except UsageError as error:
        raise UsageError(f"{where}: {error}") from error


READERS: Mapping[str, Callable[[str, Any], Any]] = {
    "schemes": _texts,
    "problems": _texts,
    "measures": _texts,
    "plugins": _texts,
    "alpha": _number,
    "tier": _text,
    "seed": _integer,
    "inconclusive": _text,
    "lock": _text,
    "timeout": _number,
    "memory": _memory,
    "level": _integer,
    "resolution": _number,
    FAILURES: _failures,
}


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
    resolution : float
        What is verified has to show every error of the limit that is a larger part of the quantity's size; infinite
        to ask for none.
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
    resolution: float = inf
    expected_failures: tuple[ExpectedFailure, ...] = ()
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
        fits = self.level is None or self.level >= 1
        require(fits, "level", "a level of the conformance kit, from 1 on", self.level)
        require(self.resolution > 0.0, "resolution", "a positive part of a quantity's size", self.resolution)
        # Said before anything is run: what is no lock file is never overwritten.
        fits = Path(self.lock).suffix not in {".toml", ".py"}
        require(fits, "lock", f"a file of its own, such as {LOCK}", repr(self.lock))

    @property
    def budget(self) -> Tier:
        """The tier of that name."""
        return TIERS[self.tier]

    @property
    def settings(self) -> Settings:
        """Those of the tier, with this seed and this error probability."""
        return replace(self.budget.settings, seed=self.seed, confidence=1.0 - self.alpha)

    @property
    def fails_undecided(self) -> bool:
        """Whether a claim that stays undecided fails the gate."""
        return self.inconclusive == FAIL if self.inconclusive else self.budget.fails_undecided

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
    data = _parse_toml(file)
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


def _parse_toml(file: Path) -> dict[str, Any]:
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
