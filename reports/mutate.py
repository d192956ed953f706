"""Mutants of the rules of verdicts, each of which some fast test has to notice.

    python reports/mutate.py [FILE ...]

A mutant turns one comparison, `and` or `or`, a `not`, a sign or a constant of a module. It is killed if one of the
tests in `TESTS` fails. Each is tried in a process of its own, which is forked from one that has loaded the libraries.
Survivors are written into `reports/mutants/survivors.csv`, with the explanations that are there already.
"""

import ast
import copy
import csv
import importlib
import importlib.abc
import importlib.util
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "reports" / "mutants" / "survivors.csv"
COLUMNS = ("file", "function", "mutant", "explanation")
VERDICTS = ("coverage", "divergence", "fitted_levels", "opinions", "path_tests", "rules")
FILES = (
    *(f"sdaeverify/verdicts/{name}.py" for name in VERDICTS),
    "sdaeverify/measures/strong/findings.py",
    "sdaeverify/measures/path_errors/consistency.py",
    "sdaeverify/gate/outcomes.py",
    "sdaeverify/study/agreement.py",
)
# In this order: most mutants are killed by the first ones, which take a second.
TESTS = (
    ("tests/verdicts/test_limits_of_rules.py",),
    (
        "tests/test_reason.py",
        "tests/gate/test_outcomes.py",
        "tests/measures/test_contradictions.py",
        "tests/measures/test_coverage.py",
        "tests/measures/test_guard.py",
        "tests/measures/test_mean_order.py",
        "tests/measures/test_order_resolution.py",
        "tests/measures/test_strong.py",
        "tests/study/test_agreement.py",
        "tests/study/test_controlled.py",
        "tests/study/test_families.py",
        "tests/study/test_guards.py",
    ),
)
SECONDS = 120
# pytest rewrites the assertions of packages that have a plugin of its own, and would load the modules as they are.
OPTIONS = ("-x", "-q", "--assert=plain", "-p", "no:cacheprovider", "-p", "no:xdist")
TURNED = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.And: ast.Or, ast.Or: ast.And, ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
}  # fmt: skip


class Mutant(NamedTuple):
    """A changed module.

    Attributes
    ----------
    file, function : str
    change : str
        What stands in place of what.
    tree : ast.Module
    """

    file: str
    function: str
    change: str
    tree: ast.Module


def mutants(file: str) -> Iterator[Mutant]:
    """Yield the mutants of a file."""
    tree = ast.parse((ROOT / file).read_text())
    places = [(node, name) for name, part in _parts(tree) for node in ast.walk(part)]
    for node, name in places:
        for change in _changes(node):
            before = ast.unparse(node)
            undo = copy.copy(node.__dict__)
            node.__dict__.update(change)
            after = ast.unparse(node)
            yield Mutant(file, name, f"{before} -> {after}", ast.fix_missing_locations(copy.deepcopy(tree)))
            node.__dict__.clear()
            node.__dict__.update(undo)


def _parts(tree: ast.Module) -> Iterator[tuple[str, ast.AST]]:
    """Yield the functions of a module, and its constants."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node
        elif isinstance(node, ast.ClassDef):
            yield from ((f"{node.name}.{part.name}", part) for part in node.body if isinstance(part, ast.FunctionDef))
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant | ast.BinOp):
            yield "", node.value


def _changes(node: ast.AST) -> Iterator[dict[str, object]]:
    """Yield changed attributes of a node, one for each mutant."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in TURNED:
        yield {"ops": [TURNED[type(node.ops[0])]()]}
    elif isinstance(node, ast.BoolOp | ast.BinOp) and type(node.op) in TURNED and not _is_text(node):
        yield {"op": TURNED[type(node.op)]()}
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield {"op": ast.UAdd(), "operand": ast.Call(ast.Name("bool", ast.Load()), [node.operand], [])}
    elif isinstance(node, ast.Constant) and type(node.value) is float and node.value:
        yield {"value": 1.5 * node.value}


def _is_text(node: ast.BoolOp | ast.BinOp) -> bool:
    return any(isinstance(each, ast.JoinedStr) for each in ast.walk(node))


class Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Loads a module from a changed tree."""

    def __init__(self, mutant: Mutant) -> None:
        self.mutant = mutant
        self.name = mutant.file.removesuffix(".py").replace("/", ".").removesuffix(".__init__")

    def find_spec(self, fullname: str, path: object, target: object = None):
        """Find the module that is changed."""
        if fullname != self.name:
            return None
        return importlib.util.spec_from_loader(fullname, self, origin=str(ROOT / self.mutant.file))

    def exec_module(self, module: ModuleType) -> None:
        """Run the changed module."""
        module.__file__ = str(ROOT / self.mutant.file)
        exec(compile(self.mutant.tree, module.__file__, "exec"), module.__dict__)


def is_killed(mutant: Mutant) -> bool:
    """Return whether a test fails, or takes too long."""
    return any(_fails(mutant, tests) for tests in TESTS)


def _fails(mutant: Mutant, tests: Sequence[str]) -> bool:
    child = os.fork()
    if child == 0:
        code = 1
        with suppress(BaseException):
            signal.alarm(SECONDS)
            sys.meta_path.insert(0, Finder(mutant))
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, 1)
            os.dup2(null, 2)
            code = int(sys.modules["pytest"].main([*tests, *OPTIONS]))
        os._exit(code)
    return os.waitpid(child, 0)[1] != 0


def main(files: Sequence[str]) -> int:
    """Try the mutants of some files, or of all."""
    os.chdir(ROOT)
    for name in ("pytest", "numpy", "pandas", "scipy.linalg", "scipy.optimize", "scipy.special"):
        importlib.import_module(name)
    known = list(csv.DictReader(TABLE.open(encoding="utf-8"))) if TABLE.is_file() else []
    said = {(row["file"], row["function"], row["mutant"]): row["explanation"] for row in known}
    kept = [row for row in known if row["file"] not in (files or FILES)]
    count = 0
    for file in files or FILES:
        if is_killed(Mutant(file, "", "", ast.parse((ROOT / file).read_text()))):
            sys.exit(f"the tests fail on {file} as it is")
        if not is_killed(Mutant(file, "", "", ast.parse("raise ImportError"))):
            sys.exit(f"the tests do not load {file} as it is changed")
        for mutant in mutants(file):
            count += 1
            if not is_killed(mutant):
                place = mutant.file, mutant.function, mutant.change
                print(*place, flush=True)
                kept.append(dict(zip(COLUMNS, (*place, said.get(place, "")), strict=True)))
    print(f"{count} mutants, {len(kept)} survivors")
    TABLE.parent.mkdir(exist_ok=True)
    with TABLE.open("w", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(kept)
    return int(any(not row["explanation"] for row in kept))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
