"""Options shared by commands: parsing and help."""

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import click

from ..contracts.settings import Settings
from ..errors import PluginError, UsageError, is_blank
from ..registry.sources import SEPARATOR, load_source_of, plugin_sources
from ..report.progress import KINDS
from ..workers.limits import SHARE, TIMEOUT, Limits, read_limits
from .completion import names_of

Command = TypeVar("Command", bound=Callable[..., Any])

SELECTION = (
    "Names with parameters, name[key=value,...], or globs, separated by commas. Repeatable; everything if left out."
)


def once(*names: str, default: object = None, **attributes: Any) -> Callable[[Command], Command]:
    """Return an option with one value; repeating it with different values is an error."""

    def one(_: click.Context, parameter: click.Parameter, values: Sequence[object]) -> object:
        different = list(dict.fromkeys(values))
        if len(different) > 1:
            listing = " and ".join(str(value) for value in different)
            raise UsageError(f"contradictory options: {parameter.opts[-1]} is given as {listing}")
        return different[0] if different else None

    return click.option(
        *names,
        multiple=True,
        default=() if default is None else (default,),
        show_default=default is not None,
        callback=one,
        **attributes,
    )


class _SourceOption(click.Option):
    """Option of a source of plugins, which is loaded for the help alone."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return the placeholder and the help text that the source declares."""
        try:
            source = load_source_of(str(self.name))
        except PluginError as error:
            self.help = str(error)
        else:
            self.metavar, self.help = source.metavar, f"{source.about} Repeatable."
        return super().get_help_record(ctx)


def plugins(command: Command) -> Command:
    """Add the options that name plugins: ``--plugin``, and one for each source.

    The command gets all of them as ``plugins``.
    """

    @wraps(command)
    def with_plugins(*given: Any, **options: Any) -> Any:
        texts = ((name, text) for name in plugin_sources() for text in options.pop(name))
        named = (*options.pop("plugins"), *(f"{name}{SEPARATOR}{text}" for name, text in texts))
        return command(*given, **options, plugins=named)

    files = click.option(
        "--plugin",
        "plugins",
        metavar="FILE",
        multiple=True,
        help="Plugin without packaging, a Python file. Repeatable.",
    )
    further = (click.option(f"--{name}", name, multiple=True, cls=_SourceOption) for name in plugin_sources())
    return cast(Command, combine_options(files, *further)(with_plugins))


seed = once("--seed", type=int, default=Settings().seed, help="Seed of all noise.")
jobs = once("-j", "--jobs", type=click.IntRange(min=1), help="Worker processes.  [default: all available cores]")
progress_of_cells = once(
    "--progress",
    type=click.Choice(KINDS),
    default=KINDS[0],
    help="Progress on stderr: a bar, plain lines, or nothing.",
)


class _NamedPath(click.Path):
    """Path that is not empty, which would mean the current folder, and not an option of the command."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path, or fail on an empty text or an option."""
        if is_blank(str(value)):
            self.fail("expected a path, got an empty text", param, ctx)
        options = [word for each in ctx.command.params for word in each.opts if word.startswith("-")] if ctx else []
        if str(value) in options:
            self.fail(f"expected a path, got the option {value}; write ./{value} if it is one", param, ctx)
        return super().convert(value, param, ctx)


PLACE = _NamedPath(path_type=Path)

run_folder = once(
    "--out", type=PLACE, metavar="DIR", help="Save the results as a run in this folder, which show prints."
)


def combine_options(*options: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Combine options into one decorator, in the order of the help."""

    def add(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return add


def selected(short: str, kind: str, told: str) -> Callable[[Command], Command]:
    """Return the option that selects schemes, problems or measures, with shell completion.

    Parameters
    ----------
    short : str
        Short form of the option.
    kind : str
        Kind of the selected entries, and long form of the option.
    told : str
        Help text.
    """
    complete = names_of(kind)
    return click.option(short, f"--{kind}", multiple=True, metavar="PATTERN", help=told, shell_complete=complete)


selection = combine_options(
    selected("-s", "schemes", f"Schemes. {SELECTION}"),
    selected("-p", "problems", "Problems, in the same way."),
    selected("-m", "measures", "Measures, in the same way."),
)


as_json = click.option(
    "--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each quantity."
)
quiet = click.option("-q", "--quiet", is_flag=True, help="Print only the counts.")


def levels_text(settings: Settings) -> str:
    """Return the numbers of steps in the format of ``--levels``."""
    return f"{settings.steps[0]}..{settings.steps[-1]}"


# Limits on the code of plugins.
limits = combine_options(
    once(
        "--timeout",
        type=float,
        metavar="SECONDS",
        help=f"Time limit of a scheme for a block of paths; 0 for none.  [default: {TIMEOUT:.0f}]",
    ),
    once(
        "--memory",
        metavar="SIZE",
        help=f"Memory limit of each worker, such as 2G; 0 for none.  [default: {SHARE:.0%} of all, shared]",
    ),
)


def options_of(options: dict[str, Any]) -> tuple[int, Limits | None]:
    """Return the number of workers and their limits from a command's options; see `read_limits`."""
    return read_limits(options["timeout"], options["memory"], options["jobs"])
