"""Tests here are run over everything that is registered, whoever wrote it."""

import pytest

from conformance import cells
from sdaeverify.registry import load_registry

COLLECTIONS = {
    "scheme": cells.schemes,
    "spec": cells.specs,
    "constrained": cells.constrained,
    "solved": cells.solved,
    "charted": cells.charted,
    "cell": cells.cells,
    "promise": cells.promises,
    "trait": cells.declared,
}


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    for name in COLLECTIONS.keys() & set(metafunc.fixturenames):
        things = list(COLLECTIONS[name](load_registry(environ={})))
        # One pilot trajectory serves all tests of a cell.
        metafunc.parametrize(name, things, ids=[thing.label for thing in things], scope="module")
