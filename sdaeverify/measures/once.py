"""What is found of some levels of a record's evidence is found once, whatever is claimed, and however often asked."""

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np

Given = ParamSpec("Given")
Found = TypeVar("Found")


def once(method: Callable[Concatenate[Any, Any, Given], Found]) -> Callable[Concatenate[Any, Any, Given], Found]:
    """Return a method of a record, of levels and what else is given, that keeps what it finds in `known` of it."""

    @wraps(method)
    def found(self: Any, levels: Any, *given: Given.args, **named: Given.kwargs) -> Found:
        key = method.__name__, np.asarray(levels).tobytes(), *given, *named.items()
        if key not in self.known:
            self.known[key] = method(self, levels, *given, **named)
        return self.known[key]  # type: ignore[no-any-return]

    return found
