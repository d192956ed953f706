"""``new-plugin``: a working package with a scheme, a problem, their claims, tests and a workflow."""

import shlex
from pathlib import Path

import click

from sdaeverify.commands import ExitCode, options, output, print_texts

from ..scaffold import names_of, write_plugin


@click.command("new-plugin", short_help="Write a plugin to begin with.")
@click.argument("folder", metavar="DIR", type=options.PLACE)
@options.once("--name", metavar="NAME", help="Name of the distribution.  [default: the last part of DIR]")
def new_plugin(folder: Path, name: str | None) -> ExitCode:
    """Write a plugin into DIR, which must be new or empty: a package that passes its tests and its gate.

    The package has one scheme and one problem with claims and their sources, tests, a lock file of the measured
    cells, and a workflow that gates each pull request and runs the full budget once a week.
    """
    names = names_of(folder, name)
    written = write_plugin(folder, names)
    commands = (f"cd {shlex.quote(str(folder))}", "pip install '.[test]'", "pytest", "sdaeverify gate")
    lines = [f"{names.distribution} is in {folder}:", *(f"  {path}" for path in written)]
    lines += ["Try it:", *(f"  {command}" for command in commands)]
    print_texts(output(), lines)
    return ExitCode.OK
