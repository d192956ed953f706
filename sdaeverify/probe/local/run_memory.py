"""Memory of runs: whether a scheme with its memory deviates from a scheme entered anew at the same state.

Steps are probed from states that `enter` makes, with the memory that `enter` sets. In a run, the memory is left by
earlier steps. So, on each of several parts, a run is compared with a second one on the same noise that begins at
the same state with the memory of `enter`. For legitimate memory, an old drift or half an increment, the difference
has the size of one step's effect, which vanishes with h. If memory is not renewed when it should be, as a value of an
algebraic component or a drift of another region, the difference accumulates, however short the steps are.
"""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, Mask, Parts
from ...contracts.scheme import Scheme, State, Stepper, flatten
from ...forms import BROWNIAN, Delayed, IndexOne, Problem, components
from ...noise.brownian import USUAL, Brownian, Increment, LevelNoise, Source
from ..step.nodes import SEED

# Paths of a run, parts of the comparison, steps, and number of halvings to test whether differences vanish; larger
# number if they do not seem to, because a scheme may act every few steps only, which need not occur in a part with
# few steps.
# Size: paths, parts and steps of the runs.
PATHS, PARTS, COARSE, FINER, FINEST = 64, 8, 40, 2, 4
# Relative to the movement of the solution: smaller differences are ignored. A difference of order h^(1/2) is halved
# on steps of a fourth of the size; one that decreases by less than the second factor stays.
# Size: of what is followed; a smaller effect of memory is not reported.
# Theorem: elementary, halfway between 1/2, of order 1/2, and 1, of a difference that stays.
SMALL, VANISHING = 1e-3, 0.75
# Runs that differ by more than this multiple of their movement are not compared: such long steps are unstable.
# Theorem: elementary, two independent runs of the same law differ by sqrt(2) of their root mean square movement.
DIVERGED = 2.0
HISTORY = "a scheme that keeps a history of its own overrides start(problem, paths, h) instead of enter"


class Apart(NamedTuple):
    """Difference between a run and a run entered anew, at the end of each part of the run.

    Attributes
    ----------
    names : tuple of str
        Names of the C components.
    sizes : tuple of ndarray, shape (C, n)
        Root mean squares over the paths, relative to the movement of the solution; each for a fourth of the previous
        step size.
    delayed : bool
        Whether the problem has a delay, so that the memory may be a history, which `enter` cannot set.
    """

    names: tuple[str, ...]
    sizes: tuple[Array, ...]
    delayed: bool = False

    @property
    def stays(self) -> Mask:
        """Where the difference does not vanish with h, shape (C, n)."""
        falls = [fine <= VANISHING * coarse for coarse, fine in pairwise(self.sizes)]
        last = self.sizes[-1]
        return np.asarray((last > SMALL) & (last < DIVERGED) & ~np.any(falls, axis=0))

    @property
    def departure(self) -> str:
        """Description of a difference that does not vanish with h, in one line, or an empty string."""
        if not self.stays.any():
            return ""
        worst = np.where(self.stays, self.sizes[-1], 0.0)
        component, part = divmod(int(worst.argmax()), PARTS)
        where = f"from {part / PARTS:g} to {(part + 1) / PARTS:g} of the horizon"
        off = f"{worst.max():.2g} of the displacement of {self.names[component]} {where}"
        text = f"a run and a restart by enter(problem, state, t, h) differ by {off}, whatever h"
        return f"{text}; {HISTORY}" if self.delayed else text


def remembers(scheme: Scheme, view: Any) -> bool:
    """Return whether a scheme's state has more than the known components of an equation without y.

    Memory that `enter` does not set cannot be compared; neither can the memory of a state that lacks
    components needed to enter it.
    """
    form: IndexOne | None = view.capability(IndexOne)
    state = scheme.start(view, 1, view.horizon / COARSE)
    known = form.dimension if form is not None else components(view)
    compared = {"x"} if form is not None else {*view.parts(view.initial(1))}
    if view.records or len(flatten(state)) <= known or not compared <= {*scheme.parts(view, state)}:
        return False
    entered = scheme.enter(view, view.initial(1), 0.0, view.horizon / COARSE)
    return type(entered) is type(state) and flatten(entered).shape == flatten(state).shape


def run_memory(scheme: Scheme, view: Problem) -> Apart | None:
    """Compare a run with one that is entered anew at the start of each of eight parts of the horizon.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.

    Returns
    -------
    Apart or None
        None if there is no memory, or if the components needed to enter a state are not known.
    """
    if not remembers(scheme, view):
        return None
    with np.errstate(all="ignore"):
        names, fine = _apart(scheme, view, FINER)
        found = Apart(names, (fine,), bool(view.capability(Delayed)))
        if not (fine > SMALL).any():
            return found
        found = found._replace(sizes=(_apart(scheme, view, 0)[1], fine))
        return found._replace(sizes=(*found.sizes, _apart(scheme, view, FINEST)[1])) if found.stays.any() else found


def _apart(scheme: Scheme, view: Problem, level: int) -> tuple[tuple[str, ...], Array]:
    """Return names of components, and differences of both runs, shape (C, n), after `level` halvings of the steps."""
    fields = view.noise & {*BROWNIAN} | USUAL
    source = Source(SEED, "memory", 0, PATHS)
    drawn = Brownian(source, view.noise_dim, view.horizon / COARSE, level, fields).steps()
    found = _PairedRun(scheme, view, [next(drawn)[level] for _ in range(COARSE)]).apart()
    return tuple(found), np.array(list(found.values()))


class _PairedRun:
    """A run of a scheme on `PATHS` paths, and a second one that is entered anew at the start of each part."""

    def __init__(self, scheme: Scheme, view: Any, noise: list[LevelNoise]) -> None:
        self.scheme, self.view = scheme, view
        self.steps = [part.increment(n) for part in noise for n in range(len(part.dW))]
        self.h = view.horizon / len(self.steps)
        self.make: Stepper = scheme.prepare(view, self.h)
        self.recall = view.recall(self.h, PATHS)

    def apart(self) -> dict[str, Array]:
        """Return the differences at the ends of the parts by component, relative to the movement of the first run."""
        state = anew = self.scheme.start(self.view, PATHS, self.h)
        found: dict[str, list[float]] = {name: [] for name in self._parts(state)}
        before, length = self._parts(state), len(self.steps) // PARTS
        for n, drawn in enumerate(self.steps):
            noise = self.scheme.law.increment(drawn, self.h)
            noise = noise if self.recall is None else self.recall.add_past(noise)
            if n % length == 0:
                before, anew = self._parts(state), self._entered(state, n * self.h, noise)
            state, anew = (self.make(each, n * self.h, noise).state for each in (state, anew))
            now = self._parts(state)
            if self.recall is not None:
                self.recall.push(now["x"])
            if (n + 1) % length == 0:
                beside = self._parts(anew)
                for name, told in found.items():
                    told.append(_rms(now[name] - beside[name]) / _rms(now[name] - before[name]))
        return {name: np.nan_to_num(told, nan=0.0, posinf=0.0) for name, told in found.items()}

    def _entered(self, state: State, t: float, noise: Increment) -> State:
        parts, form = self._parts(state), self.view.capability(IndexOne)
        if form is not None:
            own = form.consistent(t, parts["x"], form.lag(parts["x"], self.h, noise).now)
        else:
            own = self.view.state(np.concatenate([parts[name] for name in self.view.parts(self.view.initial(1))]), t)
        return self.scheme.enter(self.view, own, t, self.h)

    def _parts(self, state: State) -> Parts:
        return self.scheme.parts(self.view, state)


def _rms(values: Array) -> Any:
    return np.sqrt(np.nanmean(values**2))
