"""``selftest``: whether the program refutes what is known to be wrong, and nothing else."""

import time
from collections.abc import Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.text import Text

from ...contracts.settings import Settings
from ...report.plain import visible
from ...study import Study
from ...workers.pool import BLOCKS_A_WORKER, available_cores, executor_for
from ..console import complain, output
from ..exit_codes import ExitCode, codes_in_words
from ..loading import loaded
from ..options import jobs, once, plugins, progress_of_cells, seed
from ..progress import progress

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
@once("--out", type=click.Path(path_type=Path), help=f"Folder for {FILE}; nothing is written if left out.")
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
    registry = loaded(options["plugins"], lab=True)
    trial = selftest_trial(registry, options["only"])
    if folder is not None:
        require_writable(folder)
    study = Study(trial.plan, settings)
    try:
        _advance(study, options["jobs"] or available_cores(), registry.files, options["progress"])
    except BrokenExecutor:
        complain("error", "a worker process died, perhaps for want of memory; try fewer --jobs")
        return ExitCode.NOT_MEASURED
    return _shown(kill_matrix(trial, study.results()), folder, begun)


def _advance(study: Study, jobs: int, files: Sequence[str], kind: str) -> None:
    jobs = max(1, min(jobs, study.total))
    with executor_for(jobs, files) as executor, progress(kind, study.total) as show:
        for event in study.run(executor, BLOCKS_A_WORKER * jobs):
            show(event)


def _shown(matrix: "KillMatrix", folder: Path | None, begun: float) -> ExitCode:
    from ...lab.selftest.kills import counts, in_words, kill_table, terminal_table  # noqa: PLC0415
    from ...report.files import write_table  # noqa: PLC0415
    from ...report.html import PAGE, write_tables  # noqa: PLC0415

    console = output(unbroken=True)
    if matrix.bugs:
        console.print(terminal_table(matrix, plain=console.options.ascii_only))
        console.print()
    for line in in_words(matrix):
        console.print(line, soft_wrap=True)
    if folder is not None:
        table = kill_table(matrix)
        write_table(table, folder / FILE)
        rows = [[str(cell) for cell in row] for row in table.itertuples(index=False)]
        write_tables(
            folder / PAGE, counts(matrix), (), verifier={"kills": {"head": list(table.columns), "rows": rows}}
        )
        console.print(Text(visible(f"{FILE} and {PAGE} are in {folder}")), soft_wrap=True)
    code = _code(matrix)
    words = f"{time.monotonic() - begun:.0f} s; exit code {code.value}: {WORDS[code]}"
    console.print(words, style="green" if code is ExitCode.OK else "red", soft_wrap=True)
    return code


def _code(matrix: "KillMatrix") -> ExitCode:
    if not matrix.passed:
        return ExitCode.REFUTED
    return ExitCode.NOT_MEASURED if matrix.unmeasured else ExitCode.OK
