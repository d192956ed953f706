"""A registry with one experiment more."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from facade import (
    EXPERIMENTS,
    Budget,
    ExperimentRun,
    MeanTable,
    Origin,
    Registered,
    Registry,
    Row,
    experiment_plan,
    load_registry,
)


@pytest.fixture(scope="session")
def registry() -> Registry:
    """All that is installed."""
    return load_registry(environ={}, lab=True)


@pytest.fixture
def planned(registry: Registry) -> Callable[..., ExperimentRun]:
    """Plan an experiment of rows (problem, scheme, steps, observable)."""

    def plan(*rows: Row, paths: int = 10, budget: Budget = Budget.SMOKE, **attributes: object) -> ExperimentRun:
        experiment = MeanTable(name="mine", title="made up", source="nowhere", rows=rows, **attributes)
        entry = Registered("mine", (experiment,), Origin("mine", "", "", "mine.py"))
        return ExperimentRun(
            experiment_plan(
                replace(registry, entries={**registry.entries, EXPERIMENTS: {"mine": entry}}),
                "mine",
                paths=paths,
                budget=budget,
            )
        )

    return plan
