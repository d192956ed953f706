"""How far the limit of a wrong scheme is from the solution: both schemes on the same noise, with fine steps.

The difference of a wrong scheme and the right one it is made from is, as h tends to 0, the error of its limit; the
errors of the right one drop out of it. Nothing of a verdict takes part.
"""

from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Array, Scheme

from .draws import Drawn
from .faults import faulty, rows_of

# Grid times at which paths are compared, as a run does it.
COARSEST = 8


class Size(NamedTuple):
    """An error and what it is an error of.

    Attributes
    ----------
    error, std_error : float
    size : float
        Of the solution's motion on paths, E max |x(t) - x(0)|; of an observable q in law, E |q|.
    """

    error: float
    std_error: float
    size: float

    @property
    def relative(self) -> float:
        """The error in parts of the size."""
        return self.error / self.size if self.size > 0.0 else np.inf


def true_errors(case: Drawn, *, steps: int = 512, paths: int = 8192, seed: int = 1) -> dict[tuple[str, str], Size]:
    """Return the error of the limit by measure and quantity.

    Parameters
    ----------
    case : Drawn
    steps : int
        A multiple of 8.
    paths : int
    seed : int
    """
    view: Any = case.base.view_of(case.problem.build())
    fault = case.fault._replace(window=case.fault.window.in_the_limit)
    both = [case.base, faulty(case.base, fault, case.scheme.name)]
    rng = np.random.Generator(np.random.Philox(key=[seed, case.number]))
    grid = _run(both, view, steps, paths, rng)
    first = [scheme.parts(view, scheme.start(view, 1, view.horizon / steps)) for scheme in both]
    found = {}
    for name in ("state", *grid[-1][0]):
        kept = list(grid[-1][0]) if name == "state" else [name]
        found |= _on_paths(name, [[_rows(p, kept) for p in pair] for pair in grid], _rows(first[0], kept))
    for name, observable in view.observables.items():
        right, wrong = (observable(view.horizon, parts) for parts in grid[-1])
        found["weak", name] = _in_law(np.broadcast_to(right, (paths,)), np.broadcast_to(wrong, (paths,)))
    return found


def _run(both: list[Scheme], view: Any, steps: int, paths: int, rng: np.random.Generator) -> list[list[Any]]:
    """Return the components of both schemes at the grid times."""
    h = view.horizon / steps
    states = [scheme.start(view, paths, h) for scheme in both]
    steppers = [scheme.prepare(view, h) for scheme in both]
    seen = []
    for number in range(steps):
        noise = both[0].law.increment(view.drawn(rng, h, paths), h)
        states = [step(state, number * h, noise).state for step, state in zip(steppers, states, strict=True)]
        if (number + 1) % (steps // COARSEST) == 0:
            seen.append([dict(scheme.parts(view, state)) for scheme, state in zip(both, states, strict=True)])
    return seen


def _rows(parts: Any, names: list[str]) -> Array:
    return rows_of({name: parts[name] for name in names})


def _on_paths(name: str, grid: list[list[Array]], start: Array) -> dict[tuple[str, str], Size]:
    errors = np.array([np.linalg.norm(wrong - right, axis=0) for right, wrong in grid])
    moved = np.array([np.linalg.norm(right - start, axis=0) for right, _ in grid])
    return {
        ("strong", name): _mean(errors.max(axis=0), moved.max(axis=0)),
        ("strong", f"{name}@T"): _mean(errors[-1], moved[-1]),
    }


def _mean(errors: Array, sizes: Array) -> Size:
    return Size(float(errors.mean()), float(errors.std() / np.sqrt(len(errors))), float(sizes.mean()))


def _in_law(right: Array, wrong: Array) -> Size:
    d = wrong - right
    return Size(abs(float(d.mean())), float(d.std() / np.sqrt(len(d))), float(np.abs(right).mean()))
