"""Each numeric constant of the rooms that judge and probe says where its number comes from."""

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
ROOMS = ("verdicts", "measures", "probe")
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

# Constants of probes that do not say it yet: the list only gets shorter.
UNTOLD = {
    "probe/balance.py": "BISECTIONS NODES NEWTON LEAST ALIKE FEW KNOWN TIMES",
    "probe/explosion.py": "PARTS WINDOW LATE SHOWN SHARE",
    "probe/linear/delay_equation.py": "UNIT",
    "probe/linear/delay_step.py": "REACH",
    "probe/linear/equation.py": "RESIDUAL",
    "probe/linear/linear_map.py": "LARGEST",
    "probe/linear/moments.py": "SHORT KNOWN DELAY_FURTHER",
    "probe/linear/pair.py": "ILL",
    "probe/linear/step_moments.py": "TOLERANCE ROUNDS FAR SPACING ZOOM LOOKED EXPONENT AGREEMENT",
    "probe/local/delay_links.py": "CLOSE",
    "probe/local/far_noise.py": "SMALL",
    "probe/local/orders.py": "TOLERANCE FLAT ROUNDING SETTLED",
    "probe/local/reach.py": "TIMES STEP",
    "probe/local/romberg.py": "SHALLOWEST",
    "probe/local/run_memory.py": "SMALL DIVERGED",
    "probe/local/smoothness.py": "FALLS SMALL TINY",
    "probe/local/solved_instead.py": "SIZE RESOLUTION NO_NOISE ALONG CHANGED SIMPLE",
    "probe/local/step_law.py": "SMALL SETTLED MANY MOVED TYPICAL ROUNDINGS",
    "probe/local/strong_defects.py": "NOT_ASYMPTOTIC SMALL UP_TO_1",
    "probe/local/strong_order.py": "LEAST_Q2 FOURTH ACCURACY",
    "probe/local/weak_defects.py": "LEAST ROUNDINGS NEAR",
    "probe/local/weak_order.py": "FEWEST_LEVELS ABOVE_PLATEAU SETTLED ROUGH STALL CROWD CONSISTENT MOST",
    "probe/operator/chart_equation.py": "CONSISTENT",
    "probe/operator/functional_orders.py": "CLEAR FEWEST ABOVE_FLOOR EXACT SETTLED NEEDED NEAR BETWEEN LEAST_SIGNALS",
    "probe/operator/point_law.py": "SAME FEWEST",
    "probe/operator/transition.py": "BLOWN_UP AFFINE ON_CHART",
    "probe/operator/transition_errors.py": "FUNCTION REACH NEGATIVE",
    "probe/stability/delay_radius.py": "ERRORS LARGEST_RADIUS DENSE ABOVE",
    "probe/stability/spectral.py": "WIDTHS RESIDUAL LARGE",
    "probe/stability/windows.py": "MARGIN STEEPER",
    "probe/step/component_units.py": "FAR NUDGE",
    "probe/step/memory.py": "ERRORS ROUNDING NEAR LEAST_ORDER",
    "probe/step/nodes.py": "FEWEST",
    "probe/step/one_step.py": "RESOLVED FEW_STEPS",
    "probe/step/states.py": "FARTHEST DIFFERENCE CLOSE WHEN SLOW BENT NEARBY",
    "probe/step/step_noise.py": "MANY",
    "probe/step/times.py": "WHOLE H SAME UNLIKE ALIKE",
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
