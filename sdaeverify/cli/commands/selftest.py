"""``selftest``: whether the program refutes what is known to be wrong, and nothing else."""

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ...contracts.settings import Settings
from ...study import Study
from ..console import conclude, output, print_texts
from ..exit_codes import ExitCode, codes_in_words
from ..loading import load_and_warn
from ..on_workers import run_on_workers
from ..options import PLACE, jobs, once, plugins, progress_of_cells, seed

if TYPE_CHECKING:
    from ...lab.selftest import KillMatrix

# Most bugs are found out without sampling; a refutation on paths takes 800 of them at least.
DEFAULTS = Settings(paths=1024, looks=3)
WORDS = {
    ExitCode.OK: "every planted bug is refuted, and nothing else",
    ExitCode.REFUTED: "a planted bug survives, or what is right is refuted",
    ExitCode.NOT_MEASURED: "something could not be measured",
}
FILE = "kill.csv"


@click.command(epilog=codes_in_words(WORDS), short_help="Refute planted bugs, and nothing else.")
@once("--only", metavar="PATTERN", default="*", help="Schemes or problems, planted or not, whose names match a glob.")
@plugins
@once("--paths", type=int, default=DEFAULTS.paths, help="Number of paths at most.")
@seed
@once("--out", type=PLACE, help=f"Folder for {FILE}; nothing is written if left out.")
@jobs
@progress_of_cells
def selftest(**options: Any) -> ExitCode:
    """Run every planted bug on its problem, and every scheme where it claims something.

    Prints which check refutes which bug. Succeeds if every bug is refuted, changes that are no bugs are not, and no
    claim of a registered scheme is.
    """
    # Tables need pandas, which takes longer to load than all other commands need in all.
    from ...lab.selftest import kill_matrix, selftest_trial  # noqa: PLC0415
    from ...report.files import require_writable  # noqa: PLC0415

    begun, folder = time.monotonic(), options["out"]
    settings = replace(DEFAULTS, paths=options["paths"], seed=options["seed"])
    registry = load_and_warn(options["plugins"], lab=True)
    trial = selftest_trial(registry, options["only"])
    if folder is not None:
        require_writable(folder)
    study = Study(trial.plan, settings)
    code = run_on_workers(study, options["jobs"], registry, options["progress"])
    return code if code is not ExitCode.OK else _show(kill_matrix(trial, study.results()), folder, begun)


def _show(matrix: "KillMatrix", folder: Path | None, begun: float) -> ExitCode:
    from ...lab.selftest.kills import counts, in_words, kill_table, terminal_table  # noqa: PLC0415
    from ...report.files import write_table  # noqa: PLC0415
    from ...report.html import PAGE, write_tables  # noqa: PLC0415
    from ...report.html.verifier import read_csv  # noqa: PLC0415

    console = output(unbroken=True)
    if matrix.bugs:
        console.print(terminal_table(matrix, plain=console.options.ascii_only))
        console.print()
    for line in in_words(matrix):
        console.print(line, soft_wrap=True)
    if folder is not None:
        write_table(kill_table(matrix), folder / FILE)
        head, *rows = read_csv(folder / FILE)
        write_tables(folder / PAGE, counts(matrix), (), verifier={"kills": {"head": head, "rows": rows}})
        print_texts(console, [f"{FILE} and {PAGE} are in {folder}"])
    return conclude(_code(matrix), WORDS, time.monotonic() - begun)


def _code(matrix: "KillMatrix") -> ExitCode:
    if not matrix.passed:
        return ExitCode.REFUTED
    return ExitCode.NOT_MEASURED if matrix.unmeasured else ExitCode.OK
