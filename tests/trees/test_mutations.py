"""Coefficients of shipped schemes that are changed by one per cent, and planted bugs, are told by trees."""

import ast
import importlib
import inspect
import sys
from types import ModuleType

import pytest

from sdaeverify import SDE, Scheme
from sdaeverify_orders import orders

# Modules, the classes in them, and the classes of equations that their conditions are asked of.
SUBJECTS = [
    ("milstein", "Milstein", "scalar"),
    ("sra1", "SRA1", "additive"),
    ("sri1w1", "SRI1W1", "scalar"),
    ("heun", "HeunAdditive", "additive"),
    ("platen_weak_2", "PlatenWeak2", "scalar"),
    ("platen_weak_2_general", "PlatenWeak2General", "general"),
    ("quicsort", "QUICSORT", "langevin"),
    ("baoab", "BAOAB", "langevin"),
]
FACTORS = (0.99, 1.01)
FAMILIES = ("coefficients", "times", "higher_orders", "states", "contracts", "projections", "uniform")


def is_number(node: ast.AST) -> bool:
    """Tell whether a node is a number that is no index and no power, and not 0, which stays what it is."""
    return isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value != 0.0


def numbers(tree: ast.Module, name: str) -> list[ast.Constant]:
    """Return the numbers in the step of a class, and in the constants of its module."""
    (scheme,) = [node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == name]
    (step,) = [node for node in scheme.body if isinstance(node, ast.FunctionDef) and node.name == "step"]
    constants = [node for node in tree.body if isinstance(node, ast.Assign)]
    return [node for part in (step, *constants) for node in ast.walk(part) if is_number(node)]


def mutants(module: str, name: str, factor: float) -> list[tuple[str, Scheme]]:
    """Return the scheme with each of its numbers changed by a factor."""
    original = importlib.import_module(f"sdaeverify_schemes.{module}")
    source = inspect.getsource(original)
    found = []
    for place in range(len(numbers(ast.parse(source), name))):
        tree = ast.parse(source)
        number = numbers(tree, name)[place]
        where = f"{number.lineno}:{number.col_offset} {number.value}"
        number.value *= factor
        changed = ModuleType(f"sdaeverify_schemes.changed_{module}_{place}")
        changed.__package__ = "sdaeverify_schemes"
        sys.modules[changed.__name__] = changed
        exec(compile(tree, original.__file__, "exec"), changed.__dict__)
        kind = getattr(changed, name)
        kind.name = f"changed-{place}"
        found.append((where, kind()))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(("module", "name", "kind"), SUBJECTS)
def test_each_coefficient_changed_by_one_per_cent_is_refuted(module, name, kind, factor):
    """Every floating-point number in the step of a scheme counts, upwards and downwards."""
    changed = mutants(module, name, factor)
    missed = [where for where, scheme in changed if "refuted" not in set(orders(scheme, kind, 2).table.verdict)]

    assert changed
    assert missed == []


@pytest.mark.slow
def test_planted_bugs_are_refuted_by_trees_and_equivalent_ones_are_not():
    """Of the planted bugs of schemes for SDEs at least 59 are refuted with a tree, and no equivalent change is."""
    bugs = [bug for family in FAMILIES for bug in importlib.import_module(f"sdaeverify_lab.planted.{family}").BUGS]
    refuted = [bug for bug in bugs if SDE in bug.scheme.forms and orders(bug.scheme, motions=2).failing]

    assert len(refuted) >= 59
    assert not any(bug.equivalent for bug in refuted)
