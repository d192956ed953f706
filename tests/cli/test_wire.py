"""The command ``wire``, and programs among the schemes of other commands."""

import shlex
import sys
from pathlib import Path

import pytest

from facade import ExitCode
from wire import faulty
from wire.compiling import CLIENTS, built_c

FAULTY = shlex.join([sys.executable, "-I", "-S", faulty.__file__])


@pytest.fixture
def plugin(tmp_path):
    """Return a function that writes the plugin file of a program with a fault, or of several programs."""

    def write(*commands):
        file = tmp_path / "wired.py"
        listed = ", ".join(map(repr, commands))
        file.write_text(f"from sdaeverify_wire import schemes\nsdaeverify_schemes = schemes({listed}, patience=2)\n")
        return str(file)

    return write


def test_check_says_what_a_program_has(call, tmp_path):
    """Each property is a line, and the option with which commands take the program is printed."""
    command = shlex.join(built_c(tmp_path, "golden_euler"))
    code, out, err = call("wire", "--check", command, "--golden")

    assert (code, err) == (ExitCode.OK, "")
    assert "transcript: 10 answers are those of the golden transcript\n" in out
    assert "hello: golden-euler for SDE, given dW\n" in out
    assert "steps: equal with 1, 3, 5000 paths\n" in out
    assert out.endswith(f"commands take it with --wire: sdaeverify matrix --wire {command}\n")


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("fault", "line"),
    [
        (
            "big-endian",
            "speaks version 3.03865e-319 of the wire, expected 1: its numbers are big-endian, expected lit",
        ),
        ("words on stderr", "ended with exit code 4; its stderr ends: first line | cannot find licence\n"),
        ("answers twice", "after its answer or before its request was whole\n"),
        ("a row too many", "sent 'done x="),
        ("silent in a step", "has not answered for 2 s (patience)\n"),
        ("not a number", "faulty: a step of a trivial problem is not finite\n"),
    ],
)
def test_check_of_a_faulty_program_is_one_line(call, fault, line):
    """The first property that it has not is one line on stderr."""
    # On a machine that is busy with other tests, a program takes seconds to start.
    patience = "2" if "silent" in fault else "120"
    code, _, err = call("wire", "--check", f"{FAULTY} {shlex.quote(fault)}", "--patience", patience)

    assert code == ExitCode.NOT_MEASURED
    assert line in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("given", [(), ("--check", "true", "--client", "c")], ids=["neither", "both"])
def test_check_or_client(call, given):
    """One of the two is asked for."""
    code, _, err = call("wire", *given)

    assert code == ExitCode.USAGE
    assert "wire expects --check COMMAND or --client LANGUAGE, one of them" in err


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("./nothing", "no program './nothing' that can be run: expected a path, or a name in PATH"),
        (".", "no program '.' that can be run: expected a path, or a name in PATH"),
        ("localhost:1", "no program 'localhost:1' that can be run: expected unix:PATH or tcp:localhost:PORT"),
        ("", "cannot read '' as a program with its arguments: it is empty"),
        ("true 'a", 'cannot read "true \'a" as a program with its arguments: No closing quotation'),
    ],
)
def test_program_that_is_not_there(call, command, told):
    """A command that cannot be run is told by its words."""
    code, _, err = call("wire", "--check", command)

    assert code == ExitCode.USAGE
    assert err == f"sdaeverify: error: {told}\n"


def test_clients_are_printed_as_they_are(call):
    """A client is its file, to the last byte."""
    assert call("wire", "--client", "c").out == (CLIENTS / "sdaeverify.h").read_text()


def test_plugin_with_a_faulty_program_is_one_line(call, plugin):
    """A program that says no proper hello is a plugin that cannot be loaded."""
    code, _, err = call("matrix", "--plugin", plugin(f"{FAULTY} silent"), "-s", "faulty", "-p", "gbm", "--out", "o")

    assert code == ExitCode.PLUGIN
    assert "has not answered for 2 s" in err
    assert err.count("\n") == 1


@pytest.mark.long
@pytest.mark.parametrize(
    ("fault", "told"),
    [
        ("dies in a step", "ended with signal 9"),
        pytest.param("silent in a step", "has not answered for 2 s", marks=pytest.mark.slow),
        pytest.param("a row too many", "sent 'done x=2x", marks=pytest.mark.slow),
    ],
)
def test_fault_costs_its_own_rows_alone(call, plugin, fault, told):
    """A program that dies, stops or answers nonsense in a step has errors; schemes beside it have their verdicts."""
    command = f"{FAULTY} {shlex.quote(fault)}"
    given = ("--plugin", plugin(command), "-s", "faulty,euler-maruyama", "-p", "gbm", "-m", "strong")
    code, _, _ = call("matrix", *given, "--paths", "1024", "--progress", "none", "--out", fault)

    rows = Path(fault, "verdicts.csv").read_text().splitlines()
    mine, other = ([row for row in rows if name in row] for name in ("faulty", "euler-maruyama"))
    assert code == ExitCode.NOT_MEASURED
    assert all("error" in row and told in row for row in mine)
    assert mine
    assert any("verified" in row for row in other)
