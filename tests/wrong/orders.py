"""Schemes of too low an order: `python tests/wrong/orders.py reports/wrong-schemes/orders.csv 0-159`, by number.

A scheme makes the step of one of lower order in a region of states, in a window of time or in each k-th step, at
a share of 1, 1/2, 1/4 or 1/8, or takes the drift of an earlier step. Its order is then the lower one. The file has a
line for each claim of such a scheme; a verified one is wrong.
"""

import csv
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from facade import BAOAB, SRA1, EulerMaruyama, Heun, Milstein, PlatenWeak2, ProblemSpec
from planted.memory_schemes import Held, Remembering
from sdaeverify import SDE, Array, Increment, Langevin, Scheme, Step, verify
from statistical.search import numbers
from wrong.draws import _problem, pilot
from wrong.faults import Region, Window, chosen, rows_of

SEED = 50
# The step of lower order counts for 2^-k with k up to this one; regions have masses down to 2^-6.
SMALLEST, THINNEST = 3, 6.0
COLUMNS = ("number", "wrong", "problem", "measure", "quantity", "claim", "verdict", "reason")


class Kicked(BAOAB):
    """Weak order 1: p <- p + h F(q), q <- q + h p, and the exact Ornstein-Uhlenbeck step of p."""

    name: ClassVar[str] = "kicked"

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n, gamma = problem.noise_dim, problem.friction
        p = state[n:] + h * problem.force(state[:n])
        variance = -np.expm1(-2.0 * gamma * h) / (2.0 * gamma) if gamma > 0.0 else h
        end = np.exp(-gamma * h) * p + problem.strength * np.sqrt(variance / h) * noise.dW
        return Step(np.concatenate([state[:n] + h * p, end]))


class Ground(NamedTuple):
    """A scheme, one of lower order, a problem, and the measures whose order is then lower there."""

    high: type[Scheme]
    low: type[Scheme]
    problem: str
    measures: tuple[str, ...]


PAIRS: tuple[tuple[type[Scheme], type[Scheme], str, tuple[str, ...]], ...] = (
    (Heun, EulerMaruyama, "double-well ou forced-ou", ("weak", "invariant")),
    (Milstein, EulerMaruyama, "gbm hyperbolic growing-volatility", ("strong",)),
    (SRA1, EulerMaruyama, "double-well ou forced-ou", ("strong",)),
    (PlatenWeak2, EulerMaruyama, "gbm double-well hyperbolic", ("weak",)),
    # The step of lower order is conjugate to one of second order: some invariant means of it have that order.
    (BAOAB, Kicked, "harmonic-langevin angle-pendulum", ("weak",)),
)
GROUNDS = tuple(Ground(high, low, name, wrong) for high, low, names, wrong in PAIRS for name in names.split())


class Drawn(NamedTuple):
    """A scheme of too low an order, in words and as it is, where it runs, and the measures whose order is lower."""

    number: int
    told: str
    scheme: Scheme
    problem: ProblemSpec
    measures: tuple[str, ...]


class OldDrift(Remembering):
    """Heun's method for additive noise with the drift of the last of every `period` steps, in a region."""

    name: ClassVar[str] = "old-drift"
    region: ClassVar[Region] = Region()
    period: ClassVar[int] = 2
    share: ClassVar[float] = 1.0

    def remembered(self, state: Held, t: float, h: float) -> Array:
        """Return the state whose drift is taken."""
        stale = (state.count % self.period != 0) & self.region.holds(np.atleast_2d(state.x))
        return np.where(stale, state.x + self.share * (state.old - state.x), state.x)

    def kept(self, problem: SDE, state: Held, t: float, h: float) -> Array:
        """Return the state of the last renewal."""
        return np.where(state.count % self.period == 0, state.x, state.old)


def mixed(ground: Ground, share: float, region: Region, window: Window) -> Scheme:
    """Return a scheme that takes x_high + share (x_low - x_high) in a region and a window, and x_high elsewhere."""

    def prepare(self: Scheme, problem: Any, h: float) -> Callable[..., Step]:
        right, wrong = ground.high.prepare(self, problem, h), ground.low().prepare(problem, h)

        def stepper(state: Any, t: float, noise: Increment) -> Step:
            step, rows = right(state, t, noise), rows_of(self.parts(problem, state))
            if not window.holds(t, h, problem.horizon) or len(rows) <= region.row:
                return step
            moved = step.state + share * (wrong(state, t, noise).state - step.state)
            return step._replace(state=chosen(region.holds(rows), moved, step.state))

        return stepper

    own = {"name": "mixed", "prepare": prepare, "__module__": __name__}
    return dataclass(frozen=True)(type(f"Mixed{ground.high.__name__}", (ground.high,), own))()


def drawn(number: int, seed: int = SEED) -> Drawn:
    """Return the scheme of a number; every fourth has an old drift."""
    rng = np.random.Generator(np.random.Philox(key=[seed, number]))
    ground = GROUNDS[(number - number // 4) % len(GROUNDS)]
    if number % 4 == 3:
        ground = GROUNDS[int(rng.integers(0, 3))]
    spec, share = _problem(ground.problem), 2.0 ** -int(rng.integers(0, SMALLEST + 1))
    problem: Any = spec.build()
    region, window = _region(pilot(ground.high(), problem, rng), rng), _window(rng)
    if number % 4 == 3:
        period = int(rng.integers(2, 9))
        own = {"region": region, "period": period, "share": share, "__module__": __name__}
        old = type("OldDrift", (OldDrift,), own)()
        told = f"heun: drift renewed every {period} steps x {share:g} {_words(region, Window())}"
        return Drawn(number, told, old, spec, ground.measures)
    always = (window.begin, window.end) == (0.0, 1.0)
    measures = tuple(name for name in ground.measures if name != "invariant" or always)
    told = f"{ground.high.name}: {ground.low.name} x {share:g} {_words(region, window)}"
    return Drawn(number, told, mixed(ground, share, region, window), spec, measures)


def _region(states: Array, rng: np.random.Generator) -> Region:
    mass, row = 2.0 ** -rng.uniform(0.0, THINNEST), int(rng.integers(0, len(states)))
    begin = rng.uniform(0.0, 1.0 - mass)
    low, first, last, high = np.quantile(states[row], [mass, begin, begin + mass, 1.0 - mass]).tolist()
    kinds = (Region(), Region(row, high=low), Region(row, low=high), Region(row, first, last))
    return kinds[int(rng.integers(0, len(kinds)))]


def _window(rng: np.random.Generator) -> Window:
    length = 2.0 ** -rng.uniform(0.0, 3.0)
    begin = rng.uniform(0.0, 1.0 - length)
    kinds = (Window(), Window(), Window(begin, begin + length), Window(every=int(rng.integers(2, 9))))
    return kinds[int(rng.integers(0, len(kinds)))]


def _words(region: Region, window: Window) -> str:
    words = [] if region.everywhere else [f"for {region.low:.3g} < x{region.row} < {region.high:.3g}"]
    words += [f"in {window.begin:.3g}..{window.end:.3g} T"] if (window.begin, window.end) != (0.0, 1.0) else []
    words += [f"each {window.every}th step"] if window.every > 1 else []
    return " ".join(words)


def judged(case: Drawn) -> Iterator[dict[str, Any]]:
    """Yield a line for each claim of an order that is too high."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        table = verify([case.scheme], [case.problem], case.measures).verdicts
    for row in table[(table.scheme == case.scheme.label) & (table.claim != "")].to_dict("records"):
        yield {"number": case.number, "wrong": case.told} | {name: row[name] for name in COLUMNS if name in row}


def search(kept: Path, chosen_numbers: Sequence[int]) -> Counter[str]:
    """Write a line for each claim of some schemes, and return how often each verdict came."""
    verdicts = Counter[str]()
    with kept.open("w", newline="") as out:
        writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for line in (line for number in chosen_numbers for line in judged(drawn(number))):
            writer.writerow(line)
            verdicts[line["verdict"]] += 1
    return verdicts


if __name__ == "__main__":
    for verdict, count in sorted(search(Path(sys.argv[1]), list(numbers(sys.argv[2:]))).items()):
        print(f"{verdict}: {count}")
