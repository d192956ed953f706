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
module `options` provides the common options: ``once``, ``PLACE``, ``plugins``, ``seed``, ``jobs``, ``selection``,
``progress_of_cells`` and ``run_folder``. Work that has a ``total`` and a ``run`` is done by `run_on_workers`;
`save_results` keeps the results of an examination as a run, which ``show`` and `sdaeverify.load` read. An entry point
of the group ``sdaeverify.sources`` names a `PluginSource`, which adds an option to all commands with ``plugins``.
"""

from .cli import options
from .cli.codes_of_runs import code_of_verdicts
from .cli.console import complain, conclude, output, output_to_stderr, print_texts
from .cli.exit_codes import ExitCode, codes_in_words
from .cli.loading import load_and_warn
from .cli.running import run_on_workers, save_results
from .gate.lock import claims_on_lines
from .registry.sources import PluginSource
from .report.class_words import class_summary
from .report.files import require_writable, write_table, write_text
from .report.folders import require_run_folder
from .report.html import TablePage, write_tables
from .report.plain import empty_table, escape, visible
from .report.provenance import describe_making

__all__ = [
    "ExitCode",
    "PluginSource",
    "TablePage",
    "claims_on_lines",
    "class_summary",
    "code_of_verdicts",
    "codes_in_words",
    "complain",
    "conclude",
    "describe_making",
    "empty_table",
    "escape",
    "load_and_warn",
    "options",
    "output",
    "output_to_stderr",
    "print_texts",
    "require_run_folder",
    "require_writable",
    "run_on_workers",
    "save_results",
    "visible",
    "write_table",
    "write_tables",
    "write_text",
]
