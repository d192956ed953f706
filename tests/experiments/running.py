"""Experiments run in this process, changed or not; and what Euler's scheme is off from itself with more steps."""

from dataclasses import replace

from facade import EXPERIMENTS, Budget, ExperimentRun, Origin, Registered, experiment_plan


def planned_run(registry, name, experiment=None, paths=None, budget=Budget.SMOKE):
    """Plan an experiment of this name: the registered one, unless another is given."""
    thing = experiment or registry.things(EXPERIMENTS)[name]
    entry = Registered(name, (thing,), Origin(name, "", "", "mine.py"))
    changed = replace(registry, entries={**registry.entries, EXPERIMENTS: {name: entry}})
    return ExperimentRun(experiment_plan(changed, name, paths=paths, budget=budget))


def evidence_of(registry, name, experiment=None, paths=4):
    """Run an experiment of which nothing fails."""
    run = planned_run(registry, name, experiment, paths)
    list(run.run())
    assert run.evidence.failures == []
    return run.evidence


def with_rows(registry, name, change, **changes):
    """Return a registered experiment whose rows are changed, or left out where the change is None."""
    experiment = registry.things(EXPERIMENTS)[name]
    rows = tuple(row for row in map(change, experiment.rows) if row is not None)
    return replace(experiment, rows=rows, **changes)


def mean_square(a: float, b: float, steps: int, finer: int) -> float:
    """Return E (x_N - x_M)^2 on dx = a x dt + b x dW, x_0 = 1, T = 1: N = steps, M = N finer.

    Over a long step E x_N^2 grows by (1 + a h)^2 + b^2 h, E x_N x_M by (1 + a h) q^r + b^2 h q^(r-1) with
    q = 1 + a h/r, and E x_M^2 by (q^2 + b^2 h/r)^r.
    """
    h, r = 1.0 / steps, finer
    q = 1.0 + a * h / r
    own, fine = (1.0 + a * h) ** 2 + b * b * h, (q * q + b * b * h / r) ** r
    both = (1.0 + a * h) * q**r + b * b * h * q ** (r - 1)
    return own**steps - 2.0 * both**steps + fine**steps


def lines_of(run):
    """Return the lines of a table of means that has been run."""
    return run.plan.experiment.lines(run.evidence)
