"""Plugins made from a text: sources of other distributions, and what is said of those that are wrong."""

from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace

import pytest

from facade import EulerMaruyama, load_registry, sources
from sdaeverify import hookimpl
from sdaeverify.commands import PluginSource
from sdaeverify.errors import PluginError


class Renamed(EulerMaruyama):
    """Euler's scheme under another name."""

    name = "renamed"


def made(text):
    """Return a plugin with one scheme; fail as the text says."""
    if text.endswith("broken"):
        raise ZeroDivisionError("nothing is there")

    @hookimpl
    def sdaeverify_schemes():
        return [Renamed()]

    return SimpleNamespace(sdaeverify_schemes=sdaeverify_schemes)


FOLDERS = PluginSource("PATH", "A path.", lambda text, folder: str(folder / text), made, list)
NO_SOURCE = "./a.toml"


@pytest.fixture(autouse=True)
def entries(monkeypatch):
    """Install a source, one that cannot be imported, and one that is something else."""
    known = {
        "folder": EntryPoint("folder", f"{__name__}:FOLDERS", sources.SOURCES),
        "gone": EntryPoint("gone", "no_such_module:SOURCE", sources.SOURCES),
        "other": EntryPoint("other", f"{__name__}:NO_SOURCE", sources.SOURCES),
    }
    monkeypatch.setattr(sources, "plugin_sources", lambda: known)


def test_schemes_of_a_source_are_registered(tmp_path, monkeypatch):
    """The text is made absolute; what it made is no file of the workers, and is named again by the same text."""
    monkeypatch.chdir(tmp_path)
    registry = load_registry(["folder:here"], {})

    assert registry.files == (f"folder:{tmp_path}/here",)
    assert registry.paths == ()
    assert registry.sourced == ("renamed",)
    assert sources.plugin_options([*registry.files, "/a.py"]) == ["--folder", f"{tmp_path}/here", "--plugin", "/a.py"]
    assert load_registry(registry.files, {}).sourced == ("renamed",)


def test_table_of_a_policy_is_read_by_its_source():
    """Keys that name a source are taken out of the table, and texts are relative to the folder of the file."""
    rest, plugins = sources.plugins_of_tables({"tier": "ci", "folder": {"here": 1}}, Path("/there"))

    assert rest == {"tier": "ci"}
    assert plugins == ("folder:/there/here",)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("folder:broken", r"--folder /\S+/broken: ZeroDivisionError: nothing is there"),
        ("gone:x", r"source gone of .* is broken: .*No module named 'no_such_module'"),
        ("other:x", r"source other of .* is broken: it is './a\.toml', no PluginSource"),
        ("nowhere:x", r"plugin file nowhere:x: expected an existing file that ends in \.py|nowhere:x"),
    ],
)
def test_source_that_is_broken_is_one_line(given, told):
    """An error of a source names it, and a text of no source is the path of a plugin file."""
    with pytest.raises(PluginError, match=told) as error:
        load_registry([given], {})
    assert "\n" not in str(error.value)
