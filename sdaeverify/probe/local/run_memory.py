"""Memory of runs: whether what a scheme remembers takes it elsewhere than the same state entered anew.

Steps are probed from states that `enter` makes, and it makes what is remembered as it should be. In a run it is what
the steps before left. So a run is compared, part by part, with one that begins at the state where it is, is driven by
the same noise, and remembers what `enter` sets. What memory rightly holds, an old drift or half an increment, makes
them differ by what one step does, which vanishes with h; what is not renewed where it should be, a value of an
algebraic component or a drift of another region, adds up, however short the steps are.
"""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, Mask, Parts
from ...contracts.scheme import Scheme, State, Stepper, flatten
from ...forms import BROWNIAN, IndexOne, Problem, components
from ...noise.brownian import USUAL, Increment, LevelNoise, Source, brownian_steps
from ..step.nodes import SEED

# Paths of a run, the parts it is compared in, its steps, and how often these are halved to see what vanishes; and how
# often where they do not seem to: what a scheme does every so many steps need not be in a part of so few.
# Size: paths, parts and steps of the runs.
PATHS, PARTS, COARSE, FINER, FINEST = 64, 8, 40, 2, 4
# In parts of what the solution moves: below, memory may do what it likes. What vanishes like h^(1/2) is halved on
# steps of a fourth of the size, what does not stays.
SMALL, VANISHING = 1e-3, 0.75
# Of runs that are farther apart than so many times what they move, nothing is known: steps that long are not stable.
DIVERGED = 2.0


class Apart(NamedTuple):
    """How far a run is from one that was entered anew, at the end of each part of it.

    Attributes
    ----------
    names : tuple of str
        Of C components.
    sizes : tuple of ndarray, shape (C, n)
        Root mean squares over the paths, in parts of what the solution moves; steps of each are a fourth as long.
    """

    names: tuple[str, ...]
    sizes: tuple[Array, ...]

    @property
    def stays(self) -> Mask:
        """Where the difference does not vanish with h, shape (C, n)."""
        falls = [fine <= VANISHING * coarse for coarse, fine in pairwise(self.sizes)]
        last = self.sizes[-1]
        return np.asarray((last > SMALL) & (last < DIVERGED) & ~np.any(falls, axis=0))

    @property
    def departure(self) -> str:
        """Where the difference does not vanish with h, in one line, or an empty string."""
        if not self.stays.any():
            return ""
        worst = np.where(self.stays, self.sizes[-1], 0.0)
        component, part = divmod(int(worst.argmax()), PARTS)
        where = f"from {part / PARTS:g} to {(part + 1) / PARTS:g} of the horizon"
        off = f"{worst.max():.2g} of what {self.names[component]} moves {where}"
        return f"a run and a start by enter(problem, state, t, h) differ by {off}, and no less as h falls"


def remembers(scheme: Scheme, view: Any) -> bool:
    """Tell whether a scheme's state is more than the components that are known of an equation without y.

    Memory that `enter` does not set at all is none that could be compared; nor is that of a state which lacks
    components that a state is entered with.
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
    """Compare a run with one that is entered anew at the begin of each of eight parts of the horizon.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.

    Returns
    -------
    Apart or None
        None where there is no memory, or nothing is known that a state could be entered with.
    """
    if not remembers(scheme, view):
        return None
    with np.errstate(all="ignore"):
        names, fine = _apart(scheme, view, FINER)
        if not (fine > SMALL).any():
            return Apart(names, (fine,))
        found = Apart(names, (_apart(scheme, view, 0)[1], fine))
        return Apart(names, (*found.sizes, _apart(scheme, view, FINEST)[1])) if found.stays.any() else found


def _apart(scheme: Scheme, view: Problem, level: int) -> tuple[tuple[str, ...], Array]:
    """Return names of components, and how far both runs are apart, shape (C, n), after so many halvings of steps."""
    fields = view.noise & {*BROWNIAN} | USUAL
    source = Source(SEED, "memory", 0, PATHS)
    drawn = brownian_steps(source, view.noise_dim, view.horizon / COARSE, level, fields)
    found = _PairedRun(scheme, view, [next(drawn)[level] for _ in range(COARSE)]).apart()
    return tuple(found), np.array(list(found.values()))


class _PairedRun:
    """A run of a scheme on so many paths, with a second one beside it that is entered anew now and then."""

    def __init__(self, scheme: Scheme, view: Any, noise: list[LevelNoise]) -> None:
        self.scheme, self.view = scheme, view
        self.steps = [part.increment(n) for part in noise for n in range(len(part.dW))]
        self.h = view.horizon / len(self.steps)
        self.make: Stepper = scheme.prepare(view, self.h)
        self.recall = view.recall(self.h, PATHS)

    def apart(self) -> dict[str, Array]:
        """Return how far both are apart at the ends of the parts, by component, in parts of what the first moves."""
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
