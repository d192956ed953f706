"""Tests here are run over everything that is registered, whoever wrote it."""

from functools import cache

import pytest

from conformance import cells
from sdaeverify.registry import Registry, load_registry

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


@cache
def loaded() -> Registry:
    """Return what is registered, loaded once for all tests."""
    return load_registry(environ={})


@cache
def collection(name: str) -> list:
    """Return what a fixture ranges over, made once for all tests."""
    return list(COLLECTIONS[name](loaded()))


@pytest.fixture(scope="session")
def registry() -> Registry:
    """Return what is registered."""
    return loaded()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    for name in COLLECTIONS.keys() & set(metafunc.fixturenames):
        things = collection(name)
        # One pilot trajectory serves all tests of a cell.
        metafunc.parametrize(name, things, ids=[thing.label for thing in things], scope="module")
