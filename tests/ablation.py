"""Judging without one of the guards of verdicts."""

import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import UnionType
from typing import Any

from facade import Guard, Smoothness, rules
from sdaeverify.measuring import Reason

# What a function says that has no doubt, by the type of what it returns.
NEUTRAL: Mapping[Any, Any] = {bool: False, str: "", float: 1.0, Reason: Reason(), Smoothness: Smoothness.SMOOTH}


def neutral(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function with the same signature that has no doubt."""
    told = inspect.signature(function).return_annotation
    if isinstance(told, UnionType):
        return lambda first, *_, **__: first if type(first) in told.__args__ else None
    if told in NEUTRAL:
        return lambda *_, **__: NEUTRAL[told]
    return lambda first, *_, **__: first


def places(function: Callable[..., Any]) -> Iterator[tuple[Any, str, Any]]:
    """Yield the modules and classes that bind a function, its name there, and a function without doubts."""
    silent = neutral(function)
    modules = [module for name, module in list(sys.modules.items()) if name.startswith("sdaeverify")]
    for owner in [*modules, *{each for module in modules for each in vars(module).values() if inspect.isclass(each)}]:
        if inspect.isclass(owner) and not owner.__module__.startswith("sdaeverify"):
            continue
        for name, bound in list(vars(owner).items()):
            if bound is function:
                yield owner, name, silent
            elif isinstance(bound, property) and bound.fget is function:
                yield owner, name, property(silent)


@contextmanager
def without(guard: Guard) -> Iterator[None]:
    """Judge without a guard."""
    changed = list(places(guard.asks))
    if guard in rules.RULES:
        changed = [(rules, "RULES", tuple(rule for rule in rules.RULES if rule is not guard))]
    before = [(owner, name, vars(owner)[name]) for owner, name, _ in changed]
    for owner, name, bound in changed:
        setattr(owner, name, bound)
    try:
        yield
    finally:
        for owner, name, bound in before:
            setattr(owner, name, bound)
