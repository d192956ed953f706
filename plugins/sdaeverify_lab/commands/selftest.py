"""``selftest``: check that the program refutes all planted bugs and no correct claim."""

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from sdaeverify import Scheme, Settings
from sdaeverify.commands import (
    ExitCode,
    TablePage,
    codes_in_words,
    conclude,
    load_and_warn,
    options,
    output,
    print_texts,
    require_writable,
    run_on_workers,
    write_table,
    write_tables,
)
from sdaeverify.studying import CellResult, Study

from ..selftest import KillMatrix, kill_matrix, selftest_trial
from ..selftest.kills import counts, in_words, kill_table, terminal_table

# Most bugs are refuted without sampling; a refutation on paths needs at least 800 paths.
DEFAULTS = Settings(paths=1024, max_looks=3)
CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.NOT_MEASURED, ExitCode.PLUGIN)
FILE = "kill.csv"


@click.command(
    epilog=codes_in_words(*CODES), short_help="Check that planted bugs are refuted and right schemes are not."
)
@options.once(
    "--only", metavar="PATTERN", default="*", help="Schemes or problems, planted or not, whose names match a glob."
)
@options.plugins
@options.once("--paths", type=int, default=DEFAULTS.paths, help="Largest number of paths.")
@options.seed
@options.once("--out", type=options.PLACE, help=f"Folder for {FILE}; nothing is written if left out.")
@click.option("--quick", is_flag=True, help="Test classes of equations only for bugs that nothing else refutes.")
@options.jobs
@options.progress_of_cells
def selftest(**asked: Any) -> ExitCode:
    """Run every planted bug on its problem, and every scheme on the problems of its claims.

    Prints which check refutes which bug. Succeeds if every bug is refuted, and neither an equivalent change nor a
    claim of a registered scheme is. With --quick the column of order conditions
    is empty for most bugs.
    """
    begun, folder = time.monotonic(), asked["out"]
    settings = replace(DEFAULTS, paths=asked["paths"], seed=asked["seed"])
    registry = load_and_warn(asked["plugins"], lab=True)
    trial = selftest_trial(registry, asked["only"])
    if folder is not None:
        require_writable(folder)
    results, refuted = list[CellResult](), frozenset[Scheme]()
    if asked["quick"]:
        wrong = {bug.scheme for bug in trial.placed}
        study = Study(trial.plan_of(wrong.__contains__), settings)
        code = run_on_workers(study, asked["jobs"], registry, asked["progress"])
        if code is not ExitCode.OK:
            return code
        refuted = kill_matrix(trial, study.results()).refuted
        results = [result for result in study.results() if result.cell.scheme in refuted]
    study = Study(trial.plan_of(lambda scheme: scheme not in refuted), settings, orders=True)
    code = run_on_workers(study, asked["jobs"], registry, asked["progress"])
    if code is not ExitCode.OK:
        return code
    results += [*study.results(), *(study.class_results or ())]
    return _show(kill_matrix(trial, results), folder, begun)


def _show(matrix: KillMatrix, folder: Path | None, begun: float) -> ExitCode:
    console = output(unbroken=True)
    if matrix.bugs:
        console.print(terminal_table(matrix, plain=console.options.ascii_only))
        console.print()
    for line in in_words(matrix):
        console.print(line, soft_wrap=True)
    if folder is not None:
        table = kill_table(matrix)
        write_table(table, folder / FILE)
        page = write_tables(folder, counts(matrix), [TablePage.of("Planted bugs", table)])
        print_texts(console, [f"{FILE} and {page.name} are in {folder}"])
    return conclude(_code(matrix), time.monotonic() - begun)


def _code(matrix: KillMatrix) -> ExitCode:
    if not matrix.passed:
        return ExitCode.REFUTED
    return ExitCode.NOT_MEASURED if matrix.unmeasured else ExitCode.OK
