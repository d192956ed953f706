"""``check``: run the conformance kit on schemes and problems."""

from collections import Counter
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from typing import Any

import click
from rich.text import Text

from ...contracts.labels import parse_label, split_list
from ...contracts.spelling import counted, did_you_mean
from ...errors import UsageError
from ...registry.load import Registry
from ...registry.selection import select_problems, select_schemes
from ...report.cells import grouped
from ...report.plain import fits_width, text_table, visible, wrap_text
from ...testing.questions import Question, Row, problem_questions, scheme_questions
from ...testing.subjects import ProblemSubject, SchemeSubject
from ..completion import names_of
from ..console import output, output_to_stderr, print_json, print_texts
from ..exit_codes import ExitCode, codes_in_words
from ..loading import load_and_warn
from ..options import plugins

CODES = (ExitCode.OK, ExitCode.REFUTED, ExitCode.USAGE, ExitCode.PLUGIN)
LISTED = "; sdaeverify list shows all"
STYLES = {"passed": "green", "failed": "bold red", "skipped": "dim"}


@click.command(epilog=codes_in_words(*CODES), short_help="Run the conformance checks on schemes and problems.")
@click.argument(
    "names", metavar="NAME[PARAMETERS]...", nargs=-1, required=True, shell_complete=names_of("schemes", "problems")
)
@click.option(
    "-p", "--problems", multiple=True, help="Problems on which schemes are checked.  [default: three small ones]"
)
@click.option("--level", type=int, help="Run the checks up to this level of the kit.  [default: all]")
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each answer.")
@plugins
def check(**options: Any) -> ExitCode:
    """Run every check of the conformance kit on schemes and problems: contract, derivatives, truths, controls.

    NAME is a scheme or a problem, with parameters or as a glob. Prints the checks that did not pass, and
    counts the others.
    """
    registry = load_and_warn(options["plugins"])
    with output_to_stderr():
        questions = list(_questions(registry, options["names"], options["problems"] or None, options["level"]))
        rows = [question.answer() for question in questions]
    if options["as_json"]:
        print_json(rows)
    else:
        _show(rows)
    return ExitCode.REFUTED if any(row["status"] == "failed" for row in rows) else ExitCode.OK


def _questions(
    registry: Registry, names: Sequence[str], problems: Sequence[str] | None, level: int | None
) -> Iterable[Question]:
    patterns = [each for name in names for each in split_list(name)]
    if not patterns:
        raise UsageError(f"empty selection of schemes and problems: {' '.join(names)!r}")
    for pattern in patterns:
        for kind in _kinds(registry, pattern):
            if kind == "scheme":
                for scheme in select_schemes(registry, pattern):
                    yield from scheme_questions(SchemeSubject(scheme, registry), problems, level)
            else:
                for spec in select_problems(registry, pattern):
                    yield from problem_questions(ProblemSubject(spec, registry), level)


def _kinds(registry: Registry, pattern: str) -> list[str]:
    name = parse_label(pattern).name
    kinds = {"scheme": registry.schemes, "problem": registry.problems}
    found = [kind for kind, entries in kinds.items() if any(fnmatchcase(known, name) for known in entries)]
    if not found:
        known = [other for entries in kinds.values() for other in entries]
        raise UsageError(f"no scheme or problem is named {name!r}{did_you_mean(name, known) or LISTED}")
    return found


def _different(rows: Iterable[Row]) -> Iterable[tuple[Row, int]]:
    """Group rows with the same subject, status and reason: return the first of each group and its size."""
    found = grouped(rows, lambda row: (row["subject"], row["status"], row["reason"]))
    return [(same[0], len(same)) for same in found.values()]


def _show(rows: list[Row]) -> None:
    console, cells = output(unbroken=True), []
    for row, count in _different(row for row in rows if row["status"] != "passed"):
        more = f" and {count - 1} more" if count > 1 else ""
        status = Text(str(row["status"]), style=STYLES[str(row["status"])])
        cells.append((status, row["subject"], f"{row['check']}{more}", row["problem"], row["reason"]))
    if cells:
        table = text_table(("", "subject", "check", "problem", "reason"), cells)
        if fits_width(console, table):
            console.print(table)
        else:
            print_texts(console, (line for each in cells for line in _paragraph(each, console.width)))
        console.print()
    counts = Counter(str(row["status"]) for row in rows)
    words = ", ".join(f"{counts[status] or 'none'} {status}" for status in STYLES)
    style = "red" if counts["failed"] else "green"
    console.print(f"{counted(len(rows), 'check')}: {words}", style=style, soft_wrap=True)


def _paragraph(cells: tuple[Text, object, str, object, object], width: int) -> list[Text]:
    """Return the cells of a row as a sentence, wrapped between words, with the style of its first word."""
    status, subject, check, problem, reason = cells
    place = f" on {problem}" if problem else ""
    lines = [*map(Text, wrap_text(visible(f"{status} {subject}{place}, {check}: {reason}"), width, "    "))]
    lines[0].stylize(status.style, 0, len(status))
    return lines
