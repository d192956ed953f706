"""Programs as schemes without a plugin file: the option ``--wire`` and the table of a policy."""

import csv
import json
import re
import shlex
import sys
from pathlib import Path

import pytest

from facade import ExitCode
from wire import faulty
from wire.compiling import built_c, with_python

FAULTY = shlex.join([sys.executable, "-I", "-S", faulty.__file__])
QUICK = ("-p", "gbm", "-m", "strong", "--paths", "256", "--levels", "8..32", "--progress", "none")
# Each line begins a problem of a command, before any program speaks.
NO_PROGRAM = {
    "./nothing": "no program './nothing' that can be run: expected a path, or a name in PATH",
    "./plain": "no program './plain' that can be run: the file is not executable: chmod +x ./plain",
    "plain": "no program 'plain' that can be run: expected a path with a slash, such as ./plain",
    "": "cannot read '' as a program with its arguments: it names no program",
    "patience=5": "cannot read 'patience=5' as a program with its arguments: it names no program",
    "'a": 'cannot read "\'a" as a program with its arguments: No closing quotation',
    "patience=soon true": "patience of a program expects a number of seconds, got 'soon'",
    "tcp:example.org:80": "cannot connect to 'tcp:example.org:80': expected unix:PATH or tcp:localhost:PORT",
}
NO_HELLO = {
    f"patience=0.5 {FAULTY} silent": "has not answered for 0.5 s (patience)",
    "true": "--wire true ended with exit code 0",
    f"name=mine {FAULTY}": "its hello names it 'faulty', expected 'mine'",
    "unix:/no/such/socket": "unix:/no/such/socket cannot be reached: No such file or directory",
}


@pytest.mark.parametrize("given", NO_PROGRAM)
@pytest.mark.parametrize("command", [("matrix",), ("orders", "x"), ("check", "x"), ("hunt", "x"), ("gate",)])
def test_command_that_names_no_program_is_one_line(call, given, command):
    """What cannot be run is told by its words, whatever the command."""
    Path("plain").touch()
    code, out, err = call(*command, "--wire", given)

    assert (code, out, err) == (ExitCode.USAGE, "", f"sdaeverify: error: {NO_PROGRAM[given]}\n")


@pytest.mark.parametrize("given", NO_HELLO)
def test_program_without_a_hello_is_one_line(call, given):
    """A program that hangs, ends or has another name is not registered."""
    code, out, err = call("matrix", "--wire", given)

    assert (code, out) == (ExitCode.PLUGIN, "")
    assert NO_HELLO[given] in err
    assert err.count("\n") == 1


def test_programs_are_the_selection(call):
    """Without -s the schemes of a run are the programs that are named; with -s others are beside them."""
    alone = call("matrix", "--wire", FAULTY, "-p", "gbm", "--dry-run").out
    beside = call("matrix", "--wire", FAULTY, "-s", "faulty,milstein", "-p", "gbm", "--dry-run").out

    assert "faulty" in alone
    assert "milstein" not in alone
    assert "milstein" in beside


def test_the_same_name_twice_is_one_line(call):
    """Two programs of one name cannot both be registered."""
    code, _, err = call("matrix", "--wire", FAULTY, "--wire", f"patience=9 {FAULTY}")

    assert code == ExitCode.PLUGIN
    assert "scheme 'faulty' of plugin wire" in err
    assert err.count("\n") == 1


def verdicts(folder):
    """Return the outcomes of a run."""
    with Path(folder, "verdicts.csv").open() as file:
        return [[row[name] for name in ("scheme", "problem", "quantity", "verdict")] for row in csv.DictReader(file)]


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize(
    "jobs", [("-j", "2"), ("-j", "1", "--timeout", "0", "--memory", "0")], ids=["2", "in process"]
)
def test_row_says_how_it_is_computed_again(call, tmp_path, monkeypatch, jobs):
    """The command of a row, given in another folder, comes to the same verdict; so do the workers and one process."""
    program = built_c(tmp_path, "wired_milstein")
    run = call("matrix", "--wire", f"./{Path(*program).name}", *QUICK, *jobs, "--out", "o")
    assert run.code == ExitCode.OK, run.err
    shown = call("show", "o", "wired-milstein", "gbm", "--json")
    [again] = {row["reproduce"] for row in json.loads(shown.out)}
    assert again.endswith(f"--wire {tmp_path}/wired_milstein")

    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    code, *_ = call(*shlex.split(again)[3:], "--progress", "none")
    assert code == ExitCode.OK
    assert verdicts("reports/reproduced") == verdicts(tmp_path / "o")


@pytest.mark.long
def test_evidence_is_that_of_a_build_and_its_arguments(call, tmp_path):
    """Evidence is reused for the same bytes and arguments, wherever they lie, and for no other build or arguments."""
    program = built_c(tmp_path, "wired_milstein")
    copy = tmp_path / "copy"
    copy.write_bytes(Path(*program).read_bytes())
    copy.chmod(0o755)
    given = (*QUICK, "--out", "o", "-j", "1", "--timeout", "60")
    first, again, moved, argued = (
        call("matrix", "--wire", command, *given).out
        for command in ("./wired_milstein", "./wired_milstein", "./copy", "./wired_milstein 2")
    )
    call("matrix", "--wire", "./wired_milstein", *given)
    built_c(tmp_path, "wired_milstein", "-DSIGN=-")
    wrong = call("matrix", "--wire", "./wired_milstein", *given)

    assert "reused" not in first
    assert re.search(r"evidence of (\d+) of \1 blocks", again)
    assert re.search(r"evidence of (\d+) of \1 blocks", moved)
    assert "with another code of the scheme" in " ".join(argued.split())
    assert "with another code of the scheme" in " ".join(wrong.out.split())
    assert wrong.code == ExitCode.REFUTED


@pytest.mark.slow
@pytest.mark.long
def test_script_among_the_arguments_counts_by_its_content(call, tmp_path):
    """A script is found from any folder, and a new text of it is another build."""
    command = with_python(tmp_path)
    given = (*QUICK, "--out", "o", "-j", "1", "--timeout", "60")
    relative = shlex.join([*command[:-1], Path(command[-1]).name])
    call("matrix", "--wire", relative, *given)
    again = call("matrix", "--wire", relative, *given)
    Path(command[-1]).write_text(Path(command[-1]).read_text() + "ANOTHER = True\n")
    other = call("matrix", "--wire", relative, *given)

    assert "was reused" in again.out
    assert "computed" not in again.out
    assert "with another code of the scheme" in " ".join(other.out.split())


def policy(text):
    """Write a policy with a table of programs."""
    Path("pyproject.toml").write_text(f'[tool.sdaeverify]\ntier = "smoke"\nproblems = ["gbm"]\n{text}\n')


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ('wire = "./solver"', "wire expects a table of names and commands, got './solver'"),
        ("[tool.sdaeverify.wire]\nmine = 3", "wire.mine expects a command, a text or a list of texts, got 3"),
        ("[tool.sdaeverify.wire]\nmine = []", "wire.mine expects a command, a text or a list of texts, got []"),
        ('[tool.sdaeverify.wire]\nmine = ["true", 1]', "got ['true', 1]"),
        ('[tool.sdaeverify.wire]\nmine = "\'a"', 'wire.mine: cannot read "\'a" as a command: No closing quotation'),
        (
            '[tool.sdaeverify.wire]\nmine = {comand = "true"}',
            "wire.mine: unknown key 'comand', expected command and patience",
        ),
        (
            '[tool.sdaeverify.wire]\nmine = {command = "true", patience = "1"}',
            "wire.mine: patience expects a number of seconds, got '1'",
        ),
        ('[tool.sdaeverify.wire]\nmine = "./nothing"', "no program '"),
        ('[tool.sdaeverify.wired]\nmine = "true"', "wired"),
    ],
)
def test_wrong_table_is_one_line(call, table, told):
    """Unknown keys, wrong types and missing programs are errors of the file, in one line."""
    policy(table)
    code, out, err = call("gate")

    assert (code, out) == (ExitCode.USAGE, "")
    assert "pyproject.toml: [tool.sdaeverify]: " in err
    assert told in err
    assert err.count("\n") == 1


def test_name_of_the_table_is_that_of_the_hello(call):
    """A program with another name than its key is not gated."""
    policy(f"[tool.sdaeverify.wire]\nmine = {FAULTY!r}")
    code, _, err = call("gate")

    assert code == ExitCode.PLUGIN
    assert "its hello names it 'faulty', expected 'mine'" in err


@pytest.mark.long
def test_programs_of_a_table_are_gated(call, tmp_path, monkeypatch):
    """A gate without selection is about the programs of its table, found beside the file from a folder below."""
    built_c(tmp_path, "wired_milstein")
    policy('[tool.sdaeverify.wire]\nwired-milstein = {command = "./wired_milstein", patience = 120}')
    (tmp_path / "below").mkdir()
    monkeypatch.chdir(tmp_path / "below")
    passed = call("gate", "--progress", "none")
    built_c(tmp_path, "wired_milstein", "-DSIGN=-")
    failed = call("gate", "--progress", "none")

    assert (passed.code, failed.code) == (ExitCode.OK, ExitCode.REFUTED)
    assert f"--wire 'patience=120 name=wired-milstein {tmp_path}/wired_milstein'" in failed.out
