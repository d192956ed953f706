"""Energy drift: with which order in h a scheme keeps the energy, E |H(x_h(T)) - H(x(0))| = O(h^p)."""

import numpy as np

import sdaeverify.measuring as m
from sdaeverify import hookimpl

ENERGY = "H"


class EnergyDrift(m.Measure):
    """Order of the energy's error at T, on problems that keep an observable H."""

    name = "energy-drift"

    def refuses(self, scheme, problem):
        """Refuse problems without an energy."""
        return "" if ENERGY in problem.observables else f"the problem has no observable {ENERGY}"

    def observer(self, problem, parts, settings):
        """Return the notebook for one block."""
        return EnergyObserver(problem, parts, settings)

    def judge(self, evidence):
        """Fit a slope to the finest levels, and compare it with what is claimed."""
        sums, counts, h = evidence.tally.sums[ENERGY], evidence.tally.sums["paths"], np.array(evidence.step_sizes)
        covered, (levels, remarks) = m.coverage(evidence, self.name, ENERGY), m.sound_levels(evidence.health.sums)
        means = [m.jackknife(sums[:, level], counts, float) for level in range(len(h))]
        rows = tuple(m.LevelFinding(ENERGY, level, mean.value, mean.se) for level, mean in enumerate(means))
        if len(fitted := levels[-m.FITTED :]) < m.FEWEST:
            return m.Judgement((m.finding(covered, m.no_fit(evidence, covered, remarks)),), rows)
        order = m.order_of(h[fitted], sums[:, fitted], counts)
        low, high = order.interval(evidence.settings.confidence)

        def judge(claim):
            tests = m.order_tests(claim, order, evidence)
            return m.decide(m.with_sample(tests, evidence.paths, heavy=False), evidence)

        opinion, figures = m.judge_claim(covered, judge).plus(remarks), {"low": low, "high": high}
        return m.Judgement(
            (m.finding(covered, opinion, estimate=order.value, method=m.Method("paths", 3), **figures),), rows
        )


class EnergyObserver:
    """Keeps the latest states, and returns sums over groups of paths of |H(x_h(T)) - H(x(0))| at all levels."""

    def __init__(self, problem, parts, settings):
        self.energy, self.horizon = problem.observables[ENERGY], problem.horizon
        self.start, self.last, self.wanted = self.energy(0.0, parts), (), [frozenset()] * settings.levels

    def after_step(self, level, step, parts):
        """Note nothing."""

    def after_coarsest_step(self, snapshot):
        """Keep the states of all levels."""
        self.last = snapshot.levels

    def tally(self):
        """Return the sums, and the number of paths of each group."""
        drift = np.abs(np.stack([self.energy(self.horizon, parts) for parts in self.last]) - self.start)
        return m.Tally(sums={ENERGY: m.group_sums(drift), "paths": m.group_sums(np.ones(drift.shape[-1]))})


@hookimpl
def sdaeverify_measures():
    """Register the measure."""
    return [EnergyDrift()]
