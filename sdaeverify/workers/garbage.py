"""When garbage is looked for: not while libraries and plugins load, which takes a quarter longer if it is."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def loading() -> Iterator[None]:
    """Load code: it is no garbage, and is not looked through again for as long as the process lives."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        if before:
            gc.enable()
