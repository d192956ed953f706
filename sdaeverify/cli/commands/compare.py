"""``compare``: whether errors have grown from one run to another, order kept or not."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..console import complain, conclude, output, output_to_stderr, print_texts
from ..exit_codes import ExitCode, codes_in_words
from ..loading import load_and_warn
from ..options import PLACE, once, plugins

if TYPE_CHECKING:
    from ...report.compare.cells import Omitted
    from ...report.compare.changes import Rows

MARGIN, ALPHA = 1.1, 0.01
WORDS = {
    ExitCode.OK: "no error has grown by more than the factor, as far as can be told",
    ExitCode.REFUTED: "an error has grown by more than the factor",
    ExitCode.USAGE: "the command line is wrong, or the runs share no noise",
    ExitCode.NOTHING: "the runs have nothing in common that could be compared",
    ExitCode.PLUGIN: "a requested plugin failed to load",
}


@click.command(epilog=codes_in_words(WORDS), short_help="Tell whether errors have grown from one run to another.")
@click.argument("old", type=PLACE)
@click.argument("new", type=PLACE)
@once("--factor", type=float, default=MARGIN, help="By how much an error may grow.")
@once("--alpha", type=float, default=ALPHA, help="Probability of any false alarm in the comparison.")
@click.option("--all", "every", is_flag=True, help="Show what is the same, too.")
@once("--html", type=PLACE, help="File for a page with all quantities.")
@click.option("--json", "as_json", is_flag=True, help="For programs: an object with all quantities.")
@plugins
def compare(**options: Any) -> ExitCode:
    """Compare the errors of two runs, folders OLD and NEW that matrix or gate wrote with --out, on common noise.

    An order may be kept while errors double. On the same paths the ratio of errors is known far better than errors
    are, so that this shows with few paths. Both runs need the same seed, step sizes and problems; their schemes are
    what may differ. Components are named by what is installed now.
    """
    # Evidence is read with numpy, which the other commands do without until they run.
    from ...report.compare.cells import compare as compared  # noqa: PLC0415
    from ...report.compare.changes import changes  # noqa: PLC0415
    from ...report.compare.runs import damages, read_run  # noqa: PLC0415

    changes([], options["factor"], options["alpha"])
    old, new = read_run(options["old"]), read_run(options["new"])
    for run in (run for run in (old, new) if run.damaged):
        complain("warning", f"{damages(run.folder, run.damaged)} and left out")
    registry = load_and_warn(options["plugins"])
    with output_to_stderr():
        found, omitted = compared(old, new, registry)
    judged = changes([each.found for each in found], options["factor"], options["alpha"])
    rows = list(zip(found, judged, strict=True))
    code = _code(rows)
    if options["html"] is not None:
        _write_page(rows, options["html"])
    if options["as_json"]:
        click.echo(_json(rows, omitted, options, code))
    else:
        _show(rows, omitted, every=options["every"])
        conclude(code, WORDS)
    return code


def _write_page(rows: "Rows", file: Path) -> None:
    from ...report.compare.changes import counts, records  # noqa: PLC0415
    from ...report.files import require_writable_file  # noqa: PLC0415
    from ...report.html import TablePage, write_tables  # noqa: PLC0415

    require_writable_file(file, "--html")
    told = records(rows)
    table = [["" if cell is None else str(cell) for cell in record.values()] for record in told]
    write_tables(file, counts(rows), [TablePage("Comparison", list(told[0]) if told else [], table)])


def _code(rows: "Rows") -> ExitCode:
    if not rows:
        complain("error", "nothing to compare: the runs have no quantity in common")
        return ExitCode.NOTHING
    return ExitCode.REFUTED if any(changed.change == "worse" for _, changed in rows) else ExitCode.OK


def _json(rows: "Rows", omitted: "list[Omitted]", options: dict[str, Any], code: ExitCode) -> str:
    from ...report.compare.changes import records  # noqa: PLC0415

    about = {"old": str(options["old"]), "new": str(options["new"])}
    about |= {name: options[name] for name in ("factor", "alpha")}
    found = {"quantities": records(rows), "omitted": [each._asdict() for each in omitted]}
    return json.dumps({**about, "exit_code": code.value, **found}, indent=2)


def _show(rows: "Rows", omitted: "list[Omitted]", *, every: bool) -> None:
    from ...report.compare.changes import comparison_table, counts, list_omissions  # noqa: PLC0415

    console = output(unbroken=True)
    if shown := [row for row in rows if every or row[1].change != "same"]:
        console.print(comparison_table(shown))
        console.print()
    print_texts(console, (*list_omissions(omitted), counts(rows)))
