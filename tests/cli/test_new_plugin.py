"""The command ``new-plugin``."""

from pathlib import Path

from facade import ExitCode


def test_plugin_is_written(call):
    """The files are listed, and the commands to go on with."""
    code, out, err = call("new-plugin", "rodeo")

    assert (code, err) == (ExitCode.OK, "")
    assert "rodeo is in rodeo:" in out
    assert "  src/rodeo/platen.py" in out
    assert "  sdaeverify gate" in out
    assert Path("rodeo/pyproject.toml").is_file()


def test_name_may_differ_from_the_folder(call):
    """With --name, the folder can be called anything."""
    code, out, _ = call("new-plugin", "3 body", "--name", "three_body")

    assert code == ExitCode.OK
    assert "three-body is in 3 body:" in out
    assert "  cd '3 body'" in out
    assert Path("3 body/src/three_body/sinh.py").is_file()


def test_folder_that_is_not_empty_is_one_line(call):
    """The second time, the folder is not empty: one line, wrong usage, and nothing is changed."""
    call("new-plugin", "rodeo")
    before = Path("rodeo/README.md").stat().st_mtime_ns

    code, out, err = call("new-plugin", "rodeo")

    assert (code, out) == (ExitCode.USAGE, "")
    assert err == "sdaeverify: error: rodeo is not empty; new-plugin expects a folder that is new or empty\n"
    assert Path("rodeo/README.md").stat().st_mtime_ns == before
