"""``cite``: print a citation of a run."""

from pathlib import Path

import click

from ...api import load
from ...report.plain import visible
from .. import options
from ..console import output, print_texts
from ..exit_codes import ExitCode

LATEX, MARKDOWN = "latex", "markdown"


@click.command(short_help="Tell how to cite a run, and print its table for a paper.")
@click.argument("folder", type=options.PLACE, metavar="[RUN]", default=Path("reports", "latest"))
@options.once("--table", type=click.Choice([LATEX, MARKDOWN]), help="Print the table of the verdicts instead.")
def cite(folder: Path, table: str | None) -> ExitCode:
    """Print how to cite the run in a folder, reports/latest if left out.

    Prints a sentence on method and version, a BibTeX entry, and the sources of the claims of each scheme. With
    --table, prints the verdicts as a table for a paper: LaTeX with booktabs, or Markdown.
    """
    result = load(folder)
    told = {LATEX: result.to_latex, MARKDOWN: result.to_markdown}[table]() if table else result.cite()
    print_texts(output(unbroken=True), map(visible, told.splitlines()))
    return ExitCode.OK
