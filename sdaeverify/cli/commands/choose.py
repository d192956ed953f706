"""``choose``: find the scheme that needs the least work for an accuracy on a problem."""

from collections.abc import Iterator
from itertools import zip_longest
from math import isfinite, nan
from typing import Any

import click
from click.core import ParameterSource
from rich.measure import Measurement
from rich.text import Text

from ...api import Result, load, verify
from ...contracts.labels import parse_label
from ...contracts.spelling import counted
from ...errors import UsageError
from ...report.plain import empty_table, visible, wrap_text
from ...report.sentences import SYMBOLS, mark
from ...report.tables.choice import ERRORS, FARTHEST, STATIONARY, Choice, Choices
from .. import options
from ..completion import names_of
from ..console import complain, output, output_to_stderr, print_json, print_texts
from ..exit_codes import ExitCode, codes_in_words
from ..loading import load_and_warn

CODES = (ExitCode.OK, ExitCode.USAGE, ExitCode.NOTHING, ExitCode.PLUGIN)
HEADINGS = ("", "scheme", "order", "noise", "error", "at", "steps", "work", "")
LEADING = "leading error"
UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"))
# Enough paths to distinguish the errors of schemes; for more paths, use --run.
PATHS = 2048
WIDEST = 1000
OF_A_RUN = ("schemes", "paths", "levels", "seed", "jobs", "progress")


@click.command(epilog=codes_in_words(*CODES), short_help="Find the scheme that needs the least work on a problem.")
@click.argument("problem", metavar="PROBLEM[PARAMETERS]", shell_complete=names_of("problems"))
@options.once("-m", "--measure", type=click.Choice(ERRORS), default=ERRORS[0], help="Kind of error.")
@options.once("--quantity", metavar="NAME", help="Component or observable.  [default: the first]")
@options.once("--accuracy", type=float, help="Error to reach.  [default: one that half of the schemes reach]")
@options.selected("-s", "schemes", f"Schemes. {options.SELECTION}")
@options.once(
    "--run", type=options.PLACE, metavar="DIR", help="Read errors and times from a finished run; run nothing."
)
@options.once("--paths", type=int, default=PATHS, help="Largest number of paths.")
@options.once(
    "--levels",
    metavar="COARSEST..FINEST",
    default="8..256",
    help="Smallest and largest number of steps; each level doubles it.",
)
@options.seed
@options.once("-j", "--jobs", type=click.IntRange(min=1), default=1, help="Worker processes.")
@options.progress_of_cells
@click.option("--json", "as_json", is_flag=True, help="For programs: an object with a list of schemes.")
@options.plugins
@click.pass_context
def choose(context: click.Context, /, problem: str, as_json: bool, **asked: Any) -> ExitCode:
    """Measure the errors of all schemes that solve PROBLEM, and sort them by the work for an accuracy.

    All errors refer to one reference, named in the last line: the solution on each path or, where it is not known,
    the best verified scheme at finer steps. Schemes with a refuted claim and negative controls are left out; schemes
    without a claim come last. The work is the time of the steps of a path, measured on this machine. The verdict is
    that on the claim of the scheme about these errors on this problem.
    """
    accuracy = nan if asked["accuracy"] is None else asked["accuracy"]
    if not (asked["accuracy"] is None or (isfinite(accuracy) and accuracy > 0.0)):
        raise UsageError(f"--accuracy expects the error to reach, a positive number, got {accuracy:g}")
    if any(letter in problem.partition("[")[0] for letter in ",*?"):
        raise UsageError(f"choose takes one problem, got {problem!r:.200}; sdaeverify list problems has their names")
    if asked["run"] is not None:
        _require_none_given(context)
    load_and_warn(asked["plugins"])
    with output_to_stderr():
        result = _result(problem, asked)
    label = _label(result, problem, alone=asked["run"] is None)
    with output_to_stderr():
        found = result.choose(label, asked["measure"], asked["quantity"] or "", accuracy, asked["progress"])
    code = ExitCode.OK if any(isfinite(one.seconds) for one in found.found) else ExitCode.NOTHING
    if as_json:
        print_json({**found.record, "reaching": int(code is ExitCode.OK)})
        return code
    _show(found, result)
    if code is ExitCode.NOTHING:
        what = f"{found.accuracy:g}" if isfinite(found.accuracy) else "any error"
        complain("error", f"no scheme is known to reach {what}; give more --paths or finer --levels")
    return code


def _require_none_given(context: click.Context) -> None:
    """Raise if an option of a run is given together with --run, where it would have no effect."""
    names = [name for name in OF_A_RUN if context.get_parameter_source(name) is ParameterSource.COMMANDLINE]
    if names:
        given = ", ".join(f"--{name}" for name in names)
        raise UsageError(f"contradictory options: --run only reads a finished run; leave out --run, or {given}")


def _result(problem: str, asked: dict[str, Any]) -> Result:
    if asked["run"] is not None:
        return load(asked["run"])
    numbers = {name: asked[name] for name in (*OF_A_RUN[1:], "plugins")}
    return verify(asked["schemes"], [problem], [asked["measure"]], **numbers)


def _label(result: Result, problem: str, *, alone: bool) -> str:
    """Return the label of a problem in a result: the given one, an equivalent one, or the only one."""
    labels = list(dict.fromkeys(row.problem for row in result.rows.verdicts))
    if problem in labels or not labels:
        return problem
    named = [label for label in labels if parse_label(label) == parse_label(problem)]
    return named[0] if named else labels[0] if alone and len(labels) == 1 else problem


def _show(found: Choices, result: Result) -> None:
    console = output()
    plain = console.options.ascii_only
    print_texts(console, wrap_text(visible(_heading(found)), console.width))
    known = any(one.leading for one in found.found)
    table = empty_table(*HEADINGS, *([LEADING] if known else []))
    table.columns[1].no_wrap = True
    least = min((one.seconds for one in found.found if isfinite(one.seconds)), default=nan)
    for one, following in zip_longest(found.found, found.found[1:]):
        ends = bool(one.claim and following and not following.claim)
        table.add_row(
            *(Text(visible(cell)) for cell in (*_cells(one, least, plain=plain), *([one.leading] if known else []))),
            style=SYMBOLS[one.verdict][2],
            end_section=ends,
        )
    # Names are not broken: a table may be wider than the terminal.
    natural = Measurement.get(console, console.options.update(max_width=WIDEST), table).maximum
    table.width = natural if natural > console.width else None
    console.print(table, crop=False)
    print_texts(console, (line for note in _notes(found, result) for line in wrap_text(visible(note), console.width)))


def _heading(found: Choices) -> str:
    what = f"{found.measure} {found.quantity}"
    size = (
        f" of {found.accuracy:g}, the least first" if isfinite(found.accuracy) else ": no error is clear of its noise"
    )
    return f"Which scheme for {found.problem}: work for an error of {what}{size}."


def _cells(one: Choice, least: float, *, plain: bool) -> Iterator[str]:
    yield mark(one.verdict, plain=plain)
    yield one.scheme
    yield f"{one.order:.2f}" if isfinite(one.order) else ""
    yield one.noise
    yield f"{one.error:.1e}" if isfinite(one.error) else ""
    yield f"{one.at:.0f}" if isfinite(one.at) else ""
    yield f"{'~' * one.beyond}{one.steps:.0f}" if isfinite(one.steps) else ""
    yield _time(one.seconds) if isfinite(one.seconds) else "unknown"
    yield f"x {one.seconds / least:.1f}" if isfinite(one.seconds) else ""


def _time(seconds: float) -> str:
    scale, unit = next(((s, u) for s, u in UNITS if seconds >= s), UNITS[-1])
    return f"{seconds / scale:.3g} {unit}"


def _views(found: Choices, result: Result) -> Iterator[str]:
    """Yield which schemes solve the problem in another form, such as one without the constraint."""
    here = [row for row in result.rows.verdicts if (row.problem, row.measure) == (found.problem, found.measure)]
    for view in sorted({row.view for row in here if row.view}):
        names = ", ".join(dict.fromkeys(row.scheme for row in here if row.view == view))
        yield f"solved as its {view}, not in its own form: {names}"


def _notes(found: Choices, result: Result) -> Iterator[str]:
    names = [one.scheme for one in found.found if one.verdict == "verified"]
    yield f"verified on {found.problem}: {', '.join(names) or 'none'}"
    if open_ := [one.scheme for one in found.found if one.verdict == "inconclusive"]:
        yield f"inconclusive: {', '.join(open_)}; sdaeverify matrix -p {found.problem} -m {found.measure} says why"
    if any(one.beyond for one in found.found):
        yield "~ number of steps by the order or, where paths show no error, by the leading error"
    if unknown := [one.scheme for one in found.found if not isfinite(one.seconds)]:
        yield f"work unknown, as {_why_unknown(found, result)}: {', '.join(unknown)}"
    if found.left_out:
        yield f"left out, with a refuted claim or as a negative control: {', '.join(found.left_out)}"
    yield from _views(found, result)
    here = (row for row in result.rows.absent if row["problem"] == found.problem and row["measure"] == found.measure)
    if others := len({row["scheme"] for row in here}):
        who = f"{counted(others, 'further scheme')} {'does' if others == 1 else 'do'}"
        yield f"{who} not solve it; sdaeverify matrix -p {found.problem} --dry-run says why"
    further = found.quantities[1:] if found.quantity == found.quantities[0] else found.quantities[:1]
    if further:
        yield f"other quantities, for --quantity: {', '.join(further)}"
    if any(one.leading for one in found.found):
        yield f"{LEADING}: C h^p of the mean as h falls, without sampling"
    yield from _legend(found)


def _why_unknown(found: Choices, result: Result) -> str:
    if not (found.reference or found.measure == STATIONARY or not result.results):
        return f"{found.problem} has no pathwise truth, and no verified scheme can be its reference"
    why = f"errors are within their noise, or need more than {FARTHEST} times the finest steps"
    return why if result.results else f"{why}, or are errors to the limit of a scheme that is not verified"


def _legend(found: Choices) -> Iterator[str]:
    steps = "steps a unit of time" if found.measure == STATIONARY else "steps on a path"
    if found.measure == STATIONARY:
        yield "errors: relative to the exact stationary mean"
    elif found.reference:
        yield f"errors: to {found.reference}"
    else:
        yield "errors: those of the run, to the solution or to the limit of a verified scheme"
    yield f"error: with the number of steps in the column 'at' ({steps}); work: time of the steps, measured here"
