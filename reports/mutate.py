"""Mutants of the rules of verdicts, each of which some fast test has to notice.

    python reports/mutate.py [FILE ...]

A mutant turns one comparison, `and` or `or`, a `not`, a sign or a constant of a module. It is killed if one of the
tests of its room in `TESTS` fails. Each is tried in a process of its own, forked from one that has loaded these tests
and where the changed function gets the changed code. What no test notices there, and a changed constant of a module,
are tried again in a process that loads the changed module anew. Survivors are written into
`reports/mutants/survivors.csv`, with the explanations that are there already.
"""

import ast
import copy
import csv
import importlib
import importlib.abc
import importlib.util
import os
import resource
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "reports" / "mutants" / "survivors.csv"
COLUMNS = ("file", "function", "mutant", "explanation")
FILES = (
    *(
        f"sdaeverify/verdicts/{name}.py"
        for name in ("coverage", "fitted_levels", "moments", "opinions", "path_tests", "rules")
    ),
    *(f"sdaeverify/measures/path_errors/{name}.py" for name in ("consistency", "errors", "order", "quantity")),
    *(f"sdaeverify/measures/strong/{name}.py" for name in ("findings", "members")),
    *(f"sdaeverify/probe/local/{name}.py" for name in ("consistency", "step_law")),
    *(f"sdaeverify/gate/{name}.py" for name in ("lock", "outcomes")),
    "sdaeverify/store/class_findings.py",
    "sdaeverify/study/agreement.py",
)
# By room, in this order: most mutants are killed by the first ones, which take a second.
TESTS = {
    "gate": (["expected", "lock", "lock_sense", "outcomes", "own_lock", "policy"], ["reports", "untested"]),
    "measures": (
        ["path_errors", "strong"],
        ["strong_findings", "verdicts/limits_of_rules"],
        ["order_resolution", "probe/consistency"],
    ),
    "probe": (["step_law", "consistency", "delay_consistency"], ["conformance/step_law", "own_noise"]),
    "store": (["class_findings"],),
    "study": (["verdicts/limits_of_rules", "agreement"], ["controlled", "families", "guards", "cli/silent_inputs"]),
    "verdicts": (
        ["limits_of_rules", "deciding"],
        ["gate/expected", "gate/outcomes", "measures/contradictions", "measures/coverage", "measures/guard"],
        ["measures/mean_order", "measures/order_resolution", "measures/strong"],
    ),
}
# Of processor time, so that a busy machine kills no mutant; and how many times as long it may wait.
SECONDS, WAITS = 120, 20
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


def survivors(file: str) -> Iterator[Mutant]:
    """Yield the mutants of a file that no test of its room notices.

    Raises
    ------
    SystemExit
        If the tests fail on the file as it is, or pass on one that cannot be loaded.
    """
    room = file.split("/")[1]
    groups = [[_test(room, name) for name in names] for names in TESTS[room]]
    if any(_fails(Mutant(file, "", "", ast.parse((ROOT / file).read_text())), tests) for tests in groups):
        sys.exit(f"the tests fail on {file} as it is")
    if not _fails(Mutant(file, "", "", ast.parse("raise ImportError")), groups[0]):
        sys.exit(f"the tests do not load {file} as it is changed")
    left = [number for number, each in enumerate(mutants(file)) if not each.function]
    left += _unnoticed(file, groups)
    for number, mutant in enumerate(mutants(file)):
        if number in left and not any(_fails(mutant, tests) for tests in groups):
            yield mutant


def _test(room: str, name: str) -> str:
    """Return the file of a test, of this room or of the one that is named."""
    folder, _, name = name.rpartition("/")
    return f"tests/{folder or room}/test_{name}.py"


def _unnoticed(file: str, groups: Sequence[Sequence[str]]) -> list[int]:
    """Return the numbers of the mutants that tests do not notice which were loaded before the change."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        with suppress(BaseException):
            os.close(reading)
            with _silent():
                sys.modules["pytest"].main(
                    [*(test for tests in groups for test in tests), *OPTIONS, "--collect-only"]
                )
            for number, mutant in enumerate(mutants(file)):
                if mutant.function and not any(_fails(mutant, tests, loaded=True) for tests in groups):
                    os.write(writing, f"{number}\n".encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as lines:
        found = [int(line) for line in lines]
    os.waitpid(child, 0)
    return found


def _fails(mutant: Mutant, tests: Sequence[str], *, loaded: bool = False) -> bool:
    """Return whether a test fails, or takes too long; the module is changed in place if it is `loaded`."""
    child = os.fork()
    if child == 0:
        code = 1
        with suppress(BaseException):
            resource.setrlimit(resource.RLIMIT_CPU, (used := _seconds() + SECONDS, used))
            signal.alarm(WAITS * SECONDS)
            if loaded:
                _change(mutant)
            else:
                sys.meta_path.insert(0, Finder(mutant))
            with _silent():
                code = int(sys.modules["pytest"].main([*tests, *OPTIONS]))
        os._exit(code)
    return os.waitpid(child, 0)[1] != 0


def _seconds() -> int:
    return int(sum(resource.getrusage(resource.RUSAGE_SELF)[:2])) + 1


@contextmanager
def _silent() -> Iterator[None]:
    null, known = os.open(os.devnull, os.O_WRONLY), [os.dup(1), os.dup(2)]
    os.dup2(null, 1)
    os.dup2(null, 2)
    yield
    for number, file in enumerate(known, 1):
        os.dup2(file, number)


def _change(mutant: Mutant) -> None:
    """Give a function of a loaded module the code of the changed one."""
    finder = Finder(mutant)
    changed = ModuleType(finder.name)
    changed.__package__ = sys.modules[finder.name].__package__
    finder.exec_module(changed)
    old, new = (_function(module, mutant.function) for module in (sys.modules[finder.name], changed))
    old.__code__, old.__defaults__, old.__kwdefaults__ = new.__code__, new.__defaults__, new.__kwdefaults__


def _function(module: ModuleType, name: str) -> FunctionType:
    """Return a function of a module or of a class, without its decorators."""
    found: Any = module
    for part in name.split("."):
        found = vars(found)[part]
    for wrapping in ("fget", "func", "__func__", "__wrapped__"):
        found = getattr(found, wrapping, None) or found
    assert isinstance(found, FunctionType)
    return found


def main(files: Sequence[str]) -> int:
    """Try the mutants of some files, or of all."""
    os.chdir(ROOT)
    for name in ("pytest", "numpy", "pandas", "scipy.linalg", "scipy.optimize", "scipy.special"):
        importlib.import_module(name)
    known = list(csv.DictReader(TABLE.open(encoding="utf-8"))) if TABLE.is_file() else []
    said = {(row["file"], row["function"], row["mutant"]): row["explanation"] for row in known}
    kept = [row for row in known if row["file"] not in (files or FILES)]
    for file in files or FILES:
        count = 0
        for mutant in survivors(file):
            count += 1
            place = file, mutant.function, mutant.change
            print(*place, flush=True)
            kept.append(dict(zip(COLUMNS, (*place, said.get(place, "")), strict=True)))
        print(f"{file}: {sum(1 for _ in mutants(file))} mutants, {count} survivors", flush=True)
    TABLE.parent.mkdir(exist_ok=True)
    with TABLE.open("w", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(kept)
    return int(any(not row["explanation"] for row in kept))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
