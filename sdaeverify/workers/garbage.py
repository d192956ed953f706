"""When garbage is looked for: not while that comes to be which lasts, such as code; that takes longer if it is."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def lasting() -> Iterator[None]:
    """Make what lasts as long as the process, code or a plan: it is no garbage, and is never looked through."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        if before:
            gc.enable()
