"""Tests here are run over everything that is registered, whoever wrote it."""

from functools import cache, partial

import pytest

from conformance import cells
from facade import Registry, load_registry

COLLECTIONS = {
    "planted": cells.breaches,
    "asked_of_scheme": partial(cells.asked_of_schemes, long=False),
    "asked_about_claims": partial(cells.asked_of_schemes, long=True),
    "asked_of_cell": partial(cells.asked_of_cells, chosen=True),
    "asked_of_another_cell": partial(cells.asked_of_cells, chosen=False),
    "asked_of_problem": partial(cells.asked_of_problems, long=False),
    "asked_for_long": partial(cells.asked_of_problems, long=True),
}


@cache
def loaded() -> Registry:
    """Return what is registered, loaded once for all tests."""
    return load_registry(environ={}, lab=True)


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
        metafunc.parametrize(name, things, ids=[thing.label for thing in things])


@pytest.fixture(autouse=True)
def measures_are_known() -> None:
    """Load what is registered: whose claims say that steps follow paths or a law is known of loaded measures."""
    loaded()
