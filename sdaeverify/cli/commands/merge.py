"""``merge``: combine runs of several machines."""

from collections import Counter
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import click

from ...api import plan_of
from ...contracts.settings import Settings
from ...errors import SdaeverifyError, UsageError
from ...registry.load import Registry
from ...registry.selection import select_measures, select_problems, select_schemes
from ...report.folders import require_run_folder
from ...report.saved import SavedRun, read_run
from ...store.store import copy_evidence
from ...study.plan import union
from ...workers.limits import read_limits
from ..console import complain
from ..exit_codes import ExitCode
from ..loading import load_and_warn
from ..options import PLACE, once, plugins
from ..running import Run, carry_out, workers

FOLDER = Path("reports", "merged")


@click.command(short_help="Merge runs of several machines.")
@click.argument("runs", nargs=-1, required=True, type=PLACE)
@once("--out", type=PLACE, default=FOLDER, help="Folder of the merged run.")
@plugins
@click.pass_context
def merge(context: click.Context, /, runs: tuple[Path, ...], **options: Any) -> ExitCode:
    """Copy the evidence of RUNS, folders that matrix or gate wrote, into one folder and judge it there.

    No path is computed: a problem is judged as far as there is evidence on all its cells. The runs must have the same
    settings, except for the number of paths. matrix with the same --out computes the missing part.
    """
    saved = [read_run(folder) for folder in runs]
    _require_same(saved)
    settings = replace(saved[0].settings, paths=max(run.settings.paths for run in saved))
    registry = load_and_warn(options["plugins"])
    with workers(*read_limits(None, None, None), registry) as crew:
        todo = _plan(saved, registry, crew.executor)
        require_run_folder(options["out"])
        for folder in runs:
            _report_copies(folder, copy_evidence(folder, options["out"]))
        merged = Run(todo, settings, registry, tuple(context.obj), options["out"], stored_only=True)
        return carry_out(merged, crew, "none")


def _report_copies(folder: Path, copied: Counter[str]) -> None:
    complain("", f"{folder}: {copied['new']} blocks are new, {copied['same']} were there")
    if copied["other"]:
        complain("warning", f"{folder}: {copied['other']} blocks are there with other numbers, which are kept")
    if copied["damaged"]:
        complain("warning", f"{folder}: {copied['damaged']} pieces of evidence are damaged and left out")


def _require_same(saved: "Sequence[SavedRun]") -> None:
    for run in saved[1:]:
        if (name := _first_difference(saved[0], run)) is not None:
            one, other = getattr(saved[0].settings, name), getattr(run.settings, name)
            raise UsageError(f"{saved[0].folder} was run with {name} {one}, {run.folder} with {other}: cannot merge")


def _first_difference(one: SavedRun, other: SavedRun) -> str | None:
    """Return the name of the first setting other than `paths` in which two runs differ, or None."""
    names = (field.name for field in fields(Settings) if field.name != "paths")
    return next((name for name in names if getattr(one.settings, name) != getattr(other.settings, name)), None)


def _plan(saved: "Sequence[SavedRun]", registry: Registry, executor: "Executor | None") -> Any:
    select: dict[str, Any] = {"schemes": select_schemes, "problems": select_problems, "measures": select_measures}
    chosen = [{kind: _select_registered(registry, run, kind, select[kind]) for kind in select} for run in saved]
    chosen = [known for known in chosen if all(known.values())]
    if not chosen:
        raise UsageError("nothing to merge: no run is about schemes, problems and measures that are registered here")
    plans = [plan_of(registry, known["schemes"], known["problems"], known["measures"], executor) for known in chosen]
    # In the order of a single run.
    schemes, problems = (
        [each.label for each in select[kind](registry, [label for known in chosen for label in known[kind]])]
        for kind in ("schemes", "problems")
    )
    return union(plans, schemes, problems)


def _select_registered(registry: Registry, run: SavedRun, kind: str, select: Any) -> list[str]:
    """Return the labels that are registered here, and warn about the others."""
    known = []
    for label in getattr(run, kind):
        try:
            select(registry, label)
            known.append(label)
        except SdaeverifyError as error:
            complain("warning", f"{run.folder}: {error}; its evidence is copied and not judged")
    return known
