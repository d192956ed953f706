"""``reproduce``: tables and figures of papers, run again at a chosen budget."""

from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console
from rich.text import Text

from ...contracts.experiment import Budget
from ...contracts.specs import unknown
from ...errors import FAULTS, UsageError, one_line
from ...registry.load import Registry
from ...report.plain import visible
from ..console import conclude, output, print_texts
from ..exit_codes import ExitCode, codes_in_words
from ..loading import load_and_warn
from ..on_workers import run_on_workers
from ..options import PLACE, jobs, once, plugins, progress_bar, seed

if TYPE_CHECKING:
    from ...contracts.exhibit import Exhibit
    from ...lab.experiments import ExperimentPlan

FOLDER = Path("reports")
ALL = "all"
CSV, JSON, FIGURE = "table.csv", "run.json", "figure"
FORMATS = ("svg", "pdf", "png")
WORDS = {
    ExitCode.OK: "everything is run",
    ExitCode.USAGE: "the command line is wrong",
    ExitCode.NOT_MEASURED: "something could not be run",
    ExitCode.INTERRUPTED: "interrupted; the paths that were finished are saved",
}


@click.command(epilog=codes_in_words(WORDS), short_help="Run the experiments of papers again.")
@click.argument("names", nargs=-1)
@click.option("--list", "as_list", is_flag=True, help="List the experiments; run nothing.")
@once(
    "--budget",
    type=click.Choice([each.value for each in Budget]),
    default=Budget.SMOKE.value,
    help="How much it may cost.",
)
@once("--paths", type=int, help="Number of paths of each run.  [default: the experiment's]")
@plugins
@seed
@once("--out", type=PLACE, help=f"Folder of the files.  [default: {FOLDER}/NAME]")
@once("--format", type=click.Choice(FORMATS), default=FORMATS[0], help="Of the picture.")
@jobs
@progress_bar
@click.pass_context
def reproduce(context: click.Context, /, **options: Any) -> ExitCode:
    """Run experiments of papers again, NAMES, globs or all, and set their numbers beside printed and exact ones.

    Tells where the print agrees with what is found here, and where with the exact value: up to half a unit of the
    last printed digit and four standard errors. A number that disagrees is a result and no failure. Each experiment
    leaves its table, its picture and what they were made with in a folder of its own.
    """
    # The engine takes longer to load than all that other commands need.
    from ...lab.experiments import experiment_plan  # noqa: PLC0415
    from ...report.files import require_writable  # noqa: PLC0415

    registry = load_and_warn(options["plugins"], lab=True)
    if options["as_list"]:
        return _list(registry, output(unbroken=True))
    names = _names_of(options["names"], registry)
    budget = {"budget": Budget(options["budget"]), "paths": options["paths"], "seed": options["seed"]}
    plans = [experiment_plan(registry, name, **budget) for name in names]
    folders = [_folder(options["out"], name, alone=len(names) == 1) for name in names]
    for folder in folders:
        require_writable(folder)
    worst = ExitCode.OK
    for plan, folder in zip(plans, folders, strict=True):
        code = _reproduce(plan, folder, tuple(context.obj), options)
        worst = max(worst, code)
        if code is ExitCode.INTERRUPTED:
            break
    return conclude(worst, WORDS)


def _names_of(patterns: Sequence[str], registry: Registry) -> list[str]:
    if not patterns:
        raise UsageError("reproduce expects the name of an experiment; --list shows all")
    known, names = registry.experiments, dict[str, None]()
    for pattern in patterns:
        found = [name for name in known if pattern == ALL or fnmatchcase(name, pattern)]
        if not found:
            hint = str(unknown("experiment", pattern, known))
            raise UsageError(f"{hint}{'' if hint.endswith('?') else ';'} --list shows all")
        names |= dict.fromkeys(found)
    return list(names)


def _folder(out: Path | None, name: str, *, alone: bool) -> Path:
    return out if out and alone else (out or FOLDER) / name


def _list(registry: Registry, console: Console) -> ExitCode:
    for name, entry in registry.experiments.items():
        experiment = entry.experiment
        console.print(Text(name, style="bold"))
        texts = experiment.title, f"{experiment.source}; {experiment.paths} paths"
        print_texts(console, (f"    {text}" for text in texts))
    return ExitCode.OK


def _reproduce(plan: "ExperimentPlan", folder: Path, arguments: tuple[str, ...], options: dict[str, Any]) -> ExitCode:
    from ...lab.experiments.run import ExperimentRun  # noqa: PLC0415

    run = ExperimentRun(plan)
    try:
        code = run_on_workers(run, options["jobs"], plan.registry, options["progress"])
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
    print_texts(console, _save(exhibit, plan, folder, arguments, options["format"]))
    console.print()
    failed = evidence.failures or any(entry.more.get("error") for entry in exhibit.entries)
    return max(code, ExitCode.NOT_MEASURED) if failed else code


def _lines(exhibit: "Exhibit", plan: "ExperimentPlan", console: Console) -> Iterator[str]:
    from ...report.entries import entry_tables, explanations  # noqa: PLC0415

    for part in entry_tables(exhibit.entries):
        console.print(part)
    yield from explanations(exhibit.entries)
    yield from (*exhibit.remarks, *plan.experiment.notes, *exhibit.errors)


def _save(
    exhibit: "Exhibit", plan: "ExperimentPlan", folder: Path, arguments: tuple[str, ...], suffix: str
) -> Iterator[str]:
    import pandas as pd  # noqa: PLC0415

    from ...lab.experiments.picture import MISSING, draw  # noqa: PLC0415
    from ...report.files import write_json, write_table  # noqa: PLC0415
    from ...report.html import PAGE, TablePage, write_tables  # noqa: PLC0415
    from ...report.provenance import describe_making  # noqa: PLC0415

    experiment, picture = plan.experiment, f"{FIGURE}.{suffix}"
    table = pd.DataFrame([entry.record() for entry in exhibit.entries])
    write_table(table, folder / CSV)
    rows = [["" if pd.isna(cell) else str(cell) for cell in row] for row in table.itertuples(index=False)]
    title = f"{plan.experiment.source}: {plan.experiment.title}"
    write_tables(folder / PAGE, title, [TablePage("Table", list(table.columns), rows)])
    about = {"experiment": experiment.name, "source": experiment.source, "budget": plan.budget, "paths": plan.paths}
    about |= {"remarks": exhibit.remarks, "errors": exhibit.errors}
    write_json({**describe_making(plan.registry, plan.seed, arguments), **about}, folder / JSON)
    files = [CSV, JSON, PAGE]
    if exhibit.panels:
        try:
            draw(exhibit.panels, f"{experiment.source}: {experiment.title}", folder / picture)
        except UsageError:
            yield MISSING
        else:
            files.append(picture)
    yield f"{', '.join(files)} are in {folder}"
