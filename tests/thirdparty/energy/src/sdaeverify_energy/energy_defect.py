"""Energy defect: with which order in h one step keeps the energy, (E |H(Phi(x)) - H(x)|^2)^(1/2) = O(h^p)."""

from typing import Any, NamedTuple

import numpy as np

import sdaeverify.measuring as m
import sdaeverify.probing as p
from sdaeverify import hookimpl

ENERGY, PROBED, NODES = "H", "energy defect", 6
SIZES = 4.0 ** -np.arange(2.0, 7.0)
ROUNDING = 1e-14


class Defects(NamedTuple):
    """Root mean squares of the defects, each the largest over the states, and the size of the energy: shape (H,)."""

    h: Any
    size: Any
    scale: Any


class EnergyDefect(m.Measure):
    """Order of the energy's error in one step, on problems that keep an observable H."""

    name = "energy-defect"

    def refuses(self, scheme, problem):
        """Refuse problems without an energy, and schemes whose steps cannot be evaluated one by one."""
        if ENERGY not in problem.observables:
            return f"the problem has no observable {ENERGY}"
        view = scheme.view_of(problem)
        return "no view of the form" if view is None else p.OneStep(scheme, view).why_not_probed()

    def probe(self, scheme, view, settings):
        """Return the defects of one step of each size, from states where solutions go."""
        step = p.OneStep(scheme, view)
        x, h = p.cloud(view, step.equation), SIZES * view.time_unit
        nodes = p.step_nodes(view.noise_dim, NODES, areas="H" in scheme.noise, law=scheme.law)
        wide, before = np.repeat(x, len(nodes.weights), axis=1), energy(view, x)
        after = (energy(view, step(wide, step.time, each, nodes.increment(each, x.shape[1]))) for each in h)
        squares = (nodes.mean((one.reshape(x.shape[1], -1) - before[:, None]) ** 2).max() for one in after)
        return m.packed(PROBED, Defects(h, np.sqrt([*squares]), np.full(len(h), before.max())))

    def judge(self, evidence):
        """Compare the order at the finest steps, and the next one to be expected, with what is claimed."""
        record = m.unpacked(PROBED, Defects, evidence.tally)
        if record is None:
            return m.NOT_PROBED
        found = p.last_orders(record.h, record.size, ROUNDING * record.scale, record.scale)
        order, ahead = float(found.order), float(found.ahead)

        def judge(claim):
            bound, text = claim.value.floor, f"local order {order:.3f}, claimed {claim.value.least}"
            if min(order, ahead) >= bound:
                return m.local_opinion(m.Verdict.VERIFIED, text)
            if max(order, ahead) < bound:
                return m.local_opinion(m.Verdict.REFUTED, text)
            return m.local_doubt(f"{text}; still changing, to {ahead:.3f}")

        covered = m.coverage(evidence, self.name, ENERGY)
        row = m.finding(
            covered, m.judge_claim(covered, judge, tier=1), estimate=order, method=m.Method("one step", 1)
        )
        sizes = zip(record.h, record.size, strict=True)
        return m.Judgement((row,), tuple(m.LevelFinding(ENERGY, None, float(e), h=float(h)) for h, e in sizes))


def energy(view, x):
    """Return H at states of shape (d, P)."""
    return view.observables[ENERGY](0.0, view.parts(view.state(x)))


@hookimpl
def sdaeverify_measures():
    """Register the measure."""
    return [EnergyDefect()]
