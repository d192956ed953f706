"""``wire``: check a program that speaks the wire protocol, and print the client files."""

import shlex
from pathlib import Path

import click

from sdaeverify import UsageError
from sdaeverify.commands import ExitCode, escape, options, output, print_texts

from .calling import Calling
from .check import checked
from .scheme import PATIENCE

FOLDER = Path(__file__).parent / "clients"
CLIENTS = {
    "c": "sdaeverify.h",
    "julia": "sdaeverify.jl",
    "octave": "sdaeverify.m",
    "python": "sdaeverify_client.py",
    "r": "sdaeverify.R",
}


@click.command("wire", short_help="Check a solver that is a separate program.")
@options.once("--check", "program", metavar="COMMAND", help="The program with its arguments, or its address.")
@click.option(
    "--golden", is_flag=True, help="The program must be golden-euler; compare it with the golden transcript."
)
@options.once("--patience", type=click.FloatRange(0.01), default=PATIENCE, help="Time limit of an answer in seconds.")
@options.once("--client", type=click.Choice(sorted(CLIENTS)), help="Print the client of a language, a file to copy.")
def wire(program: str | None, golden: bool, patience: float, client: str | None) -> ExitCode:
    """Check that a program speaks the wire protocol, by which a solver in any language is a scheme.

    With --client, print the file on which a program in that language is based.
    """
    if (program is None) == (client is None):
        raise UsageError("wire expects --check COMMAND or --client LANGUAGE, one of them")
    if client is not None:
        click.echo((FOLDER / CLIENTS[client]).read_text(encoding="utf-8"), nl=False)
        return ExitCode.OK
    calling = Calling.of(program or "", patience)
    for line in checked(calling, golden=golden):
        print_texts(output(), [escape(line)])
    advice = shlex.join(["sdaeverify", "matrix", "--wire", shlex.join(calling.command)])
    print_texts(output(unbroken=True), [f"commands take it with --wire: {escape(advice)}"])
    return ExitCode.OK
