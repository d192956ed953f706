"""``compare``: changes of verdicts, orders and sizes of errors between runs."""

import json
import shlex
from collections.abc import Iterator, Sequence
from itertools import pairwise
from textwrap import TextWrapper
from typing import Any

import click

from sdaeverify import UsageError
from sdaeverify.commands import (
    ExitCode,
    codes_in_words,
    complain,
    conclude,
    load_and_warn,
    options,
    output,
    output_to_stderr,
    print_texts,
    visible,
)
from sdaeverify.studying import Registry, StoredRun

from .cells import compare as compared
from .changes import RunPair, advice, changes, counted, counts, list_omissions, pair_in_words, records
from .tables import constant_changes, verdict_pairs

MARGIN, ALPHA = 1.1, 0.01
CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOTHING, ExitCode.PLUGIN)


@click.command(epilog=codes_in_words(*CODES), short_help="Compare runs: verdicts, orders, sizes of errors.")
@click.argument("runs", nargs=-1, required=True, type=options.PLACE)
@options.once("--factor", type=float, default=MARGIN, help="Factor by which an error may grow.")
@options.once("--alpha", type=float, default=ALPHA, help="Probability of a false alarm in the comparison.")
@click.option("--all", "every", is_flag=True, help="Also show what has not changed.")
@click.option("--json", "as_json", is_flag=True, help="For programs: an object with all quantities.")
@options.plugins
def compare(**asked: Any) -> ExitCode:
    """Compare RUNS, folders that matrix or gate wrote with --out, oldest first, each with the one before.

    Shows which verdicts changed, and which orders and errors changed significantly. An order may stay the same while
    errors double: on the same paths the ratio of errors is known far more precisely than the errors, so that a few
    paths show the change. Errors are compared if both runs have the same seed, step sizes and problem.
    """
    if len(asked["runs"]) < 2:
        raise UsageError("compare needs two runs or more: folders that matrix --out wrote, the oldest first")
    changes([], asked["factor"], asked["alpha"])
    runs = [StoredRun.read(folder) for folder in asked["runs"]]
    for run in (run for run in runs if run.damage):
        complain("warning", f"{run.damage} and left out")
    registry = load_and_warn(asked["plugins"])
    if advice := _plugins_to_add(runs, registry):
        complain("warning", advice)
    with output_to_stderr():
        pairs = [_compare(old, new, registry, asked) for old, new in pairwise(runs)]
    code = _code(pairs)
    if asked["as_json"]:
        about = {name: asked[name] for name in ("factor", "alpha")}
        click.echo(json.dumps({**about, "exit_code": code.value, "pairs": [*map(records, pairs)]}, indent=2))
    else:
        _show(pairs, every=asked["every"])
        print_texts(output(), [_worse(pairs)] if code is ExitCode.REFUTED else [])
        conclude(code)
    return code


def _plugins_to_add(runs: Sequence[StoredRun], registry: Registry) -> str:
    """Return the options that load plugins of the runs which are not registered here, or an empty string."""
    known = {*registry.schemes, *registry.problems, *registry.measures}
    needed = {run.folder: _compared_names(run, runs) - known for run in runs}
    lacking = [run.saved for run in runs if needed[run.folder] and {*run.saved.files} - {*registry.files}]
    if not lacking:
        return ""
    # Files of several runs may register the same names, so the files of the last run suffice.
    newest, unknown = lacking[-1], sorted({name for run in lacking for name in needed[run.folder]})
    files = [file for file in newest.files if file not in registry.files]
    option = shlex.join(word for file in files for word in ("--plugin", file))
    return f"not registered here: {', '.join(unknown)}; {newest.folder} was made with plugin files: add {option}"


def _compared_names(run: StoredRun, runs: Sequence[StoredRun]) -> set[str]:
    """Return the schemes, problems and measures that must be registered to compare the errors of runs."""
    others = {key for other in runs if other is not run for key in other.lanes}
    cells = run.lanes.keys() & others
    names = {label.partition("[")[0] for key in cells for label in key}
    return names | {*run.saved.measures} if cells else set()


def _compare(old: StoredRun, new: StoredRun, registry: Registry, asked: dict[str, Any]) -> RunPair:
    every = compared(old, new, registry)
    found, omitted = ([each for each in every if each.found.known == known] for known in (True, False))
    judged = changes([each.found for each in found], asked["factor"], asked["alpha"])
    both, rows = verdict_pairs(old, new), list(zip(found, judged, strict=True))
    return RunPair(old.folder, new.folder, both, rows, omitted, constant_changes(old, new))


def _code(pairs: Sequence[RunPair]) -> ExitCode:
    if any(pair.grown or pair.refuted for pair in pairs):
        return ExitCode.REFUTED
    if not any(pair.rows or pair.verdicts or pair.on_other_noise for pair in pairs):
        judged = sum(len(pair.judged) for pair in pairs)
        same = f"; {counted(judged, 'verdict')} of both runs are the same" if judged else ""
        complain("error", f"errors of no quantity could be compared{same}")
        return ExitCode.NOTHING
    return ExitCode.OK


def _worse(pairs: Sequence[RunPair]) -> str:
    grown, refuted = (sum(getattr(pair, name) for pair in pairs) for name in ("grown", "refuted"))
    errors, claims = counted(grown, "error"), counted(refuted, "claim")
    return f"{errors} grown beyond the factor, {claims} newly refuted"


def _show(pairs: Sequence[RunPair], *, every: bool) -> None:
    console = output()

    def texts() -> Iterator[str]:
        for pair in pairs:
            yield f"{pair.old} -> {pair.new}"
            yield from pair_in_words(pair, every=every)
            yield from (*list_omissions(pair.omitted), *advice(pair), counts(pair))

    wrapper = TextWrapper(console.width, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    print_texts(console, (line for text in texts() for line in wrapper.wrap(visible(text))))
