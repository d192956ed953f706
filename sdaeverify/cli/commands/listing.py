"""``list`` and ``info``: what is registered, and all that is known of it."""

import json
from collections.abc import Mapping

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ...contracts.labels import did_you_mean, parse_label
from ...errors import UsageError
from ...registry import contributions
from ...registry.load import Registry
from ...report.passports import Passport, measure_passport, problem_passport, scheme_passport
from ...report.plain import empty_table, visible
from ..concepts import concept_names, describe_concept
from ..console import aside, output
from ..exit_codes import ExitCode
from ..loading import registered
from ..options import plugins
from .catalogue import Record, catalogue
from .describe import built, describe_entry, describe_plugin

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
    """List what is registered: schemes, problems, measures or plugins; everything without KIND."""
    registry = registered(plugins, lab=as_json or kind == "plugins")
    with aside():
        records = catalogue(registry)
    if as_json:
        click.echo(json.dumps(records[kind] if kind else records, indent=2))
        return ExitCode.OK
    console = output(unbroken=True)
    for name in [kind] if kind else KINDS:
        console.print(_table(name, records[name]))
        if not kind:
            console.print()
    return ExitCode.OK


@click.command(short_help="Tell all about one of them.")
@click.argument("name", metavar="NAME[PARAMETERS]")
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each kind of thing.")
@plugins
def info(name: str, plugins: tuple[str, ...], as_json: bool) -> ExitCode:
    """Tell all about a scheme, a problem, a measure or a plugin: equations, claims, truths, sources.

    Or about a word: a form such as SDE, traits, noise, claims, measures.
    """
    registry, label = registered(plugins), parse_label(name)
    if label.name not in _names(registry):
        registry = registered(plugins, lab=True)
    rows, known = {row.name: row for row in registry.plugins}, _names(registry)
    if label.name not in known:
        raise UsageError(
            f"no scheme, problem, measure or plugin is named {label.name!r}{did_you_mean(label.name, known)}"
        )
    if as_json:
        with aside():
            records = _passports(registry, label.name, label.parameters or {})
            if label.name in concept_names(registry):
                records.append({"kind": "word", "text": "\n".join(describe_concept(label.name, registry))})
        click.echo(json.dumps([*records, *([rows[label.name]._asdict()] if label.name in rows else [])], indent=2))
        return ExitCode.OK
    with aside():
        sections = _sections(registry, label.name, label.parameters or {})
        if label.name in concept_names(registry):
            sections.append(describe_concept(label.name, registry))
    if label.name in rows:
        sections.append(describe_plugin(rows[label.name]))
    _print(output(), sections)
    return ExitCode.OK


def _names(registry: Registry) -> set[str]:
    kinds = (registry.schemes, registry.problems, registry.measures, [row.name for row in registry.plugins])
    return {name for kind in kinds for name in kind} | concept_names(registry)


def _sections(registry: Registry, name: str, texts: Mapping[str, str]) -> list[list[str]]:
    found = (kind.get(name) for kind in (registry.schemes, registry.problems, registry.measures))
    return [describe_entry(entry, texts) for entry in found if entry is not None]


def _passports(registry: Registry, name: str, texts: Mapping[str, str]) -> list[Passport]:
    """Return what is known of a name as records: of a scheme, a problem and a measure, as far as it names one."""
    found: list[Passport] = []
    if name in registry.schemes:
        found.append({"kind": "scheme", **scheme_passport(registry.schemes[name].make(texts))})
    if name in registry.problems:
        spec = registry.problems[name].make(texts)
        found.append({"kind": "problem", **problem_passport(spec, built(spec.label, spec.build, given=bool(texts)))})
    if name in registry.measures:
        found.append({"kind": "measure", **measure_passport(registry.measures[name].measure)})
    return found


def _print(console: Console, sections: list[list[str]]) -> None:
    for number, lines in enumerate(sections):
        if number:
            console.print()
        console.print(Text(visible(lines[0]), style="bold"), soft_wrap=True)
        for line in lines[1:]:
            console.print(Text(visible(line)), soft_wrap=True)


def _table(kind: str, records: list[Record]) -> Table:
    table = empty_table(*(kind if column == "name" else column for column in COLUMNS[kind]))
    for record in records:
        table.add_row(*(Text(visible(_text(record, column))) for column in COLUMNS[kind]))
    return table


def _text(record: Record, column: str) -> str:
    if column == "parameters":
        return ", ".join(f"{name}={_word(default)}" for name, default in record["parameters"].items())
    if column == "registers":
        counts = ((record[kind], word) for kind, word in contributions.KINDS.items())
        return ", ".join(f"{count} {word}{'s' * (count > 1)}" for count, word in counts if count)
    return str(record[column])


def _word(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
