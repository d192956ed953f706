"""Tests here are run over everything that is registered, whoever wrote it."""

from functools import cache, partial
from typing import Any

import pytest

from conformance import cells
from sdaeverify.registry import Registry, load_registry
from sdaeverify.testing.questions import Question

COLLECTIONS = {
    "shipped_scheme": cells.schemes,
    "shipped_spec": cells.specs,
    "planted": cells.breaches,
    "asked_of_scheme": cells.questions_of_schemes,
    "asked_of_cell": cells.questions_of_cells,
    "asked_of_problem": partial(cells.questions_of_problems, long=False),
    "asked_for_long": partial(cells.questions_of_problems, long=True),
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
        metafunc.parametrize(name, things, ids=[_id(thing) for thing in things])


def _id(thing: Any) -> str:
    if isinstance(thing, Question):
        return cells.name_of(thing)
    return str(thing.label)
