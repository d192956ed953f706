"""What a record finds of some levels, it finds once: whatever is claimed, and however often it is asked."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

import numpy as np

Method = TypeVar("Method", bound=Callable[..., Any])


def once(method: Method) -> Method:
    """Return a method of a record, of levels and what else is given, that keeps what it finds in its `known`.

    Parameters
    ----------
    method : callable, (record, levels, *given) -> object
        A pure function; what is given beside levels can be hashed.
    """

    @wraps(method)
    def found(self: Any, levels: Any, *given: Any) -> Any:
        key = method.__name__, np.asarray(levels).tobytes(), *given
        if key not in self.known:
            self.known[key] = method(self, levels, *given)
        return self.known[key]

    return cast("Method", found)
