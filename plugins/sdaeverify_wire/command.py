"""``wire``: check a program that speaks the wire protocol, and print the client files."""

from pathlib import Path

import click

from sdaeverify import UsageError
from sdaeverify.commands import ExitCode, escape, options, output, print_texts

from .check import advice, checked
from .program import split_command
from .scheme import PATIENCE

FOLDER = Path(__file__).parent / "clients"
CLIENTS = {
    "c": "sdaeverify.h",
    "julia": "sdaeverify.jl",
    "octave": "sdaeverify.m",
    "python": "sdaeverify_client.py",
}


@click.command("wire", short_help="Check a solver that is a program of its own.")
@options.once("--check", "program", metavar="COMMAND", help="The program with its arguments.")
@click.option("--golden", is_flag=True, help="It must be golden-euler, and answer as the golden transcript does.")
@options.once("--patience", type=click.FloatRange(0.01), default=PATIENCE, help="Seconds that an answer may take.")
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
    command = split_command(program or "")
    for line in checked(command, patience, golden=golden):
        print_texts(output(), [escape(line)])
    print_texts(output(), ["A plugin file for it, which every command takes with --plugin:"])
    print_texts(output(), [f"    {escape(line)}" if line else "" for line in advice(command)])
    return ExitCode.OK
