"""Figures of the house: what one meets while one cell is verified, who uses which public name, what there is once.

python reports/house.py
"""

import ast
import os
import re
import sys
from collections import defaultdict
from pathlib import Path
from types import FrameType

import sdaeverify
import sdaeverify.commands
import sdaeverify.errors
import sdaeverify.measuring
import sdaeverify.numerics
import sdaeverify.probing
import sdaeverify.studying
import sdaeverify.testing
import sdaeverify.trees
from sdaeverify.registry.load import load_registry

ROOT = Path(__file__).resolve().parents[1]
CORE = Path(sdaeverify.__file__).parent
ROOMS = (
    sdaeverify,
    sdaeverify.commands,
    sdaeverify.errors,
    sdaeverify.measuring,
    sdaeverify.numerics,
    sdaeverify.probing,
    sdaeverify.studying,
    sdaeverify.testing,
    sdaeverify.trees,
)
USERS = {"plugins": ("plugins", "problems"), "thirdparty": ("tests/thirdparty",), "docs": ("docs", "README.md")}


class Trace:
    """What is met of the core while something runs: files, functions, and classes of arguments by room."""

    def __init__(self) -> None:
        self.files: set[str] = set()
        self.functions: set[tuple[str, str]] = set()
        self.classes: dict[str, set[str]] = defaultdict(set)

    def __call__(self, frame: FrameType, event: str, _: object) -> None:
        """Note a call."""
        code = frame.f_code
        if event != "call" or not code.co_filename.startswith(f"{CORE}{os.sep}"):
            return
        file = Path(code.co_filename).relative_to(CORE)
        self.files.add(str(file))
        self.functions.add((str(file), code.co_qualname))
        for name in code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]:
            given = frame.f_locals.get(name)
            kind = given if isinstance(given, type) else type(given)
            if kind.__module__.startswith("sdaeverify."):
                self.classes[file.parts[0]].add(f"{kind.__module__}.{kind.__qualname__}")


def trace() -> Trace:
    """Return what is met while euler-maruyama is verified on gbm, strong."""
    load_registry()
    met = Trace()
    sys.setprofile(met)
    try:
        found = sdaeverify.verify("euler-maruyama", "gbm", "strong")
    finally:
        sys.setprofile(None)
    assert set(found.verdicts.verdict) == {"verified"}
    return met


def words(*places: str) -> set[str]:
    """Return the words of all files below some places."""
    roots = [ROOT / place for place in places]
    files = (file for root in roots for file in ([root] if root.is_file() else root.rglob("*")))
    told = (file for file in files if file.suffix in {".py", ".md"} and "_site" not in file.parts)
    texts = [file.read_text(encoding="utf-8") for file in told]
    return {word for text in texts for word in re.findall(r"\w+", text)}


def lines() -> dict[str, int]:
    """Return the lines of code by place."""
    return {
        place: sum(len(file.read_text(encoding="utf-8").splitlines()) for file in (ROOT / place).rglob("*.py"))
        for place in ("sdaeverify", "plugins", "problems", "tests")
    }


def enumerations() -> list[str]:
    """Return the names of the enumerations of the core and of plugins."""
    files = (file for place in ("sdaeverify", "plugins") for file in (ROOT / place).rglob("*.py"))
    trees = (ast.parse(file.read_text(encoding="utf-8")) for file in files)
    nodes = (node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef))
    return sorted(node.name for node in nodes if any(ast.unparse(base).endswith("Enum") for base in node.bases))


def main() -> None:
    """Print the figures."""
    met, using = trace(), {user: words(*places) for user, places in USERS.items()}
    every = set().union(*met.classes.values())
    print(f"one cell: {len(met.files)} files, {len(met.functions)} functions")
    print(f"{len(every)} classes met as arguments, {len(met.classes['study'])} of them in study")
    total = 0
    for room in ROOMS:
        shared = [name for name in room.__all__ if sum(name in found for found in using.values()) >= 2]
        total += len(room.__all__)
        print(f"{room.__name__}: {len(room.__all__)} public names, {len(shared)} with two kinds of users")
    print(f"{total} public names; enumerations: {', '.join(enumerations())}")
    print(f"lines: {', '.join(f'{place} {count}' for place, count in lines().items())}")


if __name__ == "__main__":
    main()
