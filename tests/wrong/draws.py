"""Wrong schemes by their numbers: a right scheme, a problem, and a fault drawn at random from all combinations."""

from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import scipy

from facade import ProblemSpec, gaussian_step, load_registry, select_problems, select_schemes
from sdaeverify import SDE, Array, Increment, Moment, Pathwise, Problem, Scheme

from .faults import Fault, Region, RememberedDrift, Window, faulty, rows_of

SEED = 30
# Sizes of a fault are 2^-k with k from 0 to this one.
SMALLEST = 12
CHAIN = "a chain of linear equations, made for this search"
PILOT_STEPS, PILOT_PATHS = 64, 1024


def chain(motions: int = 12, multiplicative: float = 0.0, horizon: float = 1.0) -> SDE:
    """Linear chain with a noise for each link: dx_i = (x_{i-1} - x_i) dt + (1/2 + m x_i) dW_i, x_i(0) = 3/2, x_0 = 1.

    Parameters
    ----------
    motions : int
        Number of links.
    multiplicative : float
        m; with m = 0 the noise is additive, and the solution is known on each path.
    horizon : float
    """
    A, B = np.eye(motions, k=-1) - np.eye(motions), 0.5 * np.eye(motions)
    start, links = np.full(motions, 1.5), np.arange(motions)
    additive = multiplicative == 0.0

    def diagonal(rows: Array) -> Array:
        matrix = np.zeros((motions, motions, rows.shape[1]), dtype=rows.dtype)
        matrix[links, links] = rows
        return matrix

    return SDE(
        drift=lambda t, x: np.concatenate([1.0 - x[:1], x[:-1] - x[1:]]),
        diffusion=lambda t, x: diagonal(0.5 + multiplicative * x),
        diffusion_derivative=lambda t, x, y: diagonal(multiplicative * y),
        start=start,
        noise_dim=motions,
        horizon=horizon,
        traits=frozenset({"diagonal-noise", *(["additive-noise"] if additive else [])}),
        observables={
            "x_1": lambda t, s: s["x"][0],
            "x_l": lambda t, s: s["x"][-1],
            "|x|^2": lambda t, s: (s["x"] ** 2).sum(axis=0),
        },
        truths=(_exact(A, B, start), *_means(A, start)) if additive else (),
        source=CHAIN,
    )


def _exact(A: Array, B: Array, start: Array) -> Pathwise:
    """Return the solution of dx = A (x - 1) dt + B dW."""
    steps = cache(lambda h: gaussian_step(A, B, h))

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        step = steps(h)
        return 1.0 + step.propagator @ (x - 1.0) + step.of_dW @ noise.dW + step.of_H @ noise.H + step.of_xi @ noise.xi

    return Pathwise(
        start=lambda paths: np.repeat(start[:, None], paths, axis=1),
        advance=advance,
        parts=lambda t, x: {"x": x},
        extra_normals=len(A),
        source=CHAIN,
    )


def _means(A: Array, start: Array) -> Iterator[Moment]:
    for name, row in (("x_1", 0), ("x_l", len(A) - 1)):

        def value(t: float, row: int = row) -> float:
            return float(1.0 + (scipy.linalg.expm(t * A) @ (start - 1.0))[row])

        yield Moment(observable=name, value=value, source=CHAIN)


class Ground(NamedTuple):
    """A right scheme and where it runs.

    Attributes
    ----------
    scheme : str
        Label; ``remembered-drift`` is the one of this folder.
    problem : str
        Label; ``chain`` is the one of this folder.
    parts : tuple of str
        What can be wrong there.
    """

    scheme: str
    problem: str
    parts: tuple[str, ...]


COMMON = ("drift", "drift", "noise", "noise", "step", "clip", "freeze", "shift")
SIMPLE = {
    "euler-maruyama": ("gbm", "ou", "ou[horizon=4]", "double-well", "noncommuting", "chain", "chain[motions=24]"),
    "milstein": ("gbm", "hyperbolic", "growing-volatility", "chain[multiplicative=0.3]"),
    "heun": ("gbm", "hyperbolic-pair", "double-well", "forced-ou"),
    "platen-weak-2": ("gbm", "double-well", "hyperbolic", "chain"),
    "stochastic-theta": ("gbm", "double-well", "spiral"),
}
GROUNDS = (
    *(Ground(name, problem, COMMON) for name, problems in SIMPLE.items() for problem in problems),
    *(Ground("sra1", name, (*COMMON, "integral")) for name in ("ou", "double-well", "forced-ou", "chain")),
    *(Ground("remembered-drift", name, ("memory",)) for name in ("gbm", "double-well", "ou[horizon=4]", "spiral")),
    *(Ground("milstein-areas", "levy-area", (*COMMON, "area", "area")) for _ in range(2)),
    *(Ground("explicit-projection-euler", "pendulum[horizon=1]", ("drift", "noise")) for _ in range(2)),
    *(Ground("baoab", name, ("drift", "noise", "freeze")) for name in ("harmonic-langevin", "angle-pendulum")),
    *(Ground("stochastic-theta", "gbm-algebraic", ("drift", "noise", "step", "algebraic")) for _ in range(3)),
    *(Ground("lagged-algebraic-theta", "gbm-algebraic", ("drift", "noise", "algebraic")) for _ in range(2)),
)


class Drawn(NamedTuple):
    """A wrong scheme.

    Attributes
    ----------
    number : int
    base, scheme : Scheme
        The right one, and what the fault makes of it.
    problem : ProblemSpec
    fault : Fault
    declared : str
        ``jumps`` or ``areas`` where the scheme declares what turns a look at one step off; else empty.
    """

    number: int
    base: Scheme
    scheme: Scheme
    problem: ProblemSpec
    fault: Fault
    declared: str = ""

    @property
    def told(self) -> str:
        """What is wrong, in words."""
        declared = f", declares {self.declared}" if self.declared else ""
        return f"{self.base.label}: {self.fault.told}{declared}"


def drawn(number: int, seed: int = SEED) -> Drawn:
    """Return a wrong scheme; consecutive numbers go through all grounds."""
    rng = np.random.Generator(np.random.Philox(key=[seed, number]))
    ground = GROUNDS[number % len(GROUNDS)]
    base, spec = _scheme(ground.scheme), _problem(ground.problem)
    view: Any = base.view_of(spec.build())
    part = str(rng.choice(ground.parts))
    fault = _fault(part, base, view, rng)
    declared = _declared(base, view, rng)
    scheme = faulty(base, fault, f"wrong-{number:04d}", **_variables(base, declared))
    return Drawn(number, base, scheme, spec, fault, declared)


def _fault(part: str, base: Scheme, view: Any, rng: np.random.Generator) -> Fault:
    states = pilot(base, view, rng)
    excess = float(rng.choice([-1.0, 1.0]) * 2.0 ** -rng.integers(0, SMALLEST + 1))
    row = int(rng.integers(0, _rows_of_part(part, view, len(states))))
    component = -1 if rng.uniform() < 0.3 or part in {"memory", "algebraic"} else row
    region, window = _region(states, rng), _window(rng)
    if part == "shift":
        excess *= float(np.abs(states[component] if component >= 0 else states).mean()) / view.horizon
    if part == "clip":
        component = component if component >= 0 else 0
        region = _inside(states, component, rng)
    if region.everywhere and part in {"freeze", "memory"}:
        # What never moves at all is no scheme.
        region = _region(states, rng, always=False)
    rows = len(states) if rng.uniform() < 0.5 else 0
    return Fault(part, excess, component, region, window, rows)


def _rows_of_part(part: str, view: Any, components: int) -> int:
    """Return how many rows there are of what is wrong; forces move half of the components."""
    l = view.noise_dim
    known = {"noise": l, "integral": l, "area": l * (l - 1) // 2}
    if part == "drift" and not hasattr(view, "drift"):
        return l
    return known.get(part, components)


def _region(states: Array, rng: np.random.Generator, *, always: bool = True) -> Region:
    """Return everything, a half-space or an interval of a random probability under the law of the run."""
    kind = rng.choice(["all", "above", "below", "between"] if always else ["above", "below", "between"])
    probability, row = 2.0 ** -rng.uniform(0.3, 6.0), int(rng.integers(0, len(states)))
    x = states[row]
    if kind == "all" or np.ptp(x) == 0.0:
        return Region()
    if kind == "above":
        return Region(row, low=float(np.quantile(x, 1.0 - probability)))
    if kind == "below":
        return Region(row, high=float(np.quantile(x, probability)))
    begin = rng.uniform(0.0, 1.0 - probability)
    low, high = np.quantile(x, [begin, begin + probability])
    return Region(row, float(low), float(high))


def _inside(states: Array, row: int, rng: np.random.Generator) -> Region:
    """Return where a clipped component may be: on one side of its bound."""
    probability = 2.0 ** -rng.uniform(1.0, 8.0)
    if rng.uniform() < 0.5:
        return Region(row, high=float(np.quantile(states[row], 1.0 - probability)))
    return Region(row, low=float(np.quantile(states[row], probability)))


def _window(rng: np.random.Generator) -> Window:
    kind = rng.choice(["always", "between", "between", "every", "first"], p=[0.35, 0.25, 0.1, 0.15, 0.15])
    if kind == "between":
        length = 2.0 ** -rng.uniform(0.0, 6.0)
        begin = rng.uniform(0.0, 1.0 - length)
        return Window(begin, begin + length)
    if kind == "every":
        return Window(every=int(rng.integers(2, 33)))
    return Window(first=int(rng.integers(8, 129))) if kind == "first" else Window()


def _declared(base: Scheme, view: Any, rng: np.random.Generator) -> str:
    share = rng.uniform()
    if share < 0.12:
        return "jumps"
    return "areas" if share < 0.24 and isinstance(view, SDE) and "A" not in base.noise and "A" in view.noise else ""


def _variables(base: Scheme, declared: str) -> dict[str, Any]:
    return {"": {}, "jumps": {"jumps": True}, "areas": {"noise": base.noise | {"A"}}}[declared]


@cache
def _scheme(label: str) -> Scheme:
    return RememberedDrift() if label == "remembered-drift" else select_schemes(load_registry([]), label)[0]


@cache
def _problem(label: str) -> ProblemSpec:
    if not label.startswith("chain"):
        return select_problems(load_registry([]), label)[0]
    given = dict(text.split("=") for text in label[len("chain") :].strip("[]").split(",") if text)
    kinds = {"motions": int, "multiplicative": float, "horizon": float}
    return ProblemSpec("chain", chain, tuple((name, kinds[name](text)) for name, text in given.items()))


def pilot(base: Scheme, view: Problem, rng: np.random.Generator) -> Array:
    """Return states of runs of the right scheme at all times, shape (d, steps * paths)."""
    h = view.horizon / PILOT_STEPS
    state, step = base.start(view, PILOT_PATHS, h), base.prepare(view, h)
    seen = []
    for number in range(PILOT_STEPS):
        noise = base.law.increment(view.drawn(rng, h, PILOT_PATHS), h)
        state = step(state, number * h, noise).state
        seen.append(rows_of(base.parts(view, state)))
    return np.concatenate(seen, axis=1)
