"""When garbage is looked for: not while that comes to be which lasts, such as code; that takes longer if it is."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def kept() -> Iterator[None]:
    """Make much that is kept, such as findings: garbage is looked for when it is there, and not time after time."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()


@contextmanager
def lasting() -> Iterator[None]:
    """Make what lasts as long as the process, code or a plan: it is no garbage, and is never looked through."""
    with kept():
        try:
            yield
        finally:
            gc.freeze()
