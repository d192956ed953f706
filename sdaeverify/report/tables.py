"""Results as tables in long form: one row a quantity, and one row a quantity and step size."""

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from ..arrays import Array
from ..contracts.finding import Finding
from ..contracts.scheme import Claim
from ..contracts.settings import Settings
from ..simulate.tracks import COST, COUNTED
from ..study import CellResult

VERDICT_COLUMNS = (
    "scheme",
    "problem",
    "measure",
    "quantity",
    "claim",
    "estimate",
    "ci_low",
    "ci_high",
    "verdict",
    "reason",
    "method",
    "paths",
    "seconds",
    "seed",
    "reproduce",
    "view",
    "confidence",
    "margin",
    "claim_source",
    "tier",
    "p_verified",
    "p_refuted",
)
LEVEL_COLUMNS = (
    "scheme",
    "problem",
    "measure",
    "quantity",
    "h",
    "estimate",
    "std_error",
    "paths",
    "failed_paths",
    "truncated_share",
    "steps",
    "lost_paths",
    "seed",
)


def verdict_rows(
    results: Iterable[CellResult],
    settings: Settings,
    plugins: Sequence[str] = (),
    unnamed: frozenset[str] = frozenset(),
) -> list[dict[str, object]]:
    """Return one row for each quantity of each cell.

    Parameters
    ----------
    results : iterable of CellResult
    settings : Settings
    plugins : sequence of str
        Plugin files named by path: the command that reproduces a row names them, too.
    unnamed : frozenset of str
        Labels of schemes and problems without a registered name: their rows have no command.

    Returns
    -------
    list of dict
        By column, the details of the measures last.
    """
    rows: list[dict[str, object]] = []
    for result in results:
        nameless = {result.cell.scheme.label, result.cell.spec.label} & unnamed
        command = "" if nameless else reproduce(result, settings, plugins)
        rows += _verdict_rows(result, settings, command)
    return rows


def verdict_table(rows: Sequence[dict[str, object]]) -> pd.DataFrame:
    """Return rows of verdicts as a table: `VERDICT_COLUMNS` first, then the details of the measures."""
    return _frame(rows, VERDICT_COLUMNS)


def level_table(results: Iterable[CellResult], settings: Settings) -> pd.DataFrame:
    """Return one row for each quantity of each cell at each step size.

    Parameters
    ----------
    results : iterable of CellResult
    settings : Settings

    Returns
    -------
    DataFrame
        `LEVEL_COLUMNS` first, then the details of the measures.
    """
    return _frame([row for result in results for row in _level_rows(result, settings)], LEVEL_COLUMNS)


def reproduce(result: CellResult, settings: Settings, plugins: Sequence[str] = ()) -> str:
    """Return the command that computes a cell again, to the last bit.

    Parameters
    ----------
    result : CellResult
    settings : Settings
    plugins : sequence of str

    Returns
    -------
    str
    """
    cell, default = result.cell, Settings()
    words = ["python", "-m", "sdaeverify", "matrix"]
    words += ["-s", cell.scheme.label, "-p", cell.spec.label, "-m", cell.measure.name]
    words += ["--out", "reports/reproduced"]
    words += ["--paths", str(settings.paths), "--levels", f"{settings.steps[0]}..{settings.steps[-1]}"]
    words += ["--seed", str(settings.seed)]
    if settings.confidence != default.confidence:
        words += ["--confidence", str(settings.confidence)]
    for name in ("block", "looks", "family"):
        if getattr(settings, name) != getattr(default, name):
            words += [f"--{name}", str(getattr(settings, name))]
    for plugin in plugins:
        words += ["--plugin", plugin]
    return shlex.join(words)


def claim_text(claim: Claim | None) -> str:
    """Return a claim for a cell of a table; empty where there is none."""
    return "" if claim is None else str(claim)


def _verdict_rows(result: CellResult, settings: Settings, command: str) -> Iterator[dict[str, object]]:
    names, measured = _names(result), _measured(result, settings, command)
    for finding in result.findings:
        yield {**names, "quantity": finding.quantity, **_judged(finding), **measured}


def _names(result: CellResult) -> dict[str, object]:
    cell = result.cell
    return {"scheme": cell.scheme.label, "problem": cell.spec.label, "measure": cell.measure.name}


def _judged(finding: Finding) -> dict[str, object]:
    return {
        "claim": claim_text(finding.claim),
        "estimate": finding.estimate,
        "ci_low": finding.low,
        "ci_high": finding.high,
        "verdict": str(finding.verdict),
        "reason": str(finding.reason),
        "method": finding.method,
        "margin": finding.claim.margin if finding.claim else float("nan"),
        "claim_source": finding.claim.source if finding.claim else "",
        "tier": f"T{finding.tier}" if finding.method else "",
        "p_verified": finding.p_verified,
        "p_refuted": finding.p_refuted,
        **finding.details,
    }


def _measured(result: CellResult, settings: Settings, command: str) -> dict[str, object]:
    return {
        "paths": result.paths,
        "seconds": round(result.seconds, 3),
        "seed": settings.seed,
        "reproduce": command,
        "view": result.cell.view,
        "confidence": settings.confidence,
    }


def _level_rows(result: CellResult, settings: Settings) -> Iterator[dict[str, object]]:
    names = _names(result)
    for row in result.levels:
        yield {
            **names,
            "quantity": row.quantity,
            "h": row.h,
            "estimate": row.estimate,
            "std_error": row.std_error,
            "seed": settings.seed,
            **({} if row.level is None else _of_level(result, settings, row.level)),
            **row.details,
        }


def _of_level(result: CellResult, settings: Settings, level: int) -> dict[str, object]:
    health, steps = result.health.sums, result.health.sums["steps"][level]
    return {
        "h": result.horizon / settings.steps[level],
        "paths": result.paths,
        "failed_paths": int(health["failed"][level]),
        "truncated_share": health["truncated"][level] / steps,
        "steps": settings.steps[level],
        "lost_paths": int(health["lost"][level]),
        **_means(health, level),
    }


def _means(health: Mapping[str, Array], level: int) -> dict[str, float]:
    """Return each cost's mean over the steps that have it; NaN if none has."""
    names = [name.removeprefix(COST) for name in health if name.startswith(COST)]
    counts = {name: health[f"{COUNTED}{name}"][level] for name in names}
    return {f"mean_{n}": health[f"{COST}{n}"][level] / counts[n] if counts[n] else np.nan for n in names}


def _frame(rows: Sequence[dict[str, object]], columns: Sequence[str]) -> pd.DataFrame:
    further = dict.fromkeys(name for row in rows for name in row if name not in columns)
    table = pd.DataFrame(rows, columns=[*columns, *further])
    # A column of whole numbers reads the same whether or not other rows leave it empty.
    whole = [name for name in further if all(type(row[name]) is int for row in rows if name in row)]
    return table.astype(dict.fromkeys(whole, "Int64"))
