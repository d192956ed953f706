"""``init``: set up the gate of an existing library."""

import shlex
from pathlib import Path

import click

from sdaeverify.commands import ExitCode, options, output, print_texts

from ..scaffold.library import adopt


@click.command("init", short_help="Make a library that exists gate its schemes.")
@click.argument("folder", metavar="[DIR]", type=options.PLACE, default=Path())
def init(folder: Path) -> ExitCode:
    """Write the files that a gate of its schemes needs into DIR, the folder of a library; by default this folder.

    These are a module of its package with an example scheme, a test, a workflow, and tables at the end of its
    pyproject.toml: an entry point and the policy. No file is overwritten.
    """
    written = adopt(folder)
    lines = [f"written into {folder}:", *(f"  {path}" for path in written)]
    module = next(path for path in written if path.endswith("verification.py"))
    lines += [f"Put a step of your own into {module}, then:"]
    lines += [f"  cd {shlex.quote(str(folder))}"] * (folder != Path())
    lines += [
        "  pip install -e .",
        "  sdaeverify gate",
        "  sdaeverify gate --write-lock     # when its claims are all there",
    ]
    print_texts(output(), lines)
    return ExitCode.OK
