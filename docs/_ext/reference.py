"""The reference: the command line, exit codes, hooks, entry points, public names."""

import textwrap
import tomllib
from collections.abc import Callable
from pathlib import Path

import click
from markup import page, prose, table, verbatim

import sdaeverify as package
from sdaeverify.cli.commands.info import concept_names, describe_concept
from sdaeverify.cli.exit_codes import ExitCode
from sdaeverify.cli.program import sdaeverify as cli
from sdaeverify.forms import known_traits
from sdaeverify.registry import hookspecs
from sdaeverify.registry.load import load_registry
from sdaeverify.report.tables.columns import dictionary

WIDTH = 110


def reference_pages() -> dict[str, str]:
    """Return the pages by name."""
    return {
        "command-line.md": command_line(),
        "exit-codes.md": exit_codes(),
        "columns.md": columns(),
        "hooks.rst": hooks(),
        "entry-points.md": entry_points(),
        "traits.md": traits(),
        "forms.md": words("Forms", _is_form),
        "words.md": words(
            "Claims, noise and measures in words", lambda name: name in {"claims", "noise", "measures"}
        ),
    }


def _is_form(name: str) -> bool:
    found = getattr(package, name, None) if name in package.__all__ else None
    return isinstance(found, type) and issubclass(found, package.Problem)


def command_line() -> str:
    """Return the help of every command."""
    parent = click.Context(cli, info_name="sdaeverify", max_content_width=100, terminal_width=100)
    names = cli.list_commands(parent)
    told = "Each command has `--help`. The shell completes names and options: [](../install.md)."
    return page("Command line", told, *(_command(name, parent) for name in names))


def _command(name: str, parent: click.Context) -> str:
    command = cli.get_command(parent, name)
    assert command is not None
    told = command.get_help(click.Context(command, info_name=name, parent=parent))
    example = f"For example:\n\n{verbatim(f'sdaeverify {EXAMPLES[name]}', 'sh')}"
    return f"## sdaeverify {name}\n\n{example}\n{verbatim(told)}"


EXAMPLES = {
    "adaptive": "adaptive adaptive-heun -p ou --json",
    "calibrate": "calibrate --repetitions 100 --only slope",
    "check": "check milstein gbm --json",
    "choose": "choose gbm -m strong --accuracy 0.01",
    "cite": "cite reports/latest --table latex",
    "claims": "claims milstein reports/latest",
    "compare": "compare before after --factor 1.2",
    "demo": "demo --out demo",
    "gate": "gate --tier smoke --seed-from date",
    "hunt": "hunt milstein -m strong --when scalar-noise --examples 50 --out found.py",
    "info": "info HolonomicSDAE",
    "init": "init my-solvers",
    "list": "list schemes --json",
    "matrix": "matrix -s 'milstein,euler-*' -p gbm,ou -m strong --paths 2048 --lf -x",
    "merge": "merge shard1 shard2 --out whole",
    "new-plugin": "new-plugin my-schemes",
    "orders": "orders sra1 --class additive",
    "reproduce": "reproduce 'lindner-*' --budget smoke",
    "sealed": "sealed own-euler -p ou --json",
    "selftest": "selftest --only 'planted-*'",
    "show": "show reports/latest milstein gbm",
    "wire": "wire --check ./my_solver",
}


def words(title: str, chosen: Callable[[str], bool]) -> str:
    """Return a section for each word that ``info`` explains and that is chosen."""
    registry = load_registry(environ={})
    names = sorted(filter(chosen, concept_names(registry)))
    sections = (f"## {name}\n\n{verbatim(_wrapped(describe_concept(name, registry)))}" for name in names)
    told = ", ".join(f"`sdaeverify info {name}`" for name in names)
    return page(title, f"In a terminal: {told}.", *sections)


def _wrapped(lines: list[str]) -> str:
    """Return text of which no line is wider than a page."""
    return "\n".join(row for line in lines for row in textwrap.wrap(line, WIDTH, subsequent_indent="  ") or [""])


def exit_codes() -> str:
    """Return a section for each exit code."""
    sections = (f"## Exit code {code.value}: {code.words}\n" for code in ExitCode)
    told = "Each exit code has one meaning. The last line of a run prints the code with its meaning."
    return page("Exit codes", told, *sections)


def columns() -> str:
    """Return a table for each file of a run."""
    files: dict[str, list[dict[str, str]]] = {}
    for row in dictionary(entry.thing for entry in load_registry(environ={}).measures.values()):
        files.setdefault(row["file"], []).append(row)
    sections = (
        f"## {file}\n\n"
        + table(
            ["column", "meaning", "kind", "unit"],
            ([f"`{row['column']}`", prose(row["meaning"]), row["kind"], prose(row["unit"])] for row in rows),
        )
        for file, rows in files.items()
    )
    return page("Columns of the files", "Each run writes the same to `columns.csv`.", *sections)


def hooks() -> str:
    """Return the hooks from their specifications."""
    names = [name for name in vars(hookspecs) if name.startswith("sdaeverify_")]
    lines = ["Hooks", "=====", "", ".. automodule:: sdaeverify.registry.hookspecs", "   :no-members:", ""]
    return "\n".join([*lines, *(f".. autofunction:: sdaeverify.registry.hookspecs.{name}\n" for name in names)])


def entry_points() -> str:
    """Return the groups of entry points with what this distribution names in them."""
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    groups = project["entry-points"] | {"console_scripts": project["scripts"]}
    sections = (
        f"## {group}\n\n{GROUPS.get(group, '')}\n\n" + table(["name", "object"], sorted(names.items()))
        for group, names in groups.items()
    )
    return page("Entry points", "The groups of entry points, and those of this distribution.", *sections)


GROUPS = {
    "sdaeverify": "Modules with hooks. In a package, each module without a leading underscore is a plugin.",
    "sdaeverify.lab": "Modules whose hooks are loaded only by some commands.",
    "sdaeverify.hooks": "Hooks defined by plugins, with the class of their results.",
    "sdaeverify.commands": "Commands of click.",
    "sdaeverify.classes": "Tests of claims about classes of equations: a `sdaeverify.studying.ClassTests`.",
    "sdaeverify.hunts": "The search of a gate for counterexamples: a function that returns its part of `gate.json`.",
    "sdaeverify.functions": "Functions that are attributes of `sdaeverify`.",
    "sdaeverify.executors": "Context managers that yield an executor for `--executor NAME`.",
    "console_scripts": "The command.",
}


def traits() -> str:
    """Return the traits and what they mean."""
    rows = ([f"`{name}`", prose(trait.meaning)] for name, trait in sorted(known_traits().items()))
    told = "A trait is a property of a problem. A claim applies to problems that have the traits in its `when=`."
    asked = "`sdaeverify info traits` also shows which schemes ask for each."
    return page("Traits", told, asked, table(["trait", "meaning"], rows))
