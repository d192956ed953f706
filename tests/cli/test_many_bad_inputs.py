"""Five hundred things that a user may get wrong: each is one line on stderr, with the documented exit code."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

LONG = "x" * 5000
# As the words of a command line; none of them is a number, or one in its range.
NO_NUMBERS = ["", "x", "1e400", "nan", "inf", "-1", "9" * 5000, "0x10", "\udcff", "1 2", "true", "--", "1;2"]
NO_NAMES = [
    *(
        "",
        ",",
        "[",
        "]",
        "gbm[",
        "gbm]",
        "gbm[]]",
        "gbm[=]",
        "gbm[a]",
        "gbm[=1]",
        LONG,
        "[" * 3000,
        "no such",
        "-",
        "GBM",
    ),
    *("gbm[" + "mu=1," * 2000 + "]", "?" * 50 + "z", "zz*", "\x1b[31m", "\udcff", "gbm[__class__=1]", "gbm gbm"),
    *("::error::", "milstein[x=1]", "gbm[mu=x]", f"gbm[{LONG}=1]", "gbm[mu=1][mu=2]", "gbm[mu=[1]]", "a\nb"),
]
NO_FOLDERS = [
    "file",
    "file/below",
    "loop",
    "loop/below",
    LONG,
    "a/" * 3000 + "b",
    "/dev/null",
    "/dev/null/below",
    "a\0b",
]
NO_PLUGINS = [
    *(
        "missing.py",
        "file",
        "folder",
        "loop.py",
        "dangling.py",
        f"{LONG}.py",
        LONG,
        "binary.py",
        "zero.py",
        "deep.py",
    ),
    *("minus.py", "\udcff.py", "a\0b.py", "/dev/null", "", "~nobody/x.py", "mute.py", "generator.py"),
]
# Values of other keys are those of tests/gate/test_policy.py.
NO_POLICIES = {
    "deep-list": "[tool.sdaeverify]\nschemes = " + "[" * 3000 + "]" * 3000,
    "deep-table": "[tool.sdaeverify]\nschemes = " + "{a = " * 3000 + "1" + "}" * 3000,
    "deep-key": f"[tool.sdaeverify]\n{'.'.join('a' * 3000)} = 1",
    "deep-header": f"[{'.'.join(['tool', *('a' * 3000)])}]\nx = 1\n[tool.sdaeverify]\ntier = 1",
    "broken": "[tool.sdaeverify",
    "no-table": "tool = 3",
    "no-tables": "[tool]\nsdaeverify = [1]",
    "huge-number": "[tool.sdaeverify]\nseed = " + "9" * 5000,
    "dated": "[tool.sdaeverify]\nseed = 1979-05-27",
    **{
        f"{key}-{number}": f"[tool.sdaeverify]\n{key} = {value}"
        for key, values in {
            "plugins": ('"x"', '["missing.py"]', '["a\\u0000b.py"]', f'["{LONG}"]', '["loop.py"]'),
            "lock": ("1", '""', '"x.py"', '"folder"', '"loop"', '"file/x"', f'"{LONG}"', '"a\\u0000b"', '"missing"'),
        }.items()
        for number, value in enumerate(values)
    },
}
NO_LOCKS = ["", "x", "[]", "{}", "[" * 100_000, '{"schema_version": 9}', '{"schema_version": 1, "tiers": 3}']
NO_RUNS = ["", "x", "[]", "{}", "[" * 100_000, '{"settings": 3}', '{"schema_version": 1, "settings": {}}', "null"]
OPTIONS = {
    "matrix": (
        *("--paths", "--levels", "--first-levels", "--seed"),
        *("--confidence", "--block", "--max-looks", "--tests-reserved"),
    ),
    "matrix --dry-run": ("-j", "--timeout", "--memory"),
    "gate": ("--alpha", "--seed", "--tier", "--timeout", "--memory", "-j", "--seed-from", "--progress"),
    "compare old new": ("--factor", "--alpha"),
    "check milstein": ("--level",),
    "selftest": ("--paths", "--seed", "-j"),
    "calibrate": ("--repetitions", "--seed", "-j"),
    "reproduce zz": ("--paths", "--seed", "-j"),
}  # fmt: skip
# Where a run would begin if the input were good, it would be a small one in this process.
SMALL = ("--paths", "40", "--levels", "8..32", "-j", "1", "--progress", "none")
MILSTEIN = ("-s", "milstein", "-p", "gbm", "-m", "strong")
FREE = ("-j", "1", "--timeout", "0", "--memory", "0", "--progress", "none", "--tier", "smoke")
PATIENCE = 5.0


def bad_numbers() -> Iterator[tuple[str, ...]]:
    """Yield options with what is no number of theirs."""
    for command, options in OPTIONS.items():
        for option in options:
            yield from (
                (*command.split(), option, value) for value in NO_NUMBERS if (option, value) != ("--timeout", "")
            )


def bad_names() -> Iterator[tuple[str, ...]]:
    """Yield names of schemes, problems, measures and everything else that has one."""
    for number, name in enumerate(NO_NAMES):
        # A gate reads them as a matrix does: one kind of name in turn.
        yield ("matrix", ("-s", "-p", "-m")[number % 3], name, "--dry-run", "-j", "1")
        yield ("gate", ("-p", "-m", "-s")[number % 3], name, *FREE)
        yield from ((command, name) for command in ("info", "check", "reproduce", "list"))
        yield from ((name,), ("check", "milstein", "-p", name), ("new-plugin", "folder", "--name", name))


def bad_folders() -> Iterator[tuple[str, ...]]:
    """Yield places that nothing can be written into, or read from."""
    for folder in NO_FOLDERS:
        yield ("matrix", *MILSTEIN, *SMALL, "--out", folder)
        yield ("gate", *MILSTEIN, *FREE, "--out", folder)
        yield from (("compare", folder, folder), ("merge", folder), ("merge", "old", "--out", folder))
        yield from (("new-plugin", folder), ("reproduce", "zz", "--out", folder))


def bad_plugins() -> Iterator[tuple[str, ...]]:
    """Yield plugin files that are none."""
    commands = (("matrix", "--dry-run", "-j", "1"), ("gate",), ("info", "gbm"), ("check", "gbm"))
    for number, plugin in enumerate(NO_PLUGINS):
        # All load them alike: each is given to a list, and to one of the others in turn.
        yield from ((*command, "--plugin", plugin) for command in (("list",), commands[number % 4]))


def bad_policies() -> Iterator[tuple[str, ...]]:
    """Yield policies and lock files that are none."""
    yield from (("gate", "--config", f"{name}.toml", *FREE) for name in NO_POLICIES)
    yield from (("gate", "--config", f"lock-{number}/pyproject.toml", *FREE) for number in range(len(NO_LOCKS)))
    for place in (*NO_FOLDERS, "folder", "missing", "binary.py"):
        yield ("gate", "--config", place)


def bad_runs() -> Iterator[tuple[str, ...]]:
    """Yield folders of runs that are none."""
    for number in range(len(NO_RUNS)):
        yield from (("compare", f"run-{number}", f"run-{number}"), ("merge", f"run-{number}"))


BAD = {
    kind.__name__: list(kind()) for kind in (bad_numbers, bad_names, bad_folders, bad_plugins, bad_policies, bad_runs)
}
# Products of options or commands and what is given to them: of these every fourth will do where time is short.
PRODUCTS = ("bad_numbers", "bad_names")
STRIDES = {kind: 4 if kind in PRODUCTS else 1 for kind in BAD}


@pytest.fixture
def surroundings(tmp_path: Path) -> None:
    """Make a folder in which much is not what it should be."""
    texts = {
        "file": "a file",
        "deep.py": "x = " + "(" * 3000 + ")" * 3000,
        "minus.py": "x = " + "-" * 100_000 + "1",
        "mute.py": "class Mute(Exception):\n    def __str__(self):\n        raise ValueError\nraise Mute",
        "generator.py": "raise GeneratorExit",
        **{f"{name}.toml": text for name, text in NO_POLICIES.items()},
        **{f"lock-{n}/sdaeverify.lock": text for n, text in enumerate(NO_LOCKS)},
        **{f"lock-{n}/pyproject.toml": '[tool.sdaeverify]\nlock = "sdaeverify.lock"' for n in range(len(NO_LOCKS))},
        **{f"run-{n}/run.json": text for n, text in enumerate(NO_RUNS)},
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "something").write_text("")
    (tmp_path / "binary.py").write_bytes(bytes(range(1, 256)))
    (tmp_path / "zero.py").write_bytes(b"x = 1\0")
    for name in ("loop", "loop.py"):
        (tmp_path / name).symlink_to(name)
    (tmp_path / "dangling.py").symlink_to("nowhere.py")


def wrong(call, arguments: tuple[str, ...]) -> str:
    """Return what is wrong with the answer to bad input; empty if it is one line with the code of wrong usage."""
    begun = time.process_time()
    try:
        outcome = call(*arguments)
    except BaseException as error:  # whatever escapes is a traceback
        return f"raises {type(error).__name__}: {str(error)[:200]!r}"
    spent, lines = time.process_time() - begun, outcome.err.splitlines()
    if outcome.code not in {2, 6} or outcome.out:
        return f"exit code {outcome.code}, {outcome.out[-200:]!r}, {outcome.err[-200:]!r}"
    if len(lines) != 1 or not lines[0].isprintable() or not lines[0].startswith("sdaeverify: error: "):
        return f"no line: {outcome.err[:300]!r}"
    if len(lines[0]) > 2000:
        return f"a line of {len(lines[0])} letters: {lines[0][:100]!r}"
    return f"takes {spent:.1f} s" if spent > PATIENCE else ""


def test_there_are_five_hundred():
    """As many are tried as are promised, and no two of them alike."""
    assert len({each for inputs in BAD.values() for each in inputs}) >= 500


@pytest.mark.usefixtures("surroundings")
@pytest.mark.parametrize(
    ("kind", "every"), [*STRIDES.items(), *(pytest.param(kind, 1, marks=pytest.mark.slow) for kind in PRODUCTS)]
)
def test_bad_inputs(call, kind, every):
    """Whatever is wrong, it is said in one line of letters, and neither a traceback nor a result is shown."""
    found = [(arguments, text) for arguments in BAD[kind][::every] if (text := wrong(call, arguments))]

    assert not found, "\n".join(f"{[word[:40] for word in arguments]}: {text}" for arguments, text in found)


@pytest.mark.long
def test_loop_of_links_in_place_of_evidence(quick, call, tmp_path):
    """A file of evidence that is a loop of links is damaged, whoever reads it; what is computed takes its place."""
    run = (*MILSTEIN, "--out", "out")
    quick(*run)
    for file in tmp_path.rglob("*.sqlite"):
        file.unlink()
        file.symlink_to(file.name)

    compared, again = call("compare", "out", "out"), quick(*run)

    assert (compared.code, compared.err.count("\n")) == (2, 1)
    assert (again.code, again.err) == (0, "")
    assert not any(file.is_symlink() for file in tmp_path.rglob("*.sqlite"))
