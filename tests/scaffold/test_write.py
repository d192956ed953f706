"""The files of a new plugin."""

import ast
import json
import re
import tomllib
from pathlib import Path

import pytest

from facade import load_registry, names_of, scaffold, select_problems, write_plugin
from sdaeverify import UsageError

NAMES = names_of(Path(), "rodeo")


@pytest.fixture
def plugin(tmp_path):
    """Write a plugin into a new folder."""
    write_plugin(tmp_path / "rodeo", NAMES)
    return tmp_path / "rodeo"


def below(folder):
    """Return all files below a folder, relative to it."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_what_is_said_to_be_written_is_there(tmp_path):
    """The files that are returned are those in the folder, and nothing is left beside it."""
    written = write_plugin(tmp_path / "sub" / "rodeo", NAMES)

    assert sorted(written) == below(tmp_path / "sub" / "rodeo")
    assert [path.name for path in (tmp_path / "sub").iterdir()] == ["rodeo"]


def test_an_empty_folder_is_filled(tmp_path):
    """The folder may exist, be it the one the program runs in."""
    inode = tmp_path.stat().st_ino

    written = write_plugin(tmp_path, NAMES)

    assert sorted(written) == below(tmp_path)
    assert tmp_path.stat().st_ino == inode


def test_a_folder_that_holds_something_is_refused(tmp_path):
    """Nobody's file is overwritten, a hidden one neither."""
    (tmp_path / ".hidden").write_text("mine")

    with pytest.raises(UsageError, match="is not empty"):
        write_plugin(tmp_path, NAMES)

    assert below(tmp_path) == [".hidden"]


def test_a_file_in_the_way_is_refused(tmp_path):
    """The folder cannot have the name of a file."""
    (tmp_path / "rodeo").write_text("mine")

    with pytest.raises(UsageError, match="is not a folder"):
        write_plugin(tmp_path / "rodeo", NAMES)


def test_a_link_is_followed_where_it_leads_somewhere(tmp_path):
    """A link to an empty folder is as good as the folder; one to nothing is refused."""
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "there")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")

    assert sorted(write_plugin(tmp_path / "link", NAMES)) == below(tmp_path / "there")
    with pytest.raises(UsageError, match="is not a folder"):
        write_plugin(tmp_path / "dangling", NAMES)


def test_a_failure_leaves_nothing_half_written(tmp_path, monkeypatch):
    """Where a disk is full, the folder is as it was."""

    def full(root, texts):
        (root / "README.md").write_text("begun")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(scaffold, "_write", full)
    with pytest.raises(UsageError, match="No space left on device"):
        write_plugin(tmp_path / "rodeo", NAMES)

    assert not list(tmp_path.iterdir())


def test_a_failure_in_the_middle_of_the_move_is_taken_back(tmp_path, monkeypatch):
    """An empty folder is empty again where the second file cannot be moved into it."""
    rename, moved = Path.rename, []

    def once(self, target):
        if Path(target).parent == tmp_path / "rodeo" and len(moved) == 2:
            raise OSError(5, "Input/output error")
        moved.append(target)
        return rename(self, target)

    (tmp_path / "rodeo").mkdir()
    monkeypatch.setattr(Path, "rename", once)
    with pytest.raises(UsageError, match="Input/output error"):
        write_plugin(tmp_path / "rodeo", NAMES)

    assert len(moved) > 2
    assert below(tmp_path) == []


def test_everything_is_filled_in(plugin):
    """No placeholder is left, but for those of the workflow's own language."""
    for path in below(plugin):
        text = (plugin / path).read_text(encoding="utf-8")
        assert "$" not in text.replace("${{", ""), path
        assert text.endswith("\n"), path


def test_python_files_are_python(plugin):
    """They can be parsed, and lines are not longer than this project's own."""
    for path in plugin.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert ast.parse(text).body
        assert max(map(len, text.splitlines())) <= 118


def test_project_file_names_the_package(plugin):
    """The entry point is the package, which is in the wheel; warnings are errors, and no licence is claimed."""
    project = tomllib.loads((plugin / "pyproject.toml").read_text(encoding="utf-8"))

    assert project["project"]["name"] == "rodeo"
    assert project["project"]["entry-points"]["sdaeverify"] == {"rodeo": "rodeo"}
    assert (plugin / project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"][0] / "__init__.py").is_file()
    assert project["tool"]["pytest"]["ini_options"]["filterwarnings"] == ["error"]
    assert "license" not in project["project"]
    assert "No licence has been chosen" in (plugin / "LICENSE").read_text(encoding="utf-8")


def test_workflow_gates_changes_and_weeks(plugin):
    """A change is gated at tier ci, the weekly run at tier nightly with a seed of its date."""
    workflow = (plugin / ".github/workflows/verify.yml").read_text(encoding="utf-8")

    gates = re.findall(r"sdaeverify gate (.*)", workflow)
    assert gates == ["--tier ci", "--tier nightly --seed-from date"]
    assert "cron:" in workflow
    assert "pull_request:" in workflow


def test_coefficients_that_depend_on_time_are_gated(plugin):
    """Policy and lock file have a problem that tells a drift at time t from one at time 0."""
    project = tomllib.loads((plugin / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["sdaeverify"]
    locked = json.loads((plugin / "sdaeverify.lock").read_text(encoding="utf-8"))["tiers"]

    (problem,) = select_problems(load_registry(environ={}), "forced-ou")
    made = problem.build()
    assert made.drift(0.0, made.start) != made.drift(1.0, made.start)
    for tier in ("ci", "nightly"):
        of_problems = {name for name in locked[tier]["rodeo-platen"] if not name.startswith("every-equation")}
        assert of_problems == set(project["problems"])
        assert {"strong", "weak"} <= set(locked[tier]["rodeo-platen"]["forced-ou"])
