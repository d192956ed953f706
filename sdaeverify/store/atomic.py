"""Files that are there as a whole or not at all."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

UNFINISHED = ".unfinished-"


@contextmanager
def written(path: Path) -> Iterator[IO[bytes]]:
    """Give a file to write to, beside its place, and move it there at the end: no reader ever finds half of it.

    Parameters
    ----------
    path : Path
        In a folder that exists; what is there is replaced, or left as it is if writing fails.
    """
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=UNFINISHED)
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
