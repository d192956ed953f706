"""``list``: print registered entries."""

import math
from collections.abc import Iterator
from typing import Any

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ...contracts.scheme import form_names
from ...registry.contributions import Registered, word_of
from ...registry.discovery import OWN_DISTRIBUTION, normalise
from ...registry.load import Registry
from ...report.passports import docstring
from ...report.plain import fits_width, text_table, wrap_text
from ..console import output, output_to_stderr, print_json, print_texts
from ..exit_codes import ExitCode
from ..loading import load_quietly
from ..options import plugins

Record = dict[str, Any]
KINDS = ("schemes", "problems", "measures", "plugins")
COLUMNS = {
    "schemes": ("name", "parameters", "form", "summary", "plugin"),
    "problems": ("name", "parameters", "summary", "plugin"),
    "measures": ("name", "summary", "plugin"),
    "plugins": ("name", "distribution", "version", "status", "registers", "reason"),
}


@click.command(name="list", short_help="List what is registered.")
@click.argument("kind", metavar="[KIND]", type=click.Choice(KINDS), required=False)
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, or one list for each kind.")
@plugins
def listing(kind: str | None, as_json: bool, plugins: tuple[str, ...]) -> ExitCode:
    """List registered schemes, problems, measures or plugins; everything without KIND."""
    registry = load_quietly(plugins, lab=as_json or kind == "plugins")
    with output_to_stderr():
        records = catalogue(registry)
    if as_json:
        print_json(records[kind] if kind else records)
        return ExitCode.OK
    console = output(unbroken=True)
    for name in [kind] if kind else KINDS:
        _print(console, name, records[name])
        if not kind:
            console.print()
    return ExitCode.OK


def _print(console: Console, kind: str, records: list[Record]) -> None:
    """Print a table, or a paragraph for each record if the console is too narrow for the table."""
    table = _table(kind, records)
    if fits_width(console, table):
        console.print(table)
        return
    console.print(Text(f"{kind}: {len(records)}", style="bold"))
    for record in records:
        aside = ", ".join(filter(None, [record.get("form"), record.get("status"), _registers(record)]))
        lines = wrap_text(f"{record['name']}{f' ({aside})' if aside else ''}", console.width)
        lines += [line for about in _about(record) for line in _indented(about, console.width)]
        print_texts(console, lines)


def _about(record: Record) -> Iterator[str]:
    """Yield the sentences of a paragraph on a record; the plugin only if it is not shipped with this package."""
    if record["kind"] == "plugin":
        yield from filter(None, [record["reason"]])
    else:
        yield from filter(None, [_text(record, "summary")])
        if record["parameters"]:
            yield f"parameters: {_text(record, 'parameters')}"
    if normalise(record["distribution"]) != OWN_DISTRIBUTION:
        owner = f"{record['distribution']} {record['version']}".strip() or record.get("module", "")
        yield f"from {owner}" if record["kind"] == "plugin" else f"from plugin {record['plugin']} {owner}".rstrip()


def _indented(text: str, width: int) -> list[str]:
    indent = "    "
    return [f"{indent}{line}" for line in wrap_text(text, width - len(indent))]


def _table(kind: str, records: list[Record]) -> Table:
    headings = [kind if column == "name" else column for column in COLUMNS[kind]]
    return text_table(headings, ([_text(record, column) for column in COLUMNS[kind]] for record in records))


def _text(record: Record, column: str) -> str:
    if column == "parameters":
        return ", ".join(f"{name}={_word(default)}" for name, default in record["parameters"].items())
    if column == "registers":
        return _registers(record)
    if column == "summary" and record.get("on_request"):
        return f"{record[column]} (run on request)"
    return str(record[column])


def _registers(record: Record) -> str:
    """Return the numbers of names that a plugin registers; empty for other records."""
    if record["kind"] != "plugin":
        return ""
    counts = [*((f"sdaeverify_{kind}", record[kind]) for kind in KINDS[:3]), *record["further"]]
    words = ((count, word_of(hook) if count == 1 else hook.partition("_")[2]) for hook, count in counts)
    return ", ".join(f"{count} {word}" for count, word in words if count)


def _word(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def catalogue(registry: Registry) -> dict[str, list[Record]]:
    """Return the records of each kind, sorted by name; plugins in the order of loading."""
    return {
        "schemes": [_record("scheme", entry) for entry in registry.schemes.values()],
        "problems": [_record("problem", entry) for entry in registry.problems.values()],
        "measures": [_record("measure", entry) for entry in registry.measures.values()],
        "plugins": [{"kind": "plugin", **row._asdict()} for row in registry.plugins],
    }


def _record(kind: str, entry: Registered) -> Record:
    lines = docstring(entry.subject).splitlines()
    return {
        "kind": kind,
        "name": entry.name,
        "parameters": {parameter.name: _plain(parameter.default) for parameter in entry.parameters},
        "summary": lines[0] if lines else "",
        **({"form": form_names(entry.thing)} if kind == "scheme" else {}),
        **({} if kind == "measure" else {"on_request": entry.on_request}),
        "plugin": entry.origin.plugin,
        "distribution": entry.origin.distribution,
        "version": entry.origin.version,
    }


def _plain(default: Any) -> Any:
    # JSON has neither infinity nor NaN.
    return str(default) if isinstance(default, float) and not math.isfinite(default) else default
