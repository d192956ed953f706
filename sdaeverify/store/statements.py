"""Parsed code by statements: which names each binds, which it mentions, and which of many one of them reaches.

A statement at the top of a file counts for what reaches it by name; one that does something to others as it is
imported counts for all in its package. Comments, docstrings and layout are no part of parsed code.
"""

import ast
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
IMPORTS = (ast.Import, ast.ImportFrom)
# What finds things by names that are not written down: whoever uses it may reach everything.
DYNAMIC = frozenset(
    {
        *("globals", "eval", "exec", "__import__", "import_module", "__dict__", "modules", "__subclasses__"),
        *("spec_from_file_location", "exec_module", "run_path"),
    }
)
STAR, INIT = "*", "__init__.py"
# Where statements hold others.
BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")
# Tests of what runs only where a file is the program, or types are checked.
ELSEWHERE = ("__name__ == '__main__'", "TYPE_CHECKING", "typing.TYPE_CHECKING")


class Import(NamedTuple):
    """A module that is imported, or by a name of it; the module is named from the outermost package on."""

    module: str
    name: str = ""
    relative: bool = False


class Words(NamedTuple):
    """Variables, attributes, texts and imports that a statement mentions."""

    names: frozenset[str]
    attributes: frozenset[str]
    texts: frozenset[str]
    imports: frozenset[Import]


@dataclass(frozen=True, eq=False)
class Statement:
    """A statement at the top of a file.

    Attributes
    ----------
    file : Path
    module : str
        Name of the file as a module, from the outermost package on.
    node : ast.stmt
    """

    file: Path
    module: str
    node: ast.stmt

    @cached_property
    def binds(self) -> frozenset[str]:
        """Names that it gives a value."""
        if isinstance(self.node, DEFINITIONS):
            return frozenset({self.node.name})
        if isinstance(self.node, IMPORTS):
            return frozenset(alias.asname or alias.name.partition(".")[0] for alias in self.node.names)
        found = (node for node in ast.walk(self.node) if isinstance(node, ast.Name))
        return frozenset(node.id for node in found if isinstance(node.ctx, ast.Store))

    @cached_property
    def acts(self) -> bool:
        """Whether it may do something else than to bind names."""
        if isinstance(self.node, ast.Assign):
            return not all(isinstance(part, ast.Name | ast.Tuple) for part in self.node.targets)
        if isinstance(self.node, ast.AnnAssign):
            return not isinstance(self.node.target, ast.Name)
        return not isinstance(self.node, (*DEFINITIONS, *IMPORTS))

    @cached_property
    def words(self) -> Words:
        """What it mentions."""
        nodes = list(ast.walk(self.node))
        constants = (node.value for node in nodes if isinstance(node, ast.Constant))
        return Words(
            frozenset(node.id for node in nodes if isinstance(node, ast.Name)),
            frozenset(node.attr for node in nodes if isinstance(node, ast.Attribute)),
            frozenset(value for value in constants if isinstance(value, str)),
            frozenset(each for node in nodes if isinstance(node, IMPORTS) for each in self._imports(node)),
        )

    def _imports(self, node: ast.Import | ast.ImportFrom) -> Iterator[Import]:
        if isinstance(node, ast.Import):
            yield from (Import(alias.name) for alias in node.names)
            return
        package = self.module.split(".")[: None if self.file.name == INIT else -1]
        above = package[: len(package) + 1 - node.level] if node.level else []
        module = ".".join([*above, *([node.module] if node.module else [])])
        yield from (Import(module, alias.name, relative=bool(node.level)) for alias in node.names)

    @cached_property
    def content(self) -> bytes:
        """What is parsed, as bytes."""
        return f"{self.module} {ast.dump(self.node)}".encode(errors="surrogatepass")


class Reached(NamedTuple):
    """Statements that count, and the names by which they were reached, of each file."""

    statements: tuple[Statement, ...]
    names: Mapping[Path, frozenset[str]]


def parse_statements(file: Path, module: str, content: bytes, without: frozenset[str]) -> tuple[Statement, ...]:
    """Return the statements of a file, without docstrings and what does not run where the file is imported.

    Parameters
    ----------
    file : Path
    module : str
        Its name from the outermost package on.
    content : bytes
        What the file holds.
    without : frozenset of str
        Names of what is left out of each class.

    Raises
    ------
    SyntaxError, ValueError
        If it is no Python.
    """
    tree = ast.parse(content)
    waiting: list[Any] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, (ast.Module, *DEFINITIONS)):
            own = [part for part in node.body if not (_is_text(part) or _is_elsewhere(part))]
            if isinstance(node, ast.ClassDef) and without:
                own = [part for part in own if not Statement(file, module, part).binds & without]
            node.body = own
        waiting += [part for block in BLOCKS for part in getattr(node, block, ())]
    return tuple(Statement(file, module, part) for node in tree.body for part in _by_names(node))


class Space:
    """Statements of some files, by the names that they bind.

    Parameters
    ----------
    statements : tuple of Statement
    """

    def __init__(self, statements: tuple[Statement, ...]) -> None:
        self.statements = statements
        self.modules = {one.module: one.file for one in statements}
        self.bound = defaultdict[tuple[Path, str], list[Statement]](list)
        self.anywhere = defaultdict[str, list[Statement]](list)
        for one in statements:
            for name in one.binds:
                self.bound[one.file, name].append(one)
                self.anywhere[name].append(one)

    def reach(self, file: Path, name: str) -> Reached:
        """Return what a name of a file reaches, and what acts by itself; everything where that cannot be told.

        Parameters
        ----------
        file : Path
        name : str
        """
        start = self.bound.get((file, name), [])
        names, found = defaultdict[Path, set[str]](set), dict[Statement, None]()
        waiting = [*(("", one) for one in self.statements if one.acts), *((name, one) for one in start)]
        while waiting:
            called, one = waiting.pop()
            names[one.file] |= {called} - {""}
            if one not in found:
                found[one] = None
                waiting += self._mentioned(one)
        if not start or any(DYNAMIC & (one.words.names | one.words.attributes) for one in found):
            found = dict.fromkeys(self.statements)
            for one in self.statements:
                names[one.file] |= one.binds
        kept = tuple(one for one in self.statements if one in found)
        return Reached(kept, {path: frozenset(called) for path, called in names.items() if called})

    def _mentioned(self, one: Statement) -> Iterator[tuple[str, Statement]]:
        """Yield the names that a statement mentions, and the statements that bind them; of a module, all of it."""
        starred = self.bound.get((one.file, STAR), ()) and self.anywhere
        for name in one.words.names:
            own = self.bound.get((one.file, name), []) or (starred.get(name, []) if starred else [])
            yield from ((name, other) for other in own)
        for module, name, _ in one.words.imports:
            if whole := self._file(f"{module}.{name}".strip(".")):
                yield from ((other, each) for each in self.statements if each.file == whole for other in each.binds)
            elif part := self._file(module):
                yield from (
                    (name, other) for other in self.bound.get((part, name), []) or self.anywhere.get(name, [])
                )

    def _file(self, module: str) -> Path | None:
        """Return the file of a module; above the outermost package there may be folders that are none."""
        parts = module.split(".")
        names = (".".join(parts[first:]) for first in range(len(parts)))
        return next((self.modules[name] for name in names if name in self.modules), None)


def _by_names(node: ast.stmt) -> Iterator[ast.stmt]:
    """Yield an import as one for each name, and what is none as it is."""
    if isinstance(node, ast.Import):
        yield from (ast.Import([alias]) for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        yield from (ast.ImportFrom(node.module, [alias], node.level) for alias in node.names)
    else:
        yield node


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _is_elsewhere(node: ast.stmt) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) in ELSEWHERE
