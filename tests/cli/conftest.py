"""The command line called in this process, and plugin files that misbehave."""

import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from facade import Limits, execute
from sdaeverify.cli.options import options_of
from sdaeverify.registry import load
from sdaeverify_orders.order_tests import ORDER_TESTS, OrderTests

HEADER = """
import multiprocessing, os, sys, time
from dataclasses import dataclass
from typing import ClassVar
import numpy as np
from sdaeverify import SDE, Claim, HolonomicSDAE, Pathwise, Scheme, Step, hookimpl
"""
SCHEME = """
class Odd(Scheme):
    name: ClassVar[str] = "odd"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=1.0, source="nowhere"),)

    def step(self, problem, state, t, h, noise):
        {step}

@hookimpl
def sdaeverify_schemes():
    return [Odd()]
"""
PROBLEM = """
def zz_odd() -> SDE:
    return {problem}

@hookimpl
def sdaeverify_problems():
    return [zz_odd]
"""


class Outcome(NamedTuple):
    """What a command line came to."""

    code: int
    out: str
    err: str


Call = Callable[..., Outcome]
Write = Callable[[str], str]


class Remembered:
    """What commands compute alike in every test, computed once: the program of a user does so once, too."""

    def __init__(self) -> None:
        self._load, self._find, self._ask = load._from_entry_point, metadata.entry_points, OrderTests.findings
        self._known: dict[object, Any] = {}

    def loaded(self, entry: object, disabled: frozenset[str], before: Sequence[load.LoadedPlugin]) -> object:
        """Load what is installed once for the same path, choice of plugins and plugins before it; files anew."""
        key = ("loaded", tuple(sys.path), entry, disabled, tuple(outcome.row for outcome in before))
        return self._once(key, lambda: self._load(entry, disabled, before))

    def entry_points(self, **group: str) -> object:
        """Read the entry points of all distributions once for the same path."""
        return self._once(("found", tuple(sys.path), *group.items()), lambda: self._find(**group))

    def findings(self, *asked: Any, modified: bool = False) -> object:
        """Return the findings on a class, computed once for the same scheme; that of a new plugin file is another."""
        return self._once((*asked, modified), lambda: tuple(self._ask(ORDER_TESTS, *asked, modified=modified)))

    def _once(self, key: tuple[object, ...], compute: Callable[[], object]) -> object:
        if key not in self._known:
            self._known[key] = compute()
        return self._known[key]


@pytest.fixture(scope="session")
def remembered() -> Remembered:
    """Return what commands compute alike in every test."""
    return Remembered()


@pytest.fixture
def call(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    remembered: Remembered,
) -> Iterator[Call]:
    """Run a command line in an empty folder, 80 columns wide."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    # Folders of plugin files are added to it.
    monkeypatch.setattr(sys, "path", [*sys.path])
    for name in (
        "FORCE_COLOR",
        "NO_COLOR",
        "SDAEVERIFY_DISABLED_PLUGINS",
        "SDAEVERIFY_STRICT_PLUGINS",
        "GITHUB_ACTIONS",
    ):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(load, "_from_entry_point", remembered.loaded)
    monkeypatch.setattr(metadata, "entry_points", remembered.entry_points)
    monkeypatch.setattr(OrderTests, "findings", remembered.findings)
    monkeypatch.setattr("sdaeverify.cli.commands.matrix.options_of", _options_of)
    # What a merge says does not depend on where problems are built.
    monkeypatch.setattr("sdaeverify.cli.commands.merge.read_limits", lambda *_: (1, None))

    def execute_it(*arguments: str) -> Outcome:
        code = execute(arguments)
        return Outcome(code, *capsys.readouterr())

    yield execute_it
    for name in [name for name in sys.modules if name.startswith("sdaeverify_file_")]:
        del sys.modules[name]


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[object, tuple[Outcome, Path]]]:
    """Return a folder in which the runs of a module are kept, and what they came to."""
    return tmp_path_factory.mktemp("kept"), {}


@pytest.fixture
def call_once(call: Call, kept: tuple[Path, dict[object, tuple[Outcome, Path]]]) -> Call:
    """Run a command line that writes into a folder, or copy what the same one wrote in an earlier test."""
    place, known = kept

    def run(out: str, *arguments: str, also: object = None) -> Outcome:
        if (arguments, also) in known:
            shutil.copytree(known[arguments, also][1], out)
        else:
            outcome = call(*arguments, "--out", out)
            known[arguments, also] = outcome, Path(shutil.copytree(out, place / str(len(known))))
        return known[arguments, also][0]

    return run


def _options_of(options: dict[str, Any]) -> tuple[int, Limits | None]:
    """Run one job in this process: what a run says does not depend on where, and a worker takes time."""
    unlimited = options["jobs"] == 1 and options["timeout"] is None and options["memory"] is None
    return (1, None) if unlimited else options_of(options)


@pytest.fixture
def quick(call: Call) -> Call:
    """Run ``matrix`` at the smallest budget."""
    budget = ("--paths", "40", "--levels", "8..32", "-j", "1", "--progress", "none")
    return lambda *arguments: call("matrix", *budget, *arguments)


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write a plugin file."""

    def put(text: str) -> str:
        path = tmp_path / "odd_plugin.py"
        path.write_text(HEADER + text)
        return str(path)

    return put


@pytest.fixture
def odd_scheme(write: Write) -> Write:
    """Write a plugin with the scheme ``odd`` that makes this step."""
    return lambda step: write(SCHEME.format(step=step))


@pytest.fixture
def odd_problem(write: Write) -> Write:
    """Write a plugin with the problem ``zz-odd``."""
    return lambda problem: write(PROBLEM.format(problem=problem))
