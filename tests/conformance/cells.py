"""What the conformance tests are run over: the registry, crossed by the rule the program itself uses."""

from collections import Counter
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from sdaeverify.arrays import Array, Mask, Parts
from sdaeverify.forms import SDE, DelaySDAE, HolonomicSDAE, Problem
from sdaeverify.matching import match
from sdaeverify.noise import Increment, Source, brownian_steps
from sdaeverify.probe.delay_links import linked_equation
from sdaeverify.registry import Registry
from sdaeverify.scheme import Scheme, State, Step
from sdaeverify.specs import ProblemSpec
from sdaeverify.truths import Moment

# Parameters that switch truths or terms on which the defaults leave off.
VARIANTS = {
    "damped-pendulum": ({"c_g": "0.0"}, {"c_g": "0.0", "gamma": "0.3", "kT": "1.5"}),
    "delay-linear": ({"c": "0.0"},),
    "delay-test": ({"set": "II"}, {"set": "V", "l": "0.0"}, {"horizon": "1.0"}),
    "double-well": ({"sigma": "0.5"},),
    "ellipse": ({"measure": "delta"},),
    "fibre-clamped": ({"d": "3", "N": "3"},),
    "fibre-free": ({"d": "3", "N": "3"},),
    "gbm-algebraic": ({"tau": "0.3"},),
    "nonlinear-constraint": ({"tau": "0.0"},),
    "ou": ({"a": "-0.8"},),
    "pendulum": ({"c_g": "0.0"}, {"c_g": "0.0", "omega_0": "-1.5", "theta_0": "2.0"}),
    "pendulum-velocity-noise": ({"gamma": "0.7", "sigma": "0.3"}, {"gamma": "0.5", "sigma": "1.0"}),
}
# Lengths over which coefficients vary where it is not 1: a quarter of the distance of two points of a fibre.
LENGTHS = {"fibre-clamped": 2.0**-5, "fibre-free": 2.0**-5}


# So many views of each form are tried, and each with its own schemes everywhere.
VIEWS = 1


class Cell(NamedTuple):
    """A scheme and a problem of the form it solves."""

    scheme: Scheme
    problem: Problem
    label: str


class Promise(NamedTuple):
    """A problem and the expectation it knows of one of its observables."""

    spec: ProblemSpec
    moment: Moment
    label: str


class Trait(NamedTuple):
    """A problem and a trait it declares."""

    spec: ProblemSpec
    name: str
    label: str


def schemes(registry: Registry) -> list[Scheme]:
    """Return every default variant of every scheme."""
    return [scheme for entry in registry.schemes.values() for scheme in entry.variants]


def specs(registry: Registry) -> list[ProblemSpec]:
    """Return every problem with its defaults, and some with other parameters."""
    defaults = [entry.make() for entry in registry.problems.values()]
    entries = registry.problems.items()
    return defaults + [entry.make(texts) for name, entry in entries for texts in VARIANTS.get(name, ())]


def constrained(registry: Registry) -> list[ProblemSpec]:
    """Return the problems with constraints."""
    return [spec for spec in specs(registry) if isinstance(spec.build(), HolonomicSDAE)]


def solved(registry: Registry) -> list[ProblemSpec]:
    """Return the problems whose solution on a path is known."""
    return [spec for spec in specs(registry) if spec.build().pathwise is not None]


def charted(registry: Registry) -> list[ProblemSpec]:
    """Return the problems with a chart."""
    return [spec for spec in specs(registry) if spec.build().chart is not None]


def cells(registry: Registry) -> Iterator[Cell]:
    """Yield every scheme variant with every problem of its form that matches, and with some views of each other form.

    A view is the same code for all problems of a form: those of fewest components stand for them.
    """
    built = [(entry.make().label, entry.make().build()) for entry in registry.problems.values()]
    for scheme in schemes(registry):
        seen: Counter[type[Problem]] = Counter()
        for label, problem in sorted(built, key=lambda pair: components(pair[1])):
            found = match(scheme, problem).problem
            if found is None:
                continue
            seen[type(problem)] += 1
            if found is problem or seen[type(problem)] <= VIEWS:
                yield Cell(scheme, found, f"{scheme.label} on {label}")


def components(problem: Problem) -> int:
    """Return the number of components of a problem's state."""
    return sum(len(part) for part in problem.parts(problem.initial(1)).values())


def promises(registry: Registry) -> Iterator[Promise]:
    """Yield every expectation a problem knows."""
    for spec in specs(registry):
        for truth in spec.build().truths:
            if isinstance(truth, Moment):
                yield Promise(spec, truth, f"{spec.label} {truth.observable}")


def declared(registry: Registry) -> Iterator[Trait]:
    """Yield every trait a problem declares."""
    for spec in specs(registry):
        for name in sorted(spec.build().traits):
            yield Trait(spec, name, f"{spec.label} {name}")


def spread(scheme: Scheme, problem: Problem, paths: int) -> State:
    """Return read-only states along a pilot trajectory over the horizon: paths are stopped one after the other.

    There are at most 32 steps: of more paths some stop together, each where its own noise has led it.
    """
    steps = min(paths, 32)
    h, last = problem.horizon / steps, np.arange(paths) * steps // paths
    cell, state = Cell(scheme, problem, ""), scheme.start(problem, paths, h)
    stepper = prepared(cell, h)
    for n in range(last[-1]):
        new = stepper(state, driving(problem, paths, h, n)).state
        state = _chosen(last > n, new, state)
    for array in fields(state):
        array.flags.writeable = False
    return state


def draw(dimension: int, paths: int, h: float, block: int = 0) -> Increment:
    """Return the noise of one step."""
    (level,) = next(brownian_steps(Source(1, "conformance", block, paths), dimension, h, 0))
    return level.increment(0)


def driving(problem: Problem, paths: int, h: float, block: int = 0) -> Increment:
    """Return the noise of one step of a problem, with a past of its own on each path where there is a delay."""
    noise = draw(problem.noise_dim, paths, h, block)
    if problem.recall(h, paths) is None:
        return noise
    x = problem.initial(paths).x
    past = x + 0.5 * np.random.default_rng(block).standard_normal((2, *x.shape))
    past.flags.writeable = False
    return noise._replace(lagged=past[0], ahead=past[1])


def equation(problem: Problem) -> SDE:
    """Return the Ito equation of a problem, with a delay that of the solution now and one delay ago."""
    seen = linked_equation(problem, 2) if isinstance(problem, DelaySDAE) and problem.delay else problem.view(SDE)
    assert isinstance(seen, SDE)
    return seen


def at_the_start(problem: Problem, paths: int = 1) -> Parts:
    """Return the initial components, with what else a constraint may depend on."""
    parts = problem.parts(problem.initial(paths))
    if not isinstance(problem, DelaySDAE):
        return parts
    return {**parts, "lagged": np.repeat(problem.past(-problem.delay), paths, axis=1), "t": np.zeros((1, 1))}


def prepared(cell: Cell, h: float) -> Callable[[State, Increment], Step]:
    """Return the step as the harness makes it: non-finite numbers are evidence, no warning."""
    stepper = cell.scheme.prepare(cell.problem, h)

    def made(state: State, noise: Increment) -> Step:
        with np.errstate(all="ignore"):
            return stepper(state, 0.3 * cell.problem.horizon, noise)

    return made


def step(cell: Cell, state: State, h: float, noise: Increment) -> Step:
    """Prepare and make one step."""
    return prepared(cell, h)(state, noise)


def fields(state: State) -> tuple[Array, ...]:
    """Return the arrays of a state."""
    return state if isinstance(state, tuple) else (state,)


def take(thing: State, paths: Array | slice) -> State:
    """Return a state, or the noise, of some of the paths."""
    if not isinstance(thing, tuple):
        return thing[..., paths]
    return type(thing)(*(None if x is None else x[..., paths] for x in thing))


def copied(thing: State) -> State:
    """Return a copy that can be written into."""
    if not isinstance(thing, tuple):
        return thing.copy()
    return type(thing)(*(None if x is None else x.copy() for x in thing))


def _chosen(mask: Mask, new: State, old: State) -> State:
    if not isinstance(new, tuple):
        return np.where(mask, new, old)
    return type(new)(*(np.where(mask, a, b) for a, b in zip(new, old, strict=True)))
