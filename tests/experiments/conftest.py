"""A registry with one experiment more."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from sdaeverify.registry.contributions import Registered
from sdaeverify.registry.discovery import Origin
from sdaeverify.registry.load import Registry, load_registry
from sdaeverify_papers import Budget, MeanTable, Row
from sdaeverify_papers.experiment_plan import EXPERIMENTS, experiment_plan
from sdaeverify_papers.run import ExperimentRun


@pytest.fixture(scope="session")
def registry() -> Registry:
    """All that is installed."""
    return load_registry(environ={}, lab=True)


@pytest.fixture
def planned(registry: Registry) -> Callable[..., ExperimentRun]:
    """Plan an experiment of rows (problem, scheme, steps, observable)."""

    def plan(*rows: Row, paths: int = 10, budget: Budget = Budget.SMOKE, **attributes: object) -> ExperimentRun:
        experiment = MeanTable(name="mine", title="made up", source="nowhere", rows=rows, **attributes)
        entry = Registered("mine", experiment, Origin("mine", "", "", "mine.py"))
        return ExperimentRun(
            experiment_plan(
                replace(registry, further={EXPERIMENTS: {"mine": entry}}),
                "mine",
                paths=paths,
                budget=budget,
            )
        )

    return plan
