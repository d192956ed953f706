"""Programs in C and schemes in Python with the same operations: the same bits, whatever is asked of them."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from facade import delay_linear, flatten, gbm, harmonic_langevin, pendulum
from sdaeverify_wire.scheme import scheme_of, session_of
from wire import twins
from wire.compiling import built_c

# A program, its scheme in Python, and problems of its form.
PAIRS = {
    "wired_milstein": (twins.Milstein, "gbm", (gbm,)),
    "wired_langevin": (twins.SymplecticEuler, "harmonic-langevin", (harmonic_langevin,)),
    "wired_verlet": (twins.Verlet, "harmonic-langevin", (harmonic_langevin,)),
    "wired_holonomic": (twins.HalfExplicit, "pendulum", (pendulum,)),
    "wired_delay": (twins.DelayEuler, "delay-linear", (delay_linear,)),
}
# Every change makes whole runs of the first pair; the others take minutes together.
WITH_MARKS = [
    pytest.param(name, marks=pytest.mark.slow if place else pytest.mark.long) for place, name in enumerate(PAIRS)
]
# Columns of a run that tell of the machine, and texts in which the author's words for a claim stand.
OWN = {"seconds", "source", "cpu_seconds"}


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """Return a function that builds a program once."""
    folder, known = tmp_path_factory.mktemp("programs"), {}

    def build(name, *flags):
        if (name, flags) not in known:
            # A folder each: a program with other flags would take the place of the one that was built before.
            place = folder / str(len(known))
            place.mkdir()
            known[name, flags] = built_c(place, name, *flags)
        return known[name, flags]

    return build


@pytest.mark.sweep
@pytest.mark.parametrize("name", PAIRS)
def test_steps_have_the_same_bits(name, programs):
    """Many steps from the start, with any number of paths, end at the same state to the last bit."""
    twin, _, problems = PAIRS[name]
    wired, scheme, rng = scheme_of(programs(name)), twin(), np.random.default_rng(5)
    for problem in (family() for family in problems):
        for paths, h in ((1, 0.25), (17, 0.125), (3000, 2.0**-6)):
            recall, states = problem.recall(h, paths), [each.start(problem, paths, h) for each in (wired, scheme)]
            for step in range(6):
                noise = problem.drawn(rng, h, paths)
                noise = noise if recall is None else recall.add_past(noise)
                states = [
                    each.step(problem, x, step * h, h, noise).state
                    for each, x in zip((wired, scheme), states, strict=True)
                ]
                np.testing.assert_array_equal(*map(flatten, states))
                if recall is not None:
                    recall.push(states[0].x)
    session_of(wired.calling).drop()


def run(folder, plugin, *arguments):
    """Run a command line in a folder, with a plugin file if there is one."""
    command = [sys.executable, "-m", "sdaeverify", *arguments, *(["--plugin", str(plugin)] if plugin else [])]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=600)


def rows(file):
    """Return the rows of a table without what tells of the machine."""
    with file.open() as opened:
        return [{name: value for name, value in row.items() if name not in OWN} for row in csv.DictReader(opened)]


def plugins(folder, programs, name, *flags):
    """Return the plugin files of a program and of its twin."""
    wired, twin = folder / "wired.py", folder / "twin.py"
    wired.write_text(
        f"from sdaeverify_wire import schemes\nsdaeverify_schemes = schemes({programs(name, *flags)!r})\n"
    )
    shown = f"sys.path.insert(0, {str(Path(__file__).parents[1])!r})"
    only = f"def sdaeverify_schemes():\n    return [twins.{PAIRS[name][0].__name__}()]\n"
    twin.write_text(
        f"import sys\n{shown}\nfrom sdaeverify import hookimpl\nfrom wire import twins\n@hookimpl\n{only}"
    )
    return wired, twin


@pytest.mark.parametrize("name", WITH_MARKS)
def test_runs_have_the_same_bits(name, programs, tmp_path):
    """All measures, order conditions and random members of a run say the same of both, in every digit."""
    label, problem = name.replace("_", "-"), PAIRS[name][1]
    for kind, plugin in zip(("wired", "twin"), plugins(tmp_path, programs, name), strict=True):
        done = run(tmp_path, plugin, "matrix", "-s", label, "-p", problem, "--paths", "2048", "--out", kind)
        assert done.returncode in {0, 1, 3, 4}, done.stderr

    for table in ("verdicts.csv", "details/classes.csv", "levels.csv"):
        wired, twin = (rows(tmp_path / kind / table) for kind in ("wired", "twin"))
        assert wired == twin
        assert wired
        assert "error" not in {row.get("verdict") for row in wired}


@pytest.mark.slow
@pytest.mark.long
def test_orders_have_the_same_bits(programs, tmp_path):
    """The conditions of all trees are the same, and a wrong sign is refuted by its tree."""
    wired, twin = plugins(tmp_path, programs, "wired_milstein")
    given = ("orders", "wired-milstein", "--class", "scalar", "--json")
    found = [json.loads(run(tmp_path, plugin, *given).stdout) for plugin in (wired, twin)]
    assert found[0] == found[1]

    wrong, _ = plugins(tmp_path, programs, "wired_milstein", "-DSIGN=-")
    done = run(tmp_path, wrong, "orders", "wired-milstein", "--class", "scalar")
    assert done.returncode == 1
    assert "b1(b1)" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", WITH_MARKS)
def test_gate_hunt_and_kit_say_the_same(name, programs, tmp_path):
    """A lock, a search for a counterexample and the checks of the kit do not differ between the two."""
    said, label, problem = [], name.replace("_", "-"), PAIRS[name][1]
    for kind, plugin in zip(("wired", "twin"), plugins(tmp_path, programs, name), strict=True):
        lines = [
            f"plugins = [{str(plugin)!r}]",
            'tier = "smoke"',
            f'problems = ["{problem}"]',
            f'lock = "{kind}.lock"',
        ]
        (tmp_path / "pyproject.toml").write_text("\n".join(["[tool.sdaeverify]", *lines, ""]))
        gated = run(tmp_path, None, "gate", "--write-lock", "--progress", "none")
        hunted = run(tmp_path, plugin, "hunt", label, "-m", "strong", "--examples", "2")
        checked = run(tmp_path, plugin, "check", label, problem)
        assert [done.returncode for done in (gated, hunted, checked)] == [0, 0, 0], gated.stdout + gated.stderr
        said.append(((tmp_path / f"{kind}.lock").read_text(), hunted.stdout, checked.stdout))

    assert said[0] == said[1]
