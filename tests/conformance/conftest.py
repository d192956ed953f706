"""Tests here are run over everything that is registered, whoever wrote it."""

from functools import cache

import pytest

from conformance import cells
from facade import Registry, load_registry

COLLECTIONS = {
    "planted",
    "asked_of_scheme",
    "asked_about_claims",
    "asked_of_cell",
    "asked_of_another_cell",
    "asked_of_problem",
    "asked_for_long",
}


@cache
def loaded() -> Registry:
    """Return what is registered, loaded once for all tests."""
    return load_registry(environ={}, lab=True)


@cache
def collections() -> dict[str, list]:
    """Return what each fixture ranges over: cells are matched, and problems built, once for all of them."""
    registry = loaded()
    chosen, others = cells.in_turn(registry)
    soon, late = zip(*cells.asked_of_problems(registry), strict=True)
    return {
        "planted": cells.breaches(registry),
        "asked_of_scheme": [*cells.asked_of_schemes(registry, long=False)],
        "asked_about_claims": [*cells.asked_of_schemes(registry, long=True)],
        "asked_of_cell": [*cells.asked_of_cells(chosen)],
        "asked_of_another_cell": [*cells.asked_of_cells(others)],
        "asked_of_problem": [*soon],
        "asked_for_long": [*late],
    }


@pytest.fixture(scope="session")
def registry() -> Registry:
    """Return what is registered."""
    return loaded()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    for name in COLLECTIONS & set(metafunc.fixturenames):
        late = cells.is_late if name in {"asked_of_cell", "asked_of_problem"} else lambda _: False
        given = [
            pytest.param(thing, id=thing.label, marks=pytest.mark.long if late(thing.label) else ())
            for thing in collections()[name]
        ]
        metafunc.parametrize(name, given)


@pytest.fixture(autouse=True)
def measures_are_known() -> None:
    """Load what is registered: whose claims say that steps follow paths or a law is known of loaded measures."""
    loaded()
