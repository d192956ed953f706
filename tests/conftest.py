"""What all tests share: runs of pytest inside a test, compiled modules, and the rule of what is quick."""

import gc
import os
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

pytest_plugins = "pytester"

# How long an example takes is the machine's affair. The tests of the site are run without hypothesis.
with suppress(ImportError):
    import hypothesis

    hypothesis.settings.register_profile("any machine", deadline=None)
    hypothesis.settings.load_profile("any machine")

HERE = Path(__file__).parent
# Whoever imports something from there samples, starts programs, runs whole studies or plans all that is shipped.
COSTLY = ("multiprocessing", "sdaeverify.api", "sdaeverify.cli.program", "sdaeverify.lab", "sdaeverify.workers")
COSTLY += ("sdaeverify.registry.load", "subprocess")
# Tests of programs and files, of the lab and of what is shipped: nothing in these folders is quick.
PROGRAMS = {"benchmarks", "cli", "report", "scaffold", "store", "testing"}
SHIPPED = {"bridges", "calibration", "experiments", "planted", "problems", "schemes", "selftest", "statistical"}
LEFT_OUT = PROGRAMS | SHIPPED
# Of a sweep, a test that is marked so, every third case stays, and the others are long, or slow if it is long itself.
SWEEP = 3
# Of so many cases of a test, one is quick; in rooms of short arithmetic all are.
CASES, WHOLE = 50, {"forms", "gate", "measures", "numerics"}

# Where the environment says that nothing compiled be kept, each of the hundred programs that tests start compiles the
# package anew, for half a second. Git ignores what is kept.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
# Tests run one on each core: threads of linear algebra would wait for each other there, three times as long.
os.environ.setdefault("OMP_NUM_THREADS", "1")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Look for no cycles among ten thousand tests, which stay to the end: not now, and not with each later search."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Read no folder that has nothing quick where only that is asked for."""
    return True if config.option.markexpr == "quick" and collection_path.name in LEFT_OUT else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark as quick what neither samples nor starts programs: of a test with many cases the first, and some more."""
    thin_sweeps(items)
    met: Counter[str] = Counter()
    for item in items:
        test = item.nodeid.partition("[")[0]
        if (met[test] % CASES == 0 or room(item) in WHOLE) and is_cheap(item):
            item.add_marker("quick")
        met[test] += 1


def thin_sweeps(items: list[pytest.Item]) -> None:
    """Give the cases of sweeps but for the first and every third one after it the marker of all others."""
    met: Counter[str] = Counter()
    for item in items:
        sweep = item.get_closest_marker("sweep")
        others = sweep.kwargs.get("others", "long") if sweep else ""
        if sweep and not (item.get_closest_marker(others) or item.get_closest_marker("slow")):
            test = item.nodeid.partition("[")[0]
            if met[test] % SWEEP:
                item.add_marker(others)
            met[test] += 1


def is_cheap(item: pytest.Item) -> bool:
    """Tell by its folder and by what its file imports whether a test is done in milliseconds."""
    if room(item) in LEFT_OUT | {"thirdparty"} or item.get_closest_marker("slow") or item.get_closest_marker("long"):
        return False
    named = vars(item.module).values()  # type: ignore[attr-defined]
    origins = (getattr(each, "__module__", None) or getattr(each, "__name__", "") for each in named)
    return not any(str(origin).startswith(COSTLY) for origin in origins)


def room(item: pytest.Item) -> str:
    """Return the folder of tests that a test is in."""
    return item.path.relative_to(HERE).parts[0] if item.path.is_relative_to(HERE) else "thirdparty"
