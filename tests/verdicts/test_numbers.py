"""Each numeric constant of the rooms that judge says where its number comes from."""

import ast
import re
from pathlib import Path

import pytest

import sdaeverify

ROOT = Path(sdaeverify.__file__).parent
# A level; a bound of rounding, with its derivation; a theorem, with its source; a file that has measured it; or a
# size of what is sampled or kept, on which the cost of a verdict depends and its truth does not.
KINDS = re.compile(r"# .*(Level|Rounding|Theorem|Size)[:.]|# .*Measured by (sdaeverify|plugins|tests|reports)/\S+")
CHOSEN = re.compile("# .*Chosen[:.]")
# Constants that are none of these. Derive one, or remove it: the list only gets shorter.
UNKNOWN = {
    "measures/drift.py FLAT",
    "measures/intervals.py TOLERANCE",
    "measures/invariant/__init__.py TOLERANCE",
    "measures/invariant/chain_findings.py ENOUGH",
    "measures/invariant/chain_order.py CONFIRMED",
    "measures/path_errors/consistency.py SLOWEST",
    "measures/path_errors/order.py FALLING",
    "measures/path_errors/order.py WRONG_LIMIT",
    "measures/strong/findings.py SETTLED",
    "measures/strong/findings.py TOLERANCE",
    "measures/weak/__init__.py FUNCTIONALS",
    "measures/weak/__init__.py SLACK",
    "measures/weak/probe.py MANY",
    "measures/weak/probe.py TOLERANCE",
    "verdicts/fitted_levels.py FEWEST",
    "verdicts/path_tests.py COARSE",
}


def numbers():
    """Yield the constants, and the comment above each."""
    for path in sorted([*(ROOT / "verdicts").rglob("*.py"), *(ROOT / "measures").rglob("*.py")]):
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
    """By one of the kinds, or as chosen, which the list above counts."""
    assert bool(CHOSEN.search(comment)) is (name in UNKNOWN)
    assert KINDS.search(comment) or name in UNKNOWN


def test_what_is_listed_exists():
    """A constant that is derived or removed leaves the list."""
    assert {name for name, _ in numbers()} >= UNKNOWN
