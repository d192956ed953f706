"""The command group, and the handling of errors."""

import errno
import os
import sys
import traceback
from collections.abc import Sequence
from importlib import import_module
from importlib.metadata import EntryPoint
from io import TextIOWrapper
from pathlib import Path
from pkgutil import iter_modules

import click
from click.shell_completion import CompletionItem, shell_complete

from .. import __version__
from ..contracts.spelling import did_you_mean
from ..errors import PluginError, SdaeverifyError, UsageError, one_line
from ..registry.discovery import COMMANDS, enabled_entry_points, load_entry, origin_of
from .console import PROGRAM, complain, silence
from .exit_codes import ExitCode, code_of_error, codes_in_words

# Each file of the folder is a command, imported on demand.
OWN = {module.name for module in iter_modules([str(Path(__file__).parent / "commands")])}
COMPLETION = "_SDAEVERIFY_COMPLETE"
# Errors of a stream whose disk or quota is full.
NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


class _Commands(click.Group):
    """Command group that imports commands on demand and suggests names for misspelt ones."""

    def list_commands(self, _: click.Context) -> list[str]:
        return sorted({*OWN, *_of_plugins()})

    def get_command(self, _: click.Context, cmd_name: str) -> click.Command | None:
        try:
            return _command(cmd_name)
        except PluginError as error:
            complain("warning", str(error))
            return None

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        # Names without help: the help is in the module of a command, whose import takes a second.
        names = [name for name in self.list_commands(ctx) if name.startswith(incomplete)]
        return [*map(CompletionItem, names), *click.Command.shell_complete(self, ctx, incomplete)]

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if _command(args[0]) is None:
            every = self.list_commands(ctx)
            raise UsageError(f"unknown command {args[0]!r}{did_you_mean(args[0], every)} (known: {', '.join(every)})")
        return super().resolve_command(ctx, args)


def _of_plugins() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in enabled_entry_points(COMMANDS)}


def _command(name: str) -> click.Command | None:
    """Return a command, or None for an unknown name.

    Raises
    ------
    PluginError
        If the plugin of the command cannot be loaded.
    """
    if name in OWN:
        known = vars(import_module(f".commands.{name}", __package__)).values()
        return next(each for each in known if isinstance(each, click.Command))
    entry = _of_plugins().get(name)
    if entry is None:
        return None
    command = load_entry(entry, f"command {name}")
    if not isinstance(command, click.Command):
        where = f"command {name} of {origin_of(entry)}"
        raise PluginError(f"{where} is broken: expected a click command, got {type(command).__name__}")
    return command


@click.group(
    cls=_Commands,
    epilog=codes_in_words(),
    context_settings={"help_option_names": ["-h", "--help"]},
    invoke_without_command=True,
)
@click.version_option(__version__, message="%(prog)s %(version)s")
@click.pass_context
def sdaeverify(context: click.Context) -> None:
    """Verify the claims of schemes for stochastic differential-algebraic equations."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def execute(arguments: Sequence[str]) -> int:
    """Run the command line and return the exit code; user errors are printed as one line on stderr.

    Parameters
    ----------
    arguments : sequence of str
        Words of the command line without the program's name.

    Returns
    -------
    int
        Value of `ExitCode`.
    """
    try:
        if instruction := os.environ.get(COMPLETION):
            return shell_complete(sdaeverify, {}, PROGRAM, COMPLETION, instruction)
        return _invoke(arguments)
    except (KeyboardInterrupt, click.Abort):
        complain("", "interrupted")
        return ExitCode.INTERRUPTED
    except BrokenPipeError:
        silence(sys.stdout)
        return ExitCode.OK
    except SystemExit as ending:
        # Raised only by plugins; its status must not be taken for the result of a run.
        return _fail(f"a plugin called sys.exit({ending.code!r})", ExitCode.NOT_MEASURED)
    except BaseException as error:
        if isinstance(error, Exception):
            raise
        # Other exceptions that end a program, such as GeneratorExit, are errors of the plugin, too.
        return _fail(f"a plugin raised {one_line(error)}", ExitCode.NOT_MEASURED)


def _invoke(arguments: Sequence[str]) -> int:
    if any("\0" in word for word in arguments):
        return _fail("an argument contains the character NUL, which no name or path has", ExitCode.USAGE)
    try:
        with sdaeverify.make_context(PROGRAM, list(arguments), obj=[PROGRAM, *arguments]) as context:
            return sdaeverify.invoke(context) or ExitCode.OK
    except click.exceptions.Exit as ending:
        return ending.exit_code
    except click.ClickException as error:
        return _fail(_text(error), ExitCode.USAGE)
    except SdaeverifyError as error:
        return _fail(str(error), code_of_error(error))
    except MemoryError as error:
        return _fail(f"out of memory: {error}; try fewer --jobs or a smaller --block", ExitCode.NOT_MEASURED)


def conclude(arguments: Sequence[str]) -> int:
    """Run the command line of this process, flush stdout and return the exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            # A character that the terminal cannot encode is shown as its code.
            stream.reconfigure(errors="backslashreplace")
    code: int = ExitCode.OK
    try:
        code = execute(arguments)
        # None if the program was started with stdout closed.
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        silence(sys.stdout)
    except Exception as error:
        code = _fail_at_the_end(error)
    return code


def _fail_at_the_end(error: Exception) -> ExitCode:
    """Report an error that no command expects: a full disk in one line, anything else as a defect."""
    if isinstance(error, OSError) and error.errno in NO_ROOM:
        # What is left in the buffer cannot be written at exit, either.
        silence(sys.stdout)
        return _fail(
            f"cannot write the output: {error.strerror}; make room, or send it elsewhere", ExitCode.NOT_MEASURED
        )
    traceback.print_exception(error)
    return _fail("this is a defect of sdaeverify; please report it with the lines above", ExitCode.NOT_MEASURED)


def _fail(message: str, code: ExitCode) -> ExitCode:
    complain("error", message)
    return code


def _text(error: click.ClickException) -> str:
    if isinstance(error, click.NoSuchOption):
        known = (
            [word for parameter in error.ctx.command.get_params(error.ctx) for word in parameter.opts]
            if error.ctx
            else []
        )
        meant = did_you_mean(error.option_name, known, "--" if error.option_name.startswith("--") else "")
        hint = meant or _whose(error.option_name)
        return f"no such option {error.option_name}{hint or _help_of(error)}"
    text = error.format_message().rstrip(".").replace("valid integer range", "valid integer")
    return f"{text[:1].lower()}{text[1:]}{_help_of(error)}"


def _whose(option: str) -> str:
    """Return which commands have an option that was given to another one."""
    commands = {name: _command_or_none(name) for name in sorted({*OWN, *_of_plugins()})}
    having = [name for name, one in commands.items() if one and any(option in each.opts for each in one.params)]
    return f"; it is an option of {', '.join(having)}" if having else ""


def _command_or_none(name: str) -> click.Command | None:
    """Return a command, or None if its plugin cannot be loaded, because the user has called another command."""
    try:
        return _command(name)
    except PluginError:
        return None


def _help_of(error: click.ClickException) -> str:
    """Return the hint at the help of a command; empty if the error has no command."""
    context = error.ctx if isinstance(error, click.UsageError) else None
    return f"; {context.command_path} --help shows what it takes" if context else ""
