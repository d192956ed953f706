"""Commands of plugins: entry points of the group ``sdaeverify.commands``."""

import pytest

COMMANDS = """
import click

from sdaeverify.commands import ExitCode, load_and_warn, options, output, print_texts


@click.command(short_help="Count the schemes.")
@options.plugins
def count(plugins):
    print_texts(output(), [f"{len(load_and_warn(plugins).schemes) > 0} schemes"])
    return ExitCode.OK


odd = "no command"
"""


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Install a distribution with three commands, of which one works."""
    about = tmp_path / "fake_commands-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: fake-commands\nVersion: 1.0\n", encoding="utf-8")
    leads = {"count": "fake_commands:count", "gone": "fake_nowhere:gone", "odd": "fake_commands:odd"}
    lines = ["[sdaeverify.commands]", *(f"{name} = {place}" for name, place in leads.items())]
    (about / "entry_points.txt").write_text("\n".join(lines), encoding="utf-8")
    (tmp_path / "fake_commands.py").write_text(COMMANDS, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)


def test_a_command_of_a_plugin_is_one_of_the_program(call, installed):
    """It runs, and stands in the help with its line."""
    assert (call("count").code, call("count").out) == (0, "True schemes\n")
    assert "count       Count the schemes." in call("--help").out


def test_a_broken_command_costs_a_line(call, installed):
    """The help warns of each that is broken, and lists the others; who asks for one is told why."""
    outcome = call("--help")

    assert outcome.code == 0
    assert [line.partition(" of plugin ")[0] for line in outcome.err.splitlines()] == [
        "sdaeverify: warning: command gone", "sdaeverify: warning: command odd",
    ]  # fmt: skip
    assert {line.split()[0] for line in outcome.out.splitlines() if line.startswith("  ")} >= {"matrix", "selftest"}
    assert call("gone").code == 6
    assert "command odd of plugin odd (fake-commands 1.0) is broken: expected a click command" in call("odd").err


def test_a_disabled_distribution_has_no_commands(call, installed, monkeypatch):
    """Its commands are unknown, as its schemes would be."""
    monkeypatch.setenv("SDAEVERIFY_DISABLED_PLUGINS", "fake-commands")

    assert call("count").code == 2
