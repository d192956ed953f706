"""The public names for authors of commands: the options, messages and exit codes common to all commands.

A command is a `click` command that an entry point names::

    [project.entry-points."sdaeverify.commands"]
    count = "my_package.commands:count"

    @click.command(short_help="Count the schemes.")
    @options.plugins
    def count(plugins: tuple[str, ...]) -> ExitCode:
        print_texts(output(), [f"{len(load_and_warn(plugins).schemes)} schemes"])
        return ExitCode.OK

It returns an `ExitCode`; errors meant for the user are `SdaeverifyError`, and end the program with one line. The
module `options` provides the common options: ``once``, ``PLACE``, ``plugins``, ``seed``, ``jobs``, ``selection``
and ``progress_of_cells``. Work that has a ``total`` and a ``run`` is done by `run_on_workers`.
"""

from .cli import options
from .cli.codes_of_runs import code_of_verdicts
from .cli.console import conclude, output, print_texts
from .cli.exit_codes import ExitCode, codes_in_words
from .cli.loading import load_and_warn
from .cli.running import run_on_workers
from .gate.lock import claims_on_lines
from .report.files import require_writable, write_json, write_table, write_text
from .report.html import PAGE, TablePage, write_tables
from .report.plain import empty_table, escape, visible
from .report.provenance import describe_making

__all__ = [
    "PAGE",
    "ExitCode",
    "TablePage",
    "claims_on_lines",
    "code_of_verdicts",
    "codes_in_words",
    "conclude",
    "describe_making",
    "empty_table",
    "escape",
    "load_and_warn",
    "options",
    "output",
    "print_texts",
    "require_writable",
    "run_on_workers",
    "visible",
    "write_json",
    "write_table",
    "write_tables",
    "write_text",
]
