"""The registry: discovery, isolation of broken plugins, files, and the environment."""

import importlib
import os
import pickle
import sys
from collections.abc import Callable, Iterator, Mapping
from importlib import metadata
from pathlib import Path

import pytest

import sdaeverify
from facade import known_hooks
from sdaeverify.errors import ParameterError, PluginError, ProblemError, UsageError
from sdaeverify.registry.discovery import entry_points, load_file, origin_of
from sdaeverify.registry.load import PluginRow, Registry, load_registry
from sdaeverify.registry.sources import plugin_sources
from sdaeverify.workers.executors import crew_of

Install = Callable[..., None]
# The shipped plugins are left out where nothing is asked of them.
ALONE = {"SDAEVERIFY_DISABLED_PLUGINS": "sdaeverify"}

HEADER = """
from dataclasses import dataclass, field
from typing import ClassVar
from sdaeverify.forms import SDE
from sdaeverify.registry.hookspecs import hookimpl
from sdaeverify.contracts.scheme import Claim, Scheme, Step
"""
SCHEME = (
    HEADER
    + """
@dataclass(frozen=True)
class Fake(Scheme):
    order: float = 1.0
    mode: str = "plain"
    name: ClassVar[str] = "fake-scheme"
    form: ClassVar[type] = SDE

    def __post_init__(self):
        if self.order < 0:
            raise ValueError("negative order")

    def step(self, problem, state, t, h, noise):
        return Step(state)

@dataclass(frozen=True)
class Other(Fake):
    more: int = 1

@hookimpl
def sdaeverify_schemes():
    return [Fake(order=2.0), Fake()]
"""
)
PROBLEM = (
    HEADER
    + """
def fake_problem(a: float = 1.0, label: str = "x") -> SDE:
    return SDE(drift=lambda t, x: a * x, diffusion=lambda t, x: x[:, None], start=[1.0], noise_dim=1,
               horizon=1.0, source="made up")

def no_problem():
    return {}

@hookimpl
def sdaeverify_problems():
    yield fake_problem
    yield no_problem
"""
)
MEASURE = (
    HEADER
    + """
class Question:
    name = "fake-question"

@hookimpl
def sdaeverify_measures():
    return (Question(),)
"""
)


# Ends of hooks that return what cannot be registered.
BARE = "\n    class Bare(Fake):\n        more: int = 1\n    return [Bare()]"
LOST = "\n    global Fake\n    old, Fake = Fake(), None\n    return [old]"
LOCAL = "    def local(): ...\n    yield local\n"


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Put distributions on the path, and forget what was imported from them."""
    # Hooks are read once in a process: not while what is installed here takes the place of those who bring them.
    known_hooks()

    def put(name: str, files: Mapping[str, str], entries: Mapping[str, str], version: str = "1.0") -> None:
        site = tmp_path / name
        information = site / f"{name.replace('-', '_')}-{version}.dist-info"
        information.mkdir(parents=True)
        (information / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
        lines = [f"{key} = {value}" for key, value in entries.items()]
        (information / "entry_points.txt").write_text("\n".join(["[sdaeverify]", *lines]))
        for path, text in files.items():
            (site / path).parent.mkdir(parents=True, exist_ok=True)
            (site / path).write_text(text)
        monkeypatch.syspath_prepend(str(site))

    yield put
    for name in [name for name in sys.modules if name.startswith(("fake_", "sdaeverify_file_"))]:
        del sys.modules[name]


@pytest.fixture
def one(install: Install) -> Callable[[str], PluginRow]:
    """Load a plugin of one module and return its row."""

    def load(text: str) -> PluginRow:
        install("fake-dist", {"fake_plugin.py": text}, {"fake": "fake_plugin"}, version="2.5")
        return row(load_registry(environ=ALONE), "fake")

    return load


def row(registry: Registry, name: str) -> PluginRow:
    (found,) = (row for row in registry.plugins if row.name == name)
    return found


def hook(name: str, body: str) -> str:
    return f"{HEADER}\n@hookimpl\ndef {name}():\n    {body}\n"


# Discovery


def test_metadata_of_a_distribution_is_parsed_once(install: Install, monkeypatch: pytest.MonkeyPatch) -> None:
    """However many entry points it has: each of ten would cost a parse of the whole description."""
    install("fake-dist", {}, {f"fake-{number}": "fake_plugin" for number in range(10)})
    parsed, metadata_of = [], vars(metadata.Distribution)["metadata"].fget
    counted = property(lambda self: (parsed.append(self), metadata_of(self))[1])
    monkeypatch.setattr(metadata.PathDistribution, "metadata", counted)

    origins = [origin_of(entry) for entry in entry_points() if entry.name.startswith("fake-")]

    assert [(origin.distribution, origin.version) for origin in origins] == [("fake-dist", "1.0")] * 10
    assert len(parsed) == len({*parsed})


def test_entry_point_of_a_module(install: Install) -> None:
    """A module named by an entry point is one plugin, and its row counts what it registers."""
    install("fake-dist", {"fake_all.py": SCHEME + PROBLEM + MEASURE}, {"fake": "fake_all"}, version="2.5")

    registry = load_registry(environ={})

    expected = PluginRow("fake", "fake-dist", "2.5", "fake_all", "loaded", "", 1, 2, 1)
    assert row(registry, "fake") == expected
    assert [scheme.label for scheme in registry.schemes["fake-scheme"].variants] == [
        "fake-scheme[order=2]",
        "fake-scheme",
    ]
    assert registry.problems["fake-problem"].make({}).label == "fake-problem"
    assert registry.measures["fake-question"].thing.name == "fake-question"


def test_entry_point_of_a_package(install: Install) -> None:
    """Each module of a package and of its families is a plugin; one that is broken costs its own names only."""
    files = {
        "fake_package/__init__.py": "",
        "fake_package/good.py": SCHEME,
        "fake_package/bad.py": "1 / 0",
        "fake_package/helper.py": "def helper(): ...",
        "fake_package/_private.py": "1 / 0",
        "fake_package/more/__init__.py": PROBLEM,
        "fake_package/family/__init__.py": "",
        "fake_package/family/member.py": MEASURE,
        "fake_package/family/_private.py": "1 / 0",
    }
    install("fake-dist", files, {"fake": "fake_package"})

    registry = load_registry(environ={})

    rows = [(row.name, row.module, row.status) for row in registry.plugins if row.distribution == "fake-dist"]
    assert rows == [
        ("fake.bad", "fake_package.bad", "broken"),
        ("fake.family.member", "fake_package.family.member", "loaded"),
        ("fake.good", "fake_package.good", "loaded"),
        ("fake.more", "fake_package.more", "loaded"),
    ]
    assert row(registry, "fake.bad").reason == "ZeroDivisionError: division by zero (fake_package/bad.py:1)"
    assert {"fake-scheme"} <= registry.schemes.keys()


COUNTING = MEASURE.replace("return (Question(),)", "CALLS.append(1); return (Question(),)") + "\nCALLS = []\n"


def test_plugins_are_loaded_once_while_their_files_are_the_same(install: Install, tmp_path: Path) -> None:
    """A second registry calls no hook again; after a change of the file and a reload of the module it does."""
    install("fake-dist", {"fake_plugin.py": COUNTING}, {"fake": "fake_plugin"})
    first, again = load_registry(environ=ALONE), load_registry(environ=ALONE)
    plugin = sys.modules["fake_plugin"]
    assert len(plugin.CALLS) == 1
    assert first.measures == again.measures

    file = tmp_path / "fake-dist" / "fake_plugin.py"
    file.write_text(COUNTING.replace("fake-question", "fake-other-question"))
    os.utime(file, (2e9, 2e9))
    importlib.reload(plugin)

    assert [*load_registry(environ=ALONE).measures] == ["fake-other-question"]


def test_installed_plugins_do_not_depend_on_earlier_registries(install: Install) -> None:
    """The same entry point is loaded anew with another environment, and from another place on the path."""
    install("fake-dist", {"fake_plugin.py": MEASURE}, {"fake": "fake_plugin"})
    assert load_registry(environ=ALONE).measures
    assert not load_registry(environ={"SDAEVERIFY_DISABLED_PLUGINS": "sdaeverify,fake"}).measures

    del sys.modules["fake_plugin"]
    install("fake-dist-before", {"fake_plugin.py": PROBLEM}, {})

    assert [*load_registry(environ=ALONE).problems] == ["fake-problem", "no-problem"]


def test_plugin_is_loaded_once_its_library_is_installed(install: Install, tmp_path: Path) -> None:
    """A new module in a folder of the path is looked for at the next load."""
    code = f"""
from importlib.util import find_spec
from sdaeverify.errors import MissingLibraryError
if find_spec("fake_library") is None:
    raise MissingLibraryError("fake_library is not installed")
{MEASURE}
"""
    install("fake-dist", {"fake_plugin.py": code}, {"fake": "fake_plugin"})
    assert row(load_registry(environ=ALONE), "fake").status == "absent"

    (tmp_path / "fake-dist" / "fake_library.py").touch()
    os.utime(tmp_path / "fake-dist", (2e9, 2e9))

    assert row(load_registry(environ=ALONE), "fake").status == "loaded"


def test_broken_plugin_is_loaded_after_its_repair(install: Install, tmp_path: Path) -> None:
    """It may be repaired in a file that the plugin reads, which nothing but another attempt shows."""
    file = tmp_path / "it-is-there"
    code = f"assert __import__('pathlib').Path({str(file)!r}).exists(), 'not yet'\n{MEASURE}"
    install("fake-dist", {"fake_plugin.py": code}, {"fake": "fake_plugin"})
    assert row(load_registry(environ=ALONE), "fake").status == "broken"

    file.touch()

    assert row(load_registry(environ=ALONE), "fake").status == "loaded"


def test_plugin_without_its_library_is_left_out(install: Install) -> None:
    """It is shown with what to install, and nothing is wrong with it: a strict environment has it, too."""
    code = """
from sdaeverify_bridges.kit import Library
from sdaeverify.registry.hookspecs import hookimpl

@hookimpl
def sdaeverify_schemes():
    Library.find("a_library_that_is_not_there").require()
"""
    install("fake-dist", {"fake_plugin.py": code}, {"fake": "fake_plugin"})

    found = row(load_registry(environ={**ALONE, "SDAEVERIFY_STRICT_PLUGINS": "1"}), "fake")

    assert (found.status, found.schemes) == ("absent", 0)
    assert found.reason.startswith("a_library_that_is_not_there is not installed; pip install")


@pytest.mark.parametrize("more", [{}, {"fake_package/a.py": ""}])
def test_package_without_any_hook_is_broken(install: Install, more: Mapping[str, str]) -> None:
    """An entry point that brings nothing at all is shown."""
    install("fake-dist", {"fake_package/__init__.py": "", **more}, {"fake": "fake_package"})

    found = row(load_registry(environ=ALONE), "fake")

    assert found.status == "broken"
    assert "hook" in found.reason


def test_entry_point_of_an_object(install: Install) -> None:
    """An entry point may name an object inside a module; then the module's own hooks do not count."""
    methods = "class Plugin:\n    @hookimpl\n    def sdaeverify_schemes(self): return [Fake()]\n"
    text = f"{SCHEME}\n{methods}\nit = Plugin()"
    install("fake-dist", {"fake_object.py": text}, {"fake": "fake_object:it"})

    registry = load_registry(environ=ALONE)

    assert row(registry, "fake")[3:5] == ("fake_object:it", "loaded")
    assert [scheme.label for scheme in registry.schemes["fake-scheme"].variants] == ["fake-scheme"]


def test_maps_are_sorted_and_read_only(install: Install) -> None:
    """Names come sorted, and nobody can register anything later."""
    text = SCHEME.replace("fake-scheme", "a-scheme")
    install("fake-b", {"fake_b.py": SCHEME}, {"b": "fake_b"})
    install("fake-a", {"fake_a.py": text}, {"z": "fake_a"})

    registry = load_registry(environ={})

    assert list(registry.schemes) == sorted(registry.schemes)
    with pytest.raises(TypeError):
        registry.schemes["x"] = registry.schemes["a-scheme"]  # type: ignore[index]


def test_shipped_plugins_come_first(install: Install) -> None:
    """A third party cannot take a name that sdaeverify itself registers, whatever it is called."""
    install("sdaeverify", {"fake_shipped.py": SCHEME}, {"zz-shipped": "fake_shipped"}, version="9.9")
    install("aaa", {"fake_shadow.py": SCHEME}, {"aa-shadow": "fake_shadow"})

    registry = load_registry(environ={})

    assert registry.schemes["fake-scheme"].origin.distribution == "sdaeverify"
    assert row(registry, "aa-shadow").reason == (
        "scheme 'fake-scheme' of plugin aa-shadow (aaa 1.0) is already registered by "
        "plugin zz-shipped (sdaeverify 9.9)"
    )


# Isolation


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import fake_missing", "ModuleNotFoundError: No module named 'fake_missing'"),
        ("x = = 1", "SyntaxError: invalid syntax (fake_plugin.py, line 1)"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("import os; os._exit(0)", "SystemExit: os._exit(0)"),
        ("import sys; sys.stdout.close(); print(1)", "implements no hook"),
        ("", "implements no hook; expected one of sdaeverify_adaptive"),
        (hook("sdaeverify_schemes", "yield 1 / 0"), "ZeroDivisionError: division by zero"),
        (hook("sdaeverify_schemes", "pass"), "sdaeverify_schemes returned None, expected an iterable"),
        (hook("sdaeverify_problems", "return 3"), "sdaeverify_problems returned 3, expected an iterable"),
        (
            hook("sdaeverify_scheme", "return []"),
            "unknown hook sdaeverify_scheme; did you mean sdaeverify_schemes?",
        ),
        (
            "def sdaeverify_schemes(): return []",
            "function sdaeverify_schemes is not marked as a hook; put @hookimpl",
        ),
        (
            f"{HEADER}\n@hookimpl\ndef sdaeverify_schemes(registry): return []",
            "PluginValidationError: Plugin 'fake' for hook 'sdaeverify_schemes'",
        ),
    ],
)
def test_broken_plugin(one: Callable[[str], PluginRow], text: str, reason: str) -> None:
    """Whatever goes wrong in a plugin is one line in its row."""
    found = one(text)

    assert found[:5] == ("fake", "fake-dist", "2.5", "fake_plugin", "broken")
    assert found.reason.startswith(reason)
    assert "\n" not in found.reason


TWO = "Fake(order=2.0), Fake()"


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (f"[{TWO}]", "[Fake]", "expected a scheme, got the class Fake; write Fake()"),
        (f"[{TWO}]", "[3]", "expected a scheme, got an object of type int"),
        (TWO, "Fake(), Fake()", "scheme 'fake-scheme' is registered twice by this plugin: Fake and Fake"),
        (TWO, "Fake(order=-1)", "ValueError: negative order"),
        (TWO, "Fake(mode=(1, 2))", "parameter mode of scheme 'fake-scheme' expects a word or a number, got (1, 2)"),
        ("fake-scheme", "Fake_Scheme", "name of a scheme (class Fake) must be lower-case letters"),
        ('name: ClassVar[str] = "fake-scheme"', "", "name of a scheme (class Fake) must be lower-case letters"),
        ("name: ClassVar[str]", "name: str", "scheme 'fake-scheme': annotate name as ClassVar"),
        ("= SDE\n", "= 3\n", "scheme 'fake-scheme': form must be the form of problem it solves"),
        ("= SDE\n", "= SDE\n    claims = (3,)\n", "scheme 'fake-scheme': claims must be a tuple of Claim"),
        ("= SDE\n", "= SDE\n    gives = 'r'\n", "scheme 'fake-scheme': gives must be a tuple of names of components"),
        ("= SDE\n", "= SDE\n    domain = 'x >= 0'\n", "scheme 'fake-scheme': domain must be a Domain"),
        ("= 1.0", "= field(kw_only=True)", "parameter order of scheme 'fake-scheme' has no default"),
        ('str = "plain"', "tuple = (1,)", "parameter mode of scheme 'fake-scheme' has a default of type tuple"),
        (f"return [{TWO}]", BARE, "scheme 'fake-scheme': put @dataclass(frozen=True) above the class Bare, for more"),
        (f"return [{TWO}]", LOST, "scheme 'fake-scheme' cannot be sent to worker processes"),
        (f"[{TWO}]", "[Fake(), Other()]", "scheme 'fake-scheme' is registered twice by this plugin: Fake and Other"),
    ],
)
def test_unusable_scheme(one: Callable[[str], PluginRow], old: str, new: str, reason: str) -> None:
    """A scheme that does not keep the contract breaks its plugin, and the reason says what to do."""
    assert old in SCHEME

    found = one(SCHEME.replace(old, new).replace(TWO, "Fake(order=2.0)"))

    assert found.status == "broken"
    assert found.reason.startswith(reason)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("no_problem\n", "fake_problem()\n", "expected a function that returns a problem, got an object of type SDE"),
        ("no_problem\n", "SDE\n", "expected a function that returns a problem, got the class SDE"),
        ("no_problem\n", "fake_problem\n", "problem 'fake-problem' is registered twice by this plugin"),
        ("no_problem\n", "(lambda: 3)\n", "name of a problem function must be lower-case letters"),
        (
            'a: float = 1.0, label: str = "x"',
            "a",
            "parameter a of problem 'fake-problem' has no default; give it one",
        ),
        ('label: str = "x"', "**rest", "parameter rest of problem 'fake-problem' has no default; give it one"),
        ("a: float = 1.0", "a=None", "parameter a of problem 'fake-problem' has a default of type NoneType"),
        ("    yield fake_problem\n", LOCAL, "problem 'local' cannot be sent to worker processes"),
    ],
)
def test_unusable_problem(one: Callable[[str], PluginRow], old: str, new: str, reason: str) -> None:
    """A problem function that does not keep the contract breaks its plugin; the reason says what to do."""
    assert old in PROBLEM

    found = one(PROBLEM.replace(old, new))

    assert found.status == "broken"
    assert found.reason.startswith(reason)


TWICE = "measure 'fake-question' is registered twice by this plugin: Question and Question"


@pytest.mark.parametrize(
    ("returned", "reason"),
    [
        ("[Question]", "expected a measure, got the class Question; write Question()"),
        ("[3]", "name of a measure must be lower-case letters, digits, hyphens and dots, got None"),
        ("[Question(), Question()]", TWICE),
    ],
)
def test_unusable_measure(one: Callable[[str], PluginRow], returned: str, reason: str) -> None:
    """A measure that does not keep the contract breaks its plugin."""
    assert one(MEASURE.replace("(Question(),)", returned)).reason == reason


def test_plugin_with_one_taken_name_is_refused_as_a_whole(install: Install) -> None:
    """Nothing of a plugin is registered if one of its names is taken; both origins are named."""
    install("fake-a", {"fake_a.py": PROBLEM}, {"a": "fake_a"}, version="1.1")
    install("fake-b", {"fake_b.py": SCHEME + PROBLEM}, {"b": "fake_b"}, version="2.2")

    registry = load_registry(environ=ALONE)

    assert row(registry, "b").reason == (
        "problem 'fake-problem' of plugin b (fake-b 2.2) is already registered by plugin a (fake-a 1.1)"
    )
    assert "fake-scheme" not in registry.schemes


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("raise GeneratorExit", "GeneratorExit: no message (fake_package/bad.py:1)"),
        (hook("sdaeverify_schemes", "exit(0)"), "SystemExit: 0 (fake_package/bad.py:10)"),
        (
            "class Mute(Exception):\n    def __str__(self):\n        raise ValueError\nraise Mute",
            "Mute: its message cannot be read, which raises ValueError (fake_package/bad.py:4)",
        ),
    ],
)
def test_plugin_that_leaves_as_it_is_loaded(install: Install, text: str, reason: str) -> None:
    """It costs that plugin only, as a module of a package, too: the others are there."""
    install(
        "fake-dist",
        {"fake_package/__init__.py": "", "fake_package/bad.py": text, "fake_package/good.py": SCHEME},
        {"fake": "fake_package"},
    )

    registry = load_registry(environ=ALONE)

    assert {each.name: (each.status, each.reason) for each in registry.plugins if each.name.startswith("fake")} == {
        "fake.bad": ("broken", reason),
        "fake.good": ("loaded", ""),
    }
    assert "fake-scheme" in registry.schemes


def test_bad_entry_point_is_isolated(install: Install) -> None:
    """An entry point that names no object breaks its own row only."""
    install(
        "fake-dist",
        {"fake_plugin.py": SCHEME},
        {"a": "fake_plugin:nothing", "b": "no module!", "c": "fake_plugin"},
    )

    registry = load_registry(environ=ALONE)

    assert [row(registry, name).status for name in "abc"] == ["broken", "broken", "loaded"]


# Files


def test_file(tmp_path: Path, install: Install) -> None:
    """A file is a plugin named after it, and is listed for worker processes."""
    file = tmp_path / "mine.py"
    file.write_text(SCHEME)

    registry = load_registry([str(file), str(file)], environ=ALONE)

    assert row(registry, "mine") == PluginRow("mine", "", "", str(file), "loaded", "", 1, 0, 0)
    assert registry.files == (str(file),)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x = = 1", "SyntaxError: invalid syntax (mine.py, line 1)"),
        ("", "implements no hook"),
    ],
)
def test_broken_file_is_refused(tmp_path: Path, install: Install, text: str, reason: str) -> None:
    """A file was asked for: if it is broken, nothing is run."""
    file = tmp_path / "mine.py"
    file.write_text(text)

    with pytest.raises(PluginError) as caught:
        load_registry([str(file)], environ=ALONE)

    assert str(caught.value).startswith(f"plugin file {file}: {reason}")


def test_file_with_a_taken_name_is_refused(tmp_path: Path, install: Install) -> None:
    """Both origins are named where a file registers a name that is taken."""
    file = tmp_path / "mine.py"
    file.write_text(SCHEME)
    install("fake-dist", {"fake_plugin.py": SCHEME}, {"fake": "fake_plugin"})

    with pytest.raises(PluginError) as caught:
        load_registry([file], environ=ALONE)

    assert str(caught.value) == (
        f"plugin file {file}: scheme 'fake-scheme' of plugin mine ({file}) is already registered by "
        "plugin fake (fake-dist 1.0)"
    )


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("", "is a folder, expected a Python file"),
        ("missing.py", "expected an existing file that ends in .py"),
    ],
)
def test_no_python_file(tmp_path: Path, name: str, reason: str) -> None:
    """What is no Python file is refused."""
    (tmp_path / "notes.txt").write_text("")

    with pytest.raises(PluginError, match=reason):
        load_registry([tmp_path / name], environ=ALONE)


def test_broken_file_leaves_no_module(tmp_path: Path) -> None:
    """What a broken file defined before it failed is forgotten."""
    file = tmp_path / "mine.py"
    file.write_text("x = 1\n1 / 0")
    before = set(sys.modules)

    with pytest.raises(PluginError):
        load_file(file)

    assert set(sys.modules) == before


def test_edited_file_is_loaded_anew(tmp_path: Path, install: Install) -> None:
    """An edit is seen at once, and what the old text defined can still be pickled."""
    file = tmp_path / "mine.py"
    file.write_text("x = 1")
    old = load_file(file)
    file.write_text("x = 2")

    assert (old.x, load_file(file).x) == (1, 2)
    assert old.__name__ in sys.modules


def test_modules_beside_a_plugin_file_are_found_and_hide_no_others(tmp_path, monkeypatch):
    """A file imports what lies in its folder, from wherever it is loaded; an installed module stays what it is."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "beside_the_plugin.py").write_text("x = 1")
    (tmp_path / "numpy.py").write_text("x = 2")
    file = tmp_path / "mine.py"
    file.write_text("import numpy\nfrom beside_the_plugin import x\n")

    assert load_file(file).x == 1
    assert load_file(file).numpy is sys.modules["numpy"]
    assert "array" in vars(sys.modules["numpy"])


def test_other_process_unpickles_after_loading_the_file(tmp_path: Path, install: Install) -> None:
    """A process that loads the file can read the schemes and problems pickled elsewhere."""
    file = tmp_path / "mine.py"
    file.write_text(SCHEME + PROBLEM)
    registry = load_registry([file], environ=ALONE)
    scheme = registry.schemes["fake-scheme"].make({"order": "3"})
    problem = registry.problems["fake-problem"].make({"a": "2"})
    message = pickle.dumps((scheme, problem))
    del sys.modules[type(scheme).__module__]

    for path in registry.files:
        load_file(path)

    assert [thing.label for thing in pickle.loads(message)] == ["fake-scheme[order=3]", "fake-problem[a=2]"]


# Entries


def test_scheme_with_parameters(install: Install) -> None:
    """Texts become a scheme; what it does not accept is a parameter error that names it."""
    install("fake-dist", {"fake_plugin.py": SCHEME}, {"fake": "fake_plugin"})
    entry = load_registry(environ=ALONE).schemes["fake-scheme"]

    assert entry.make({"mode": "2"}).label == 'fake-scheme[mode="2"]'
    with pytest.raises(
        ParameterError, match=r"^scheme 'fake-scheme': ValueError: negative order \(fake_plugin.py:\d+\)$"
    ):
        entry.make({"order": "-1"})
    with pytest.raises(ParameterError, match=r"^parameter order of scheme 'fake-scheme' expects a number, got 'x'$"):
        entry.make({"order": "x"})


def test_problem_with_parameters(install: Install) -> None:
    """Texts become a recipe, equal to another one exactly if the labels are; it builds the problem."""
    install("fake-dist", {"fake_plugin.py": PROBLEM}, {"fake": "fake_plugin"})
    entry = load_registry(environ=ALONE).problems["fake-problem"]

    assert entry.make({"a": "1", "label": "x"}) == entry.make()
    assert entry.make({"a": "2"}).label == "fake-problem[a=2]"
    assert entry.make({"a": "2"}).build().source == "made up"
    with pytest.raises(ParameterError, match="problem 'fake-problem' has no parameter 'b'"):
        entry.make({"b": "2"})


def test_problem_function_that_returns_no_problem(install: Install) -> None:
    """The error names the function and its file."""
    install("fake-dist", {"fake_plugin.py": PROBLEM}, {"fake": "fake_plugin"})
    spec = load_registry(environ=ALONE).problems["no-problem"].make()

    with pytest.raises(
        ProblemError, match=r"^no_problem in fake_plugin\.py returned an object of type dict, expected a problem"
    ):
        spec.build()


# Reports


def test_report_hooks_are_isolated(tmp_path: Path, install: Install) -> None:
    """Each report hook gets the folder; one that fails is one line, and the others go on."""
    writer = f"{HEADER}\n@hookimpl\ndef sdaeverify_report(folder): (folder / 'more.txt').write_text('x')\n"
    files = {"fake_a.py": hook("sdaeverify_report", "1 / 0"), "fake_b.py": writer}
    install("fake-dist", files, {"a": "fake_a", "b": "fake_b"})

    failures = load_registry(environ=ALONE).report(tmp_path, None)

    assert failures == ("report of plugin a: ZeroDivisionError: division by zero (fake_a.py:10)",)
    assert (tmp_path / "more.txt").read_text() == "x"


# Environment


@pytest.mark.parametrize("name", ["fake", "Fake_Dist"])
def test_disabled_by_entry_point_or_distribution(install: Install, name: str) -> None:
    """A disabled plugin is not even imported, and its row says why."""
    install("fake-dist", {"fake_plugin.py": "raise KeyboardInterrupt"}, {"fake": "fake_plugin"})

    registry = load_registry(environ={"SDAEVERIFY_DISABLED_PLUGINS": f" {name}, "})

    assert row(registry, "fake")[4:6] == ("disabled", "named in SDAEVERIFY_DISABLED_PLUGINS")
    assert registry.warnings == ()


def test_disabled_module_of_a_package(install: Install) -> None:
    """One module of a package can be left out."""
    files = {"fake_package/__init__.py": "", "fake_package/a.py": SCHEME, "fake_package/b.py": PROBLEM}
    install("fake-dist", files, {"fake": "fake_package"})

    registry = load_registry(environ={"SDAEVERIFY_DISABLED_PLUGINS": "fake.a"})

    assert (row(registry, "fake.a").status, row(registry, "fake.b").status) == ("disabled", "loaded")
    assert registry.warnings == ()


def test_disabled_name_that_is_no_plugin(install: Install) -> None:
    """A name that disables nothing gives a warning with what is close."""
    install("fake-dist", {"fake_plugin.py": SCHEME}, {"fakeplug": "fake_plugin"})

    registry = load_registry(environ={"SDAEVERIFY_DISABLED_PLUGINS": "fakepluk"})

    assert registry.warnings == (
        "SDAEVERIFY_DISABLED_PLUGINS names 'fakepluk', which is no plugin; did you mean fakeplug?",
    )


def test_every_entry_point_can_be_disabled(install: Install, monkeypatch: pytest.MonkeyPatch) -> None:
    """Names of sources, executors, hooks, functions and commands cause no warning, and are no longer offered."""
    names = ["sdaeverify_adaptive", "wire", "dask", "orders", "hunt", "sdaeverify-planted"]
    monkeypatch.setenv("SDAEVERIFY_DISABLED_PLUGINS", ",".join(names))

    assert load_registry().warnings == ()
    assert "wire" not in plugin_sources()
    assert not hasattr(sdaeverify, "hunt")
    with pytest.raises(UsageError, match="unknown executor 'dask'"), crew_of(1, None, Registry({}), "dask"):
        pass


def test_hook_of_a_disabled_plugin_registers_nothing(install: Install) -> None:
    """The plugin that implements it is loaded, and the class of the hook's objects is not imported."""
    odd = hook("sdaeverify_adaptive", "return ['gbm']")
    install("fake-dist", {"fake_plugin.py": odd}, {"fake": "fake_plugin"})

    reason = row(load_registry(environ={}), "fake").reason
    assert reason.startswith("sdaeverify_adaptive expects each to be Adaptive, got ")
    found = row(load_registry(environ={"SDAEVERIFY_DISABLED_PLUGINS": "sdaeverify_adaptive"}), "fake")
    assert (found.status, found.further) == ("loaded", (("sdaeverify_adaptive", 0),))


def test_file_that_is_named_and_disabled(tmp_path: Path) -> None:
    """A contradiction between the command line and the environment is an error that names both."""
    (tmp_path / "mine.py").write_text(SCHEME)

    with pytest.raises(PluginError, match=r"mine\.py: SDAEVERIFY_DISABLED_PLUGINS disables mine; remove the name or"):
        load_registry([tmp_path / "mine.py"], environ={"SDAEVERIFY_DISABLED_PLUGINS": "mine"})


@pytest.mark.parametrize("switch", ["1", "YES", "true"])
def test_strict_refuses_broken_plugins(install: Install, switch: str) -> None:
    """All broken plugins are named."""
    files = {"fake_a.py": "1 / 0", "fake_b.py": ""}
    install("fake-dist", files, {"a": "fake_a", "b": "fake_b"})

    with pytest.raises(PluginError, match=r"a \(fake-dist 1\.0\): ZeroDivisionError.*; b \(fake-dist 1\.0\): impl"):
        load_registry(environ={"SDAEVERIFY_STRICT_PLUGINS": switch})


@pytest.mark.parametrize("switch", ["", "0", "no"])
def test_strict_switched_off(install: Install, switch: str) -> None:
    """Without the switch a broken plugin is a row."""
    install("fake-dist", {"fake_a.py": "1 / 0"}, {"a": "fake_a"})

    assert row(load_registry(environ={"SDAEVERIFY_STRICT_PLUGINS": switch}), "a").status == "broken"


def test_strict_is_yes_or_no() -> None:
    """A value that is neither is one line and not taken for yes."""
    with pytest.raises(UsageError, match="SDAEVERIFY_STRICT_PLUGINS expects 0 or 1, got 'maybe'"):
        load_registry(environ={"SDAEVERIFY_STRICT_PLUGINS": "maybe"})


def test_unknown_variable() -> None:
    """A variable with the prefix that means nothing gives a warning."""
    registry = load_registry(environ={"SDAEVERIFY_STRICT_PLUGIN": "1", "SDAE": "1"})

    assert registry.warnings == (
        "unknown environment variable SDAEVERIFY_STRICT_PLUGIN; did you mean SDAEVERIFY_STRICT_PLUGINS?",
    )
