"""``reproduce``: run the experiments of papers again at a chosen budget."""

import json
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import click
import pandas as pd
from rich.console import Console
from rich.text import Text

from sdaeverify import UsageError
from sdaeverify.commands import (
    ExitCode,
    TablePage,
    codes_in_words,
    conclude,
    describe_making,
    load_and_warn,
    options,
    output,
    print_texts,
    require_writable,
    run_on_workers,
    visible,
    write_table,
    write_tables,
    write_text,
)
from sdaeverify.errors import FAULTS, one_line
from sdaeverify.studying import Registry, unknown

from .entries import entry_tables, explanations
from .exhibit import Exhibit
from .experiment import Budget
from .experiment_plan import EXPERIMENTS, ExperimentPlan, experiment_plan
from .picture import MISSING, draw
from .run import ExperimentRun

FOLDER = Path("reports")
ALL = "all"
CSV, JSON, FIGURE = "table.csv", "run.json", "figure"
FORMATS = ("svg", "pdf", "png")
CODES = (ExitCode.OK, ExitCode.USAGE, ExitCode.NOT_MEASURED, ExitCode.PLUGIN, ExitCode.INTERRUPTED)


@click.command(epilog=codes_in_words(*CODES), short_help="Run the experiments of papers again.")
@click.argument("names", nargs=-1)
@click.option("--list", "as_list", is_flag=True, help="List the experiments, NAMES or all; run nothing.")
@options.once(
    "--budget",
    type=click.Choice([each.value for each in Budget]),
    default=Budget.SMOKE.value,
    help="Budget.",
)
@options.once("--paths", type=int, help="Number of paths of each run.  [default: the experiment's]")
@options.plugins
@options.seed
@options.once("--out", type=options.PLACE, help=f"Folder of the files.  [default: {FOLDER}/NAME]")
@options.once("--format", type=click.Choice(FORMATS), default=FORMATS[0], help="Format of the picture.")
@options.jobs
@options.progress_of_cells
@click.pass_context
def reproduce(context: click.Context, /, **asked: Any) -> ExitCode:
    """Run experiments of papers again (NAMES, globs or all) and compare with printed and exact numbers.

    Shows where a printed number agrees with the computed one, and where with the exact value: up to half a unit of
    the last printed digit and four standard errors. A disagreement is a result, not a failure. Each experiment writes
    its table, its figure and its provenance into a separate folder.
    """
    registry = load_and_warn(asked["plugins"], lab=True)
    if asked["as_list"]:
        return _list(registry, _names_of(asked["names"] or [ALL], registry), output(unbroken=True))
    names = _names_of(asked["names"], registry)
    budget = {"budget": Budget(asked["budget"]), "paths": asked["paths"], "seed": asked["seed"]}
    plans = [experiment_plan(registry, name, **budget) for name in names]
    folders = [_folder(asked["out"], name, alone=len(names) == 1) for name in names]
    for folder in folders:
        require_writable(folder)
    worst = ExitCode.OK
    for plan, folder in zip(plans, folders, strict=True):
        code = _reproduce(plan, folder, tuple(context.obj), asked)
        worst = max(worst, code)
        if code is ExitCode.INTERRUPTED:
            break
    return conclude(worst)


def _names_of(patterns: Sequence[str], registry: Registry) -> list[str]:
    if not patterns:
        raise UsageError("reproduce expects the name of an experiment; --list shows all")
    known, names = registry.things(EXPERIMENTS), dict[str, None]()
    for pattern in patterns:
        found = [name for name in known if pattern == ALL or fnmatchcase(name, pattern)]
        if not found:
            hint = str(unknown("experiment", pattern, known))
            raise UsageError(f"{hint}{'' if hint.endswith('?') else ';'} --list shows all")
        names |= dict.fromkeys(found)
    return list(names)


def _folder(out: Path | None, name: str, *, alone: bool) -> Path:
    return out if out and alone else (out or FOLDER) / name


def _list(registry: Registry, names: Sequence[str], console: Console) -> ExitCode:
    known = registry.things(EXPERIMENTS)
    for name in names:
        experiment = known[name]
        console.print(Text(name, style="bold"))
        texts = experiment.title, f"{experiment.source}; {experiment.paths} paths"
        print_texts(console, (f"    {text}" for text in texts))
    return ExitCode.OK


def _reproduce(plan: ExperimentPlan, folder: Path, arguments: tuple[str, ...], asked: dict[str, Any]) -> ExitCode:
    run = ExperimentRun(plan)
    try:
        code = run_on_workers(run, asked["jobs"], plan.registry, asked["progress"])
    except KeyboardInterrupt:
        code = ExitCode.INTERRUPTED
    evidence = run.evidence
    console = output(unbroken=True)
    console.print(Text(f"{visible(plan.experiment.source)}: {visible(plan.experiment.title)}", style="bold"))
    try:
        exhibit = plan.experiment.exhibit(evidence)
    except FAULTS as error:
        print_texts(console, evidence.failures or [f"{plan.experiment.name}: {one_line(error)}"])
        return max(code, ExitCode.NOT_MEASURED)
    print_texts(console, _lines(exhibit, plan, console))
    print_texts(console, _save(exhibit, plan, folder, arguments, asked["format"]))
    console.print()
    failed = evidence.failures or any(entry.more.get("error") for entry in exhibit.entries)
    return max(code, ExitCode.NOT_MEASURED) if failed else code


def _lines(exhibit: Exhibit, plan: ExperimentPlan, console: Console) -> Iterator[str]:
    for part in entry_tables(exhibit.entries):
        console.print(part)
    yield from explanations(exhibit.entries)
    yield from (*exhibit.remarks, *plan.experiment.notes, *exhibit.errors)


def _save(
    exhibit: Exhibit, plan: ExperimentPlan, folder: Path, arguments: tuple[str, ...], suffix: str
) -> Iterator[str]:
    experiment, picture = plan.experiment, f"{FIGURE}.{suffix}"
    table = pd.DataFrame([entry.record() for entry in exhibit.entries])
    write_table(table, folder / CSV)
    about = {"experiment": experiment.name, "source": experiment.source, "budget": plan.budget, "paths": plan.paths}
    about |= {"remarks": exhibit.remarks, "errors": exhibit.errors}
    about = {**describe_making(plan.registry, plan.seed, arguments), **about}
    write_text(json.dumps(about, indent=2) + "\n", folder / JSON)
    drawn = None
    if exhibit.panels:
        try:
            draw(exhibit.panels, f"{experiment.source}: {experiment.title}", folder / picture)
        except UsageError:
            yield MISSING
        else:
            drawn = folder / picture
    title = f"{plan.experiment.source}: {plan.experiment.title}"
    notes = (*exhibit.remarks, *experiment.notes, *exhibit.errors)
    filled = table.loc[:, [bool(((table[name] != "") & table[name].notna()).any()) for name in table.columns]]
    page = write_tables(folder, title, [TablePage.of("Table", filled, notes, drawn)])
    yield f"{', '.join([CSV, JSON, page.name, *([picture] if drawn else [])])} are in {folder}"
