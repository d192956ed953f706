"""Variants of a scheme's source: one place of its formulas changed, or many of them written in another way.

The scheme's own module and the helper modules beside it are parsed; a variant is the scheme's class made from the
changed text. What only describes a scheme (claims, refusals, checks of parameters) is left alone.
"""

import ast
import sys
from collections.abc import Callable, Iterator
from dataclasses import fields
from graphlib import TopologicalSorter
from types import ModuleType
from typing import Any, NamedTuple
from unittest.mock import patch

from sdaeverify import Scheme

DESCRIBES = {"__post_init__", "refuses", "promises", "stable_below", "law", "parts", "enter", "sdaeverify_schemes"}
FACTOR = 1.1
# A change of a node: None where it does not apply.
Change = Callable[[ast.AST], ast.AST | None]


class Place(NamedTuple):
    """A node of a scheme's formulas that a change applies to.

    Attributes
    ----------
    module : str
    kind : str
        Of the change.
    index : int
        Of the node, in the order of a walk through the module.
    line : int
    """

    module: str
    kind: str
    index: int
    line: int


class Variant(NamedTuple):
    """A scheme made from changed text.

    Attributes
    ----------
    scheme : Scheme
    name : str
        Which places were changed, and to what.
    """

    scheme: Scheme
    name: str


def _flipped(node: ast.AST) -> ast.AST | None:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        return ast.BinOp(node.left, ast.Sub() if isinstance(node.op, ast.Add) else ast.Add(), node.right)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return node.operand
    return None


def _scaled(node: ast.AST) -> ast.AST | None:
    product = isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div)
    return ast.BinOp(ast.Constant(FACTOR), ast.Mult(), node) if product else None


def _dropped(node: ast.AST) -> ast.AST | None:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        return node.left
    return None


def _late(node: ast.AST) -> ast.AST | None:
    """Turn t + h into t, and t into t + h."""
    if isinstance(node, ast.BinOp) and ast.unparse(node) == "t + h":
        return node.left
    if isinstance(node, ast.Name) and node.id == "t" and isinstance(node.ctx, ast.Load):
        return ast.parse("(t + h)", mode="eval").body
    return None


def _lagged(node: ast.AST) -> ast.AST | None:
    swaps = {"lagged": "ahead", "ahead": "lagged"}
    if isinstance(node, ast.Attribute) and node.attr in swaps and isinstance(node.value, ast.Name):
        return ast.Attribute(node.value, swaps[node.attr], node.ctx)
    return ast.parse("x", mode="eval").body if ast.unparse(node) == "lag.now" else None


def _squared(node: ast.AST) -> ast.AST | None:
    power = isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Constant)
    return node.left if power else None


def _commuted(node: ast.AST) -> ast.AST | None:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Mult):
        return ast.BinOp(node.right, node.op, node.left)
    return None


def _negated(node: ast.AST) -> ast.AST | None:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Sub):
        return ast.BinOp(node.left, ast.Add(), ast.BinOp(ast.Constant(-1.0), ast.Mult(), node.right))
    return None


def _divided(node: ast.AST) -> ast.AST | None:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div):
        return ast.BinOp(node.left, ast.Mult(), ast.BinOp(ast.Constant(1.0), ast.Div(), node.right))
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        return ast.BinOp(ast.Constant(0.25), ast.Mult(), ast.BinOp(ast.Constant(4.0), ast.Mult(), node))
    return None


def _distributed(node: ast.AST) -> ast.AST | None:
    """Turn a (b + c) into a b + a c."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and isinstance(node.right, ast.BinOp):
        inner = node.right
        if isinstance(inner.op, ast.Add | ast.Sub):
            left, right = (ast.BinOp(node.left, ast.Mult(), term) for term in (inner.left, inner.right))
            return ast.BinOp(left, inner.op, right)
    return None


WRONG: dict[str, Change] = {
    "sign": _flipped,
    "factor": _scaled,
    "dropped": _dropped,
    "time": _late,
    "lag": _lagged,
    "power": _squared,
}
SAME: dict[str, Change] = {
    "commuted": _commuted,
    "negated": _negated,
    "divided": _divided,
    "distributed": _distributed,
}


def modules_of(scheme: Scheme) -> list[ModuleType]:
    """Return the module of a scheme and the helpers beside it that it, or one of them, takes names from."""
    found: dict[str, ModuleType] = {}
    todo = [cls.__module__ for cls in type(scheme).__mro__ if issubclass(cls, Scheme) and cls is not Scheme]
    while todo:
        name = todo.pop(0)
        if name not in found:
            module = found[name] = sys.modules[name]
            prefix = name.rpartition(".")[0] + "._"
            todo += [origin for origin in _origins(module) if origin.startswith(prefix)]
    return list(found.values())


def places(scheme: Scheme, changes: dict[str, Change]) -> Iterator[Place]:
    """Yield every place in the formulas of a scheme where one of the changes applies."""
    for module in modules_of(scheme):
        for index, node in enumerate(_formulas(_tree(module))):
            for kind, change in changes.items():
                if change(node) is not None:
                    yield Place(module.__name__, kind, index, node.lineno)


def variant(scheme: Scheme, chosen: list[Place], changes: dict[str, Change], name: str) -> Variant:
    """Return the scheme under another name with the places changed, which lie in distinct nodes.

    Raises
    ------
    Exception
        Whatever the changed text raises when it is run.
    """
    made: dict[str, ModuleType] = {}
    # Helpers first, so that what takes names from them finds the new ones.
    for module in _helpers_first(modules_of(scheme)):
        wanted = {place.index: changes[place.kind] for place in chosen if place.module == module.__name__}
        made[module.__name__] = _built(module, wanted, made)
    cls = getattr(made[type(scheme).__module__], type(scheme).__name__)
    # A class of its own, so that it may have a name of its own: nothing else has this one.
    cls.name = name
    told = ", ".join(f"{place.kind} {place.module.rpartition('.')[2]}:{place.line}.{place.index}" for place in chosen)
    return Variant(remade(cls, scheme), f"{scheme.label}: {told}")


def _tree(module: ModuleType) -> ast.Module:
    assert module.__file__ is not None
    with open(module.__file__, encoding="utf-8") as file:
        return ast.parse(file.read())


def _formulas(tree: ast.Module) -> list[ast.expr]:
    """Return the expressions in the bodies of functions that compute, in the order of a walk."""
    found: list[ast.expr] = []
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef) and function.name not in DESCRIBES:
            for statement in function.body:
                found += [node for node in _walk(statement) if isinstance(node, ast.expr)]
    return list({id(node): node for node in found}.values())


def _walk(node: ast.AST) -> Iterator[ast.AST]:
    """Walk through a statement, but into no index, annotation, text or nested function."""
    yield node
    for name, child in ast.iter_fields(node):
        if name in {"slice", "annotation", "returns"}:
            continue
        for one in child if isinstance(child, list) else [child]:
            if isinstance(one, ast.AST) and not isinstance(one, ast.FunctionDef | ast.JoinedStr | ast.List):
                yield from _walk(one)


class _Changed(ast.NodeTransformer):
    def __init__(self, new: dict[int, Change]) -> None:
        self.new = new

    def visit(self, node: ast.AST) -> Any:
        # Children first: a place inside another one is changed as well.
        changed = self.generic_visit(node)
        change = self.new.get(id(node))
        made = change(changed) if change else None
        return changed if made is None else ast.copy_location(made, node)


def _built(module: ModuleType, wanted: dict[int, Change], made: dict[str, ModuleType]) -> ModuleType:
    tree = _tree(module)
    nodes = _formulas(tree)
    tree = ast.fix_missing_locations(_Changed({id(nodes[i]): change for i, change in wanted.items()}).visit(tree))
    new = ModuleType(module.__name__)
    new.__dict__.update({"__file__": module.__file__, "__package__": module.__package__})
    # The new text takes names from the new helpers.
    with patch.dict(sys.modules, made):
        exec(compile(tree, module.__file__ or "", "exec"), new.__dict__)
    return new


def _helpers_first(modules: list[ModuleType]) -> list[ModuleType]:
    by = {module.__name__: module for module in modules}
    used = {name: [origin for origin in _origins(module) if origin in by] for name, module in by.items()}
    return [by[name] for name in TopologicalSorter(used).static_order()]


def _origins(module: ModuleType) -> list[str]:
    """Return the names of the other modules that a module takes names from."""
    origins = dict.fromkeys(getattr(value, "__module__", None) for value in vars(module).values())
    return [origin for origin in origins if isinstance(origin, str) and origin != module.__name__]


def remade(cls: type[Scheme], scheme: Scheme) -> Scheme:
    """Return a scheme of another class with the parameters of a given one."""
    return cls(**{field.name: getattr(scheme, field.name) for field in fields(scheme) if field.init})


def distinct(chosen: list[Place]) -> list[Place]:
    """Return the places, each node once."""
    return list({(place.module, place.index): place for place in chosen}.values())
