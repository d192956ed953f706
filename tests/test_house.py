"""Figures of reports/house.py do not grow: what is met while one cell is verified, and the public names."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

FILE = Path(__file__).parents[1] / "reports" / "house.py"
# Figures reached: whoever lowers one lowers its bound here.
MOST = {"files": 110, "classes": 103, "of them in study": 28}
MOST_NAMES = 235
# Public names that one kind of users has, or none: types of arguments and results, errors, and the kit.
ALONE = {
    "sdaeverify": {"Feature", "Residual", "Structure", "Trait", "Trivial", "modified_equations"},
    "sdaeverify.errors": {"PluginError"},
    "sdaeverify.measuring": {"no_fit", "order_of"},
    "sdaeverify.studying": {"CALIBRATED_PATHS"},
    "sdaeverify.testing": {"check_problem", "parametrize_with_benchmarks", "parametrize_with_examinations"},
    "sdaeverify.trees": {"Grove", "Grown", "Node", "Posed", "Relatives", "TreeClass"},
}
TRACE = """
import json, runpy
trace = runpy.run_path({file!r})["trace"]()
classes = set().union(*trace.classes.values())
print(json.dumps([len(trace.files), len(classes), len(trace.classes["study"])]))
"""


@pytest.fixture(scope="module")
def house():
    """Return reports/house.py as a module."""
    spec = importlib.util.spec_from_file_location("house", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_public_names_do_not_grow(house):
    """A new public name takes the place of another one."""
    assert sum(len(room.__all__) for room in house.ROOMS) <= MOST_NAMES


def test_public_names_have_two_kinds_of_users(house):
    """Two of plugins, packages of others and the site use a name; exceptions are listed."""
    using = [house.words(*places) for places in house.USERS.values()]
    alone = {
        f"{room.__name__}.{name}"
        for room in house.ROOMS
        for name in set(room.__all__) - ALONE.get(room.__name__, set())
        if sum(name in words for words in using) < 2
    }
    assert alone == set()


@pytest.mark.long
def test_one_cell_meets_no_more(tmp_path):
    """In a process of its own, a verified cell enters no more files and meets no more classes than before."""
    command = [sys.executable, "-c", TRACE.format(file=str(FILE))]
    made = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    found = dict(zip(MOST, json.loads(made.stdout), strict=True))
    assert {what: count for what, count in found.items() if count > MOST[what]} == {}
