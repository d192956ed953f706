"""Tables of rates: one row per rate for programs; one row per statistic and a column per sample size for readers."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isfinite
from typing import Any, NamedTuple

import pandas as pd

from sdaeverify.commands import escape, visible

from .calibration_plan import CalibrationPlan
from .rates import NOTHING, TABLE_LEVEL, Rate, offending

# Largest number of sample sizes for columns; more are averages of sequential samples.
MOST_SIZES = 3


class Section(NamedTuple):
    """The table of one study.

    Attributes
    ----------
    study : str
    headings : list of str
    rows : list of list of str
    """

    study: str
    headings: list[str]
    rows: list[list[str]]


def rate_table(rates: Sequence[Rate], plan: CalibrationPlan) -> pd.DataFrame:
    """Return a row for each rate, with its 95 % interval and the prescribed range."""
    outside = offending(rates)
    return pd.DataFrame([{**_record(rate), "agrees": rate not in outside, "seed": plan.seed} for rate in rates])


def sections(rates: Sequence[Rate]) -> Iterator[Section]:
    """Yield a table for each study, with a star at each rate outside its range."""
    outside = offending(rates)
    for study in dict.fromkeys(rate.study for rate in rates):
        found = [rate for rate in rates if rate.study == study]
        sizes = sorted({rate.paths for rate in found if isfinite(rate.paths)})
        yield _by_size(found, sizes, outside) if len(sizes) <= MOST_SIZES else _one_by_one(found, outside)


def summary(rates: Sequence[Rate]) -> list[str]:
    """Return the number of rates and the rates outside their range, in sentences."""
    outside = offending(rates)
    promised = sum(rate.expected != NOTHING for rate in rates)
    count = f"{len(outside)} of {promised} rates" if outside else f"none of {promised} rates"
    head = f"{count} with a promise disagree with it; {len(rates) - promised} more are shown"
    return [head, *(f"disagrees: {describe(rate)}" for rate in outside)]


def describe(rate: Rate) -> str:
    """Return a rate in one line."""
    paths = f", {rate.paths:.0f} paths" if isfinite(rate.paths) else ""
    return f"{rate.study}, {rate.case}, {rate.statistic}{paths}: {_entry(rate)}, promised {rate.expected.words}"


def markdown(rates: Sequence[Rate], plan: CalibrationPlan, command: str, making: Mapping[str, Any]) -> str:
    """Return the report in Markdown.

    Parameters
    ----------
    rates : sequence of Rate
    plan : CalibrationPlan
    command : str
        Command that reproduces the report.
    making : mapping
        Provenance, from `describe_making`.

    Returns
    -------
    str
    """
    shown = visible(command).replace("`", "")
    made = ", ".join(f"{name} {version}" for name, version in making["versions"].items())
    lines = [
        "# Calibration",
        "",
        f"Made by `{shown}` with seed {plan.seed}, stream {making['stream_fingerprint']}, {made}.",
        "",
        f"Shares of trials, with Clopper and Pearson's 95 % intervals; about {plan.repetitions} trials of 400 paths,",
        "four times as many of 100, a quarter of 1600, a part of that on costly cells. A star marks a rate",
        f"that disagrees with what is promised, at level {TABLE_LEVEL} for the whole table.",
        "",
        *map(escape, summary(rates)),
    ]
    for section in sections(rates):
        lines += ["", f"## {section.study.capitalize()}", "", *_table(section)]
    return "\n".join(lines) + "\n"


def _record(rate: Rate) -> dict[str, object]:
    low, high = rate.interval()
    return {
        "study": rate.study,
        "case": rate.case,
        "statistic": rate.statistic,
        "paths": rate.paths,
        "rate": rate.rate,
        "ci_low": low,
        "ci_high": high,
        "hits": rate.hits,
        "trials": rate.trials,
        "promised_low": rate.expected.low,
        "promised_high": rate.expected.high,
        "promised": rate.expected.words,
    }


def _by_size(rates: Sequence[Rate], sizes: Sequence[float], outside: Sequence[Rate]) -> Section:
    """Return a row for each case and statistic, with a column for each sample size."""
    rows: dict[tuple[str, str], dict[float, Rate]] = {}
    for rate in rates:
        rows.setdefault((rate.case, rate.statistic), {})[rate.paths if sizes else 0.0] = rate
    texts = []
    for names, found in rows.items():
        entries = [_entry(found[size], outside) if size in found else "" for size in sizes or [0.0]]
        texts.append([*names, *entries, _promise(found.values())])
    columns = [f"{size:.0f} paths" for size in sizes] or ["rate"]
    return Section(rates[0].study, ["case", "statistic", *columns, "promised"], texts)


def _one_by_one(rates: Iterable[Rate], outside: Sequence[Rate]) -> Section:
    found = list(rates)
    rows = [[r.case, r.statistic, f"{r.paths:.0f}", _entry(r, outside), _promise([r])] for r in found]
    return Section(found[0].study, ["case", "statistic", "mean paths", "rate", "promised"], rows)


def _promise(rates: Iterable[Rate]) -> str:
    """Return the prescribed range in words, with the sample sizes to which it applies if not all."""
    found = list(rates)
    kept = [rate for rate in found if rate.expected != NOTHING]
    if not kept or len(kept) == len(found):
        return found[0].expected.words
    return f"{kept[0].expected.words} from {kept[0].paths:.0f} paths on"


def _entry(rate: Rate, outside: Sequence[Rate] = ()) -> str:
    low, high = rate.interval()
    return f"{rate.rate:.4g} ({low:.4f}, {high:.4f}){' *' if rate in outside else ''}"


def _table(section: Section) -> list[str]:
    rows = [section.headings, ["---"] * len(section.headings), *section.rows]
    return [f"| {' | '.join(map(escape, row))} |" for row in rows]
