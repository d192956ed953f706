"""Shipped schemes with one coefficient changed by 1 per cent, by changing the syntax tree of their modules."""

import ast
import importlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from sdaeverify import Scheme
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_schemes

PACKAGE = "sdaeverify_schemes"
BY = 1.01
HALF = ("half-explicit-euler[truncation=none]", "half-explicit-euler[truncation=0.05]")
SEMI = ("semi-implicit-projection-euler", "semi-implicit-projection-euler[noise_projector=new]")
EXPLICIT = ("explicit-projection-euler",)
NEWTON = ("semi-implicit-projection-euler[solver=newton]", "explicit-projection-euler[solver=newton]")
GGL = ("implicit-euler-ggl",)
UNIFORM = ("uniformly-accurate", "uniformly-accurate[theta=1]")
CONSTRAINED = ("constrained-euler", "constrained-euler[direction=new]")
THETA = ("stochastic-theta[theta=1]", "stochastic-theta[theta=0]", "stochastic-theta")
LAGGED = ("lagged-algebraic-theta", "lagged-algebraic-theta[theta=0]")
# Schemes by the module whose coefficients are changed.
MUTATED = {
    "projections/half_explicit_euler": HALF,
    "projections/_old_normals": HALF,
    "projections/semi_implicit_projection_euler": SEMI,
    "projections/explicit_projection_euler": EXPLICIT,
    "projections/_skipping": EXPLICIT,
    "projections/_new_normals": (*SEMI[:1], *EXPLICIT),
    "projections/_position_projection": NEWTON,
    "ggl/implicit_euler_ggl": GGL,
    "ggl/_equations": GGL,
    "penalised/uniformly_accurate": UNIFORM,
    "penalised/_uniform_weights": UNIFORM,
    "penalised/_penalty_integrals": UNIFORM,
    "penalised/constrained_euler": CONSTRAINED,
    "penalised/_implicit_langevin": (*UNIFORM, *CONSTRAINED),
    "penalised/_multiplier": (UNIFORM[0], CONSTRAINED[0]),
    "penalised/_turning_normals": (UNIFORM[1], "uniformly-accurate[theta=0.5]", CONSTRAINED[1]),
    "delays/_theta": (*THETA, *LAGGED),
    "delays/stochastic_theta": THETA,
    "delays/lagged_algebraic_theta": LAGGED,
}
# Coefficients of problems and their products, and what they are named in a step.
CALLS = {
    "force",
    "diffused",
    "inverse_mass",
    "push",
    "drift",
    "eliminated",
    "times",
    "transposed",
    "solve",
    "constraint",
}
CALLS |= {"inherent_multiplier", "ahead", "multiply", "sqrt", "exp", "expm1", "_mean", "norm"}
READ = {
    "dW",
    "fixman",
    "divergence",
    "quadratic",
    "zeta",
    "relaxation",
    "theta",
    "implicitness",
    "strength",
    "eps",
    "h",
}
READ |= {"nu", "lam", "kick", "known", "now", "first", "second", "omega", "e", "noise", "drift", "turning"}
NAMES = {"h", "s", "theta", "part", "kick", "known", "variance", "spread", "explicit", "level", "lam", "rate", "eta"}
# Functions whose numbers are no part of a step, and what is counted and not computed.
NOT_A_STEP = {"__post_init__", "promises", "refuses", "stable_below", "sdaeverify_schemes"}
COUNTED = {"costs", "outputs"}


@dataclass(frozen=True)
class Mutation:
    """A change of one node of a module.

    Attributes
    ----------
    module : str
        Path of the module in the package, without its suffix.
    node : int
        Its number among the nodes of the tree, in the order of `ast.walk`.
    change : str
        ``factor`` or ``sign``.
    line : int
    text : str
        The node's source.
    """

    module: str
    node: int
    change: str
    line: int
    text: str

    @property
    def row(self) -> dict[str, Any]:
        """Columns of a table."""
        return {"file": f"{self.module}.py", "line": self.line, "change": self.change, "of": self.text}


def mutations_of() -> Iterator[Mutation]:
    """Yield the mutations of all modules."""
    for module in MUTATED:
        source = path_of(module).read_text(encoding="utf-8")
        tree = ast.parse(source)
        numbers = {id(node): number for number, node in enumerate(ast.walk(tree))}
        for node, change in dict.fromkeys(_changes(tree)):
            text = " ".join((ast.get_source_segment(source, node) or "").split())
            yield Mutation(module, numbers[id(node)], change, node.lineno, text[:80])


def path_of(module: str) -> Path:
    """Return the file of a module of the package."""
    return Path(next(iter(importlib.import_module(PACKAGE).__path__))) / f"{module}.py"


def _changes(tree: ast.Module) -> Iterator[tuple[ast.expr, str]]:
    """Yield the nodes of steps that are coefficients, each with the way it is changed."""
    for function in _functions(tree):
        for node in _computed(function):
            yield from _changes_of(node)


def _functions(tree: ast.AST) -> Iterator[ast.FunctionDef]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef) and node.name not in NOT_A_STEP:
            yield node
        elif isinstance(node, ast.ClassDef):
            yield from _functions(node)


def _computed(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a function, without annotations, docstrings, indices, conditions, and what is counted."""
    for name, value in ast.iter_fields(node):
        if name in {"annotation", "returns", "args", "slice", "decorator_list"} and not isinstance(node, ast.Call):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or isinstance(child, ast.Compare):
                continue
            if isinstance(child, ast.keyword) and child.arg in COUNTED:
                continue
            yield child
            yield from _computed(child)


def _changes_of(node: ast.AST) -> Iterator[tuple[ast.expr, str]]:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        yield node, "sign"
        yield from ((side, "factor") for side in (node.left, node.right) if _is_term(side))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield node, "sign"
    if isinstance(node, ast.Constant) and type(node.value) is float and node.value:
        yield node, "factor"
    if isinstance(node, ast.Call) and _called(node) in CALLS:
        yield node, "factor"
    if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load) and node.attr in READ - CALLS:
        yield node, "factor"
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in NAMES:
        yield node, "factor"


def _is_term(node: ast.expr) -> bool:
    """Return whether an operand may be a term of a step: no sum, whose terms are changed themselves, no count."""
    is_sum = isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub)
    return not is_sum and not (isinstance(node, ast.Constant) and type(node.value) is int)


def _called(node: ast.Call) -> str:
    return getattr(node.func, "attr", getattr(node.func, "id", ""))


class _Change(ast.NodeTransformer):
    # Changes one node.
    def __init__(self, node: ast.AST, change: str) -> None:
        self.node, self.change = node, change

    def visit(self, node: ast.AST) -> Any:
        """Return the node, or what it becomes."""
        if node is not self.node:
            return self.generic_visit(node)
        if self.change == "factor":
            return ast.BinOp(ast.Constant(BY), ast.Mult(), node)
        if isinstance(node, ast.UnaryOp):
            return node.operand
        assert isinstance(node, ast.BinOp)
        return ast.BinOp(node.left, ast.Sub() if isinstance(node.op, ast.Add) else ast.Add(), node.right)


def loaded(mutation: Mutation) -> list[Scheme]:
    """Return the schemes with one coefficient changed; the modules of the package are made anew.

    Parameters
    ----------
    mutation : Mutation

    Returns
    -------
    list of Scheme
    """
    registry = load_registry(environ={})
    right = [scheme for name in MUTATED[mutation.module] for scheme in select_schemes(registry, name)]
    name, file = f"{PACKAGE}.{mutation.module.replace('/', '.')}", path_of(mutation.module)
    tree = ast.parse(file.read_text(encoding="utf-8"))
    node = next(each for number, each in enumerate(ast.walk(tree)) if number == mutation.node)
    changed = ast.fix_missing_locations(_Change(node, mutation.change).visit(tree))
    kept = {each: module for each, module in sys.modules.items() if each.startswith(f"{PACKAGE}.")}
    try:
        for each in kept:
            if "." in each.removeprefix(f"{PACKAGE}."):
                del sys.modules[each]
        module = ModuleType(name)
        module.__package__, module.__file__ = name.rpartition(".")[0], str(file)
        sys.modules[name] = module
        exec(compile(changed, str(file), "exec"), module.__dict__)
        return [_like(scheme) for scheme in right]
    finally:
        for each in [each for each in sys.modules if each.startswith(f"{PACKAGE}.")]:
            del sys.modules[each]
        sys.modules.update(kept)


def _like(scheme: Scheme) -> Scheme:
    """Return the scheme of the same class and parameters in the modules of now."""
    cls = getattr(importlib.import_module(type(scheme).__module__), type(scheme).__name__)
    names = [field.name for field in fields(scheme)] if is_dataclass(scheme) else []
    return cls(**{name: getattr(scheme, name) for name in names})


__all__ = ["MUTATED", "Mutation", "loaded", "mutations_of"]
