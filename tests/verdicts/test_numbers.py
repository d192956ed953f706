"""Each numeric constant of the rooms that judge and probe says where its number comes from."""

import ast
import re
from pathlib import Path

import pytest

import sdaeverify

ROOT = Path(sdaeverify.__file__).parent
# A level; a bound of rounding, with its derivation; a theorem, with its source; a file that has measured it; or a
# size of what is sampled or kept, on which the cost of a verdict depends and its truth does not; or a number on which
# the words of a reason depend, and no verdict.
KINDS = re.compile(
    r"# .*(Level|Rounding|Theorem|Size|Words)[:.]|# .*Measured by (sdaeverify|plugins|tests|reports)/\S+"
)
CHOSEN = re.compile("# .*Chosen[:.]")
ROOMS = ("verdicts", "measures", "probe")
# Constants that are none of these. Derive one, or remove it: the list only gets shorter.
UNKNOWN = {
    "measures/invariant/chain_order.py CONFIRMED",
    "measures/path_errors/order.py WRONG_LIMIT",
    "measures/weak/__init__.py FUNCTIONALS",
    "measures/weak/probe.py MANY",
    "verdicts/path_tests.py COARSE",
}

# Constants of probes that do not say it yet: the list only gets shorter.
UNTOLD = {
    "probe/explosion.py": "SHARE",
    "probe/local/step_law.py": "MANY",
    "probe/local/weak_order.py": "SETTLED CROWD MOST",
}
LACKING = {f"{path} {name}" for path, names in UNTOLD.items() for name in names.split()}


def numbers():
    """Yield the constants, and the comment above each."""
    for path in sorted(path for room in ROOMS for path in (ROOT / room).rglob("*.py")):
        lines = path.read_text().splitlines()
        for node in ast.parse("\n".join(lines)).body:
            if isinstance(node, ast.Assign) and _is_numeric(node.value):
                first = node.lineno - 1
                while lines[first - 1].startswith("#"):
                    first -= 1
                name = ast.unparse(node.targets[0]).strip("()").partition(",")[0]
                yield f"{path.relative_to(ROOT).as_posix()} {name}", "\n".join(lines[first : node.lineno - 1])


def _is_numeric(node):
    """Return whether an expression is made of numbers alone, and of at least one."""
    parts = list(ast.walk(node))
    if any(isinstance(each, ast.JoinedStr | ast.Dict | ast.Lambda | ast.Attribute) for each in parts):
        return False
    constants = [each.value for each in parts if isinstance(each, ast.Constant)]
    return bool(constants) and all(type(each) in {int, float} for each in constants)


def test_numbers_are_found():
    """The search sees plain numbers, tuples and products."""
    names = {name for name, _ in numbers()}
    assert {"verdicts/path_tests.py RESOLVED", "measures/path_errors/order.py WRONG_LIMIT"} <= names
    assert {"measures/resolution.py ROUNDING", "measures/strong/findings.py RISING"} <= names


@pytest.mark.parametrize(("name", "comment"), list(numbers()), ids=lambda value: value.split("\n")[0][:60])
def test_a_number_says_where_it_comes_from(name, comment):
    """By one of the kinds, or as chosen, or not at all; the lists above count both."""
    assert bool(CHOSEN.search(comment)) is (name in UNKNOWN)
    assert name in UNKNOWN or bool(KINDS.search(comment)) is (name not in LACKING)


def test_what_is_listed_exists():
    """A constant that is derived or removed leaves the list."""
    assert {name for name, _ in numbers()} >= UNKNOWN | LACKING
