"""A registry with one experiment more."""

from collections.abc import Callable

import pytest

from experiments.running import planned_run
from facade import Budget, ExperimentRun, MeanTable, Registry, Row, load_registry


@pytest.fixture(scope="session")
def registry() -> Registry:
    """All that is installed."""
    return load_registry(environ={}, lab=True)


@pytest.fixture
def planned(registry: Registry) -> Callable[..., ExperimentRun]:
    """Plan an experiment of rows (problem, scheme, steps, observable)."""

    def plan(*rows: Row, paths: int = 10, budget: Budget = Budget.SMOKE, **attributes: object) -> ExperimentRun:
        experiment = MeanTable(name="mine", title="made up", source="nowhere", rows=rows, **attributes)
        return planned_run(registry, "mine", experiment, paths, budget)

    return plan
