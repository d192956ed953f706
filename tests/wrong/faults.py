"""Faults in a part of the steps: in a region of the states, in a stretch of the run, in one component, of some size.

A fault has four sides, and `faulty` puts them together: *where* (a region of states), *when* (a window of time or of
step numbers), *what* (a part of the step) and *how much* (a factor 1 + e). Where and when it holds, the step is the
wrong one, elsewhere it is the step of the scheme it is made from.
"""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, fields
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Claim, DelaySDAE, Increment, Langevin, Mask, Partials, Parts, Scheme, Step
from sdaeverify.forms.mechanics.multiplied import Mechanics

# What is scaled: by the equation, by the noise, or in the state that comes out.
EQUATION, NOISE = ("drift",), ("noise", "area", "integral")
STATE = ("step", "clip", "freeze", "shift", "memory", "algebraic")
PARTS = (*EQUATION, *NOISE, *STATE)


class Region(NamedTuple):
    """States whose row `row` lies between two bounds; everything if both are infinite.

    Attributes
    ----------
    row : int
        Of all components, one under the other.
    low, high : float
    """

    row: int = 0
    low: float = -np.inf
    high: float = np.inf

    @property
    def everywhere(self) -> bool:
        """Whether it leaves nothing out."""
        return bool(np.isinf(self.low) and np.isinf(self.high))

    def holds(self, rows: Array) -> Mask:
        """Tell which states of shape (d, P) are inside."""
        return np.asarray((self.low <= rows[self.row]) & (rows[self.row] <= self.high))


class Window(NamedTuple):
    """Steps whose middle lies between two parts of the horizon, each `every`-th of them, from number `first` on.

    Attributes
    ----------
    begin, end : float
        As parts of the horizon.
    every, first : int
    """

    begin: float = 0.0
    end: float = 1.0
    every: int = 1
    first: int = 0

    def holds(self, t: float, h: float, horizon: float) -> bool:
        """Tell whether the step of size h from time t belongs to it."""
        number, middle = round(t / h), (t + 0.5 * h) / horizon
        inside = self.begin <= middle <= self.end or (self.end >= 1.0 <= middle)
        return inside and number >= self.first and number % self.every == self.every - 1

    @property
    def in_the_limit(self) -> "Window":
        """The same for h to 0, where every step has a large number."""
        return self._replace(first=0)


class Fault(NamedTuple):
    """What is wrong, where, when and by how much.

    Attributes
    ----------
    part : str
        One of `PARTS`.
    excess : float
        e of the factor 1 + e; of ``shift`` the drift that is added.
    component : int
        The row, or the motion of ``noise``; -1 for all of them.
    region : Region
    window : Window
    rows : int
        Number of components that a problem must have for the fault to show, as in a branch of its own; 0 for any.
    """

    part: str
    excess: float = 0.0
    component: int = -1
    region: Region = Region()
    window: Window = Window()
    rows: int = 0

    def meets(self, rows: Array) -> bool:
        """Tell whether a problem with such states has the fault at all."""
        return len(rows) == self.rows if self.rows else len(rows) > max(self.component, self.region.row)

    @property
    def told(self) -> str:
        """The fault in words."""
        size = {"clip": "", "freeze": "", "memory": "", "shift": f" by {self.excess:+.3g}"}
        words = [self.part + size.get(self.part, f" x {1.0 + self.excess:.6g}")]
        words += [f"of {self.component}"] if self.component >= 0 else []
        words += [] if self.region.everywhere else ["for {1:.3g} < x{0} < {2:.3g}".format(*self.region)]
        begin, end, every, first = self.window
        words += [f"in {begin:.4g}..{end:.4g} T"] if (begin, end) != (0.0, 1.0) else []
        words += [f"each {every}th step"] if every > 1 else []
        words += [f"from step {first}"] if first else []
        words += [f"where d = {self.rows}"] if self.rows else []
        return " ".join(words)


def faulty(base: Scheme, fault: Fault, name: str, **declared: Any) -> Scheme:
    """Return a scheme with a fault that claims what the one it is made from claims.

    Parameters
    ----------
    base : Scheme
    fault : Fault
    name : str
    **declared : object
        Class variables that it declares beside, ``discontinuous_in_noise`` or ``noise``.
    """
    original = type(base)

    def prepare(self: Scheme, problem: Any, h: float) -> Callable[..., Step]:
        right = original.prepare(self, problem, h)
        wrong = original.prepare(self, altered(problem, fault), h) if fault.part in EQUATION else right

        def stepper(state: Any, t: float, noise: Increment) -> Step:
            step, rows = right(state, t, noise), rows_of(self.parts(problem, state))
            if not (fault.window.holds(t, h, problem.horizon) and fault.meets(rows)):
                return step
            bad = wrong(state, t, louder(noise, fault)) if fault.part in (*EQUATION, *NOISE) else step
            inside = fault.region.holds(rows)
            moved = changed(fault, state, bad.state, h) if fault.part in STATE else bad.state
            return step._replace(state=chosen(inside, moved, step.state))

        return stepper

    own = {"name": name, "prepare": prepare, "__module__": __name__, **declared}
    cls = dataclass(frozen=True)(type(f"Faulty{original.__name__}", (original,), own))
    return cls(**{field.name: getattr(base, field.name) for field in fields(base) if field.init})


def altered(problem: Any, fault: Fault) -> Any:
    """Return a problem with the drift of one component, or of all, times 1 + e."""

    def scaled(f: Array) -> Array:
        return np.asarray(factors(len(f), fault) * f)

    other = copy(problem)
    if isinstance(problem, SDE):
        _put(other, drift=lambda t, x: scaled(problem.drift(t, x)), drift_derivative=None)
    elif isinstance(problem, DelaySDAE):
        whole = 1.0 + fault.excess
        _put(other, drift=lambda t, x, v, y: whole * problem.drift(t, x, v, y))
        derivatives = problem.drift_partials
        if derivatives is not None:
            _put(other, drift_partials=lambda *at: Partials(*(whole * part for part in derivatives(*at))))
    elif isinstance(problem, Langevin):
        _put(other, force=lambda q: scaled(problem.force(q)))
    elif isinstance(problem, Mechanics):
        _put(other, force=lambda t, r, v: scaled(np.broadcast_to(problem.force(t, r, v), r.shape)))
    else:
        raise TypeError(f"no drift to alter in a {type(problem).__name__}")
    return other


def _put(thing: Any, **values: Any) -> None:
    for key, value in values.items():
        object.__setattr__(thing, key, value)


def louder(noise: Increment, fault: Fault) -> Increment:
    """Return noise with the part that the fault names times 1 + e."""
    kind = {"noise": "dW", "area": "A", "integral": "H"}.get(fault.part)
    if kind is None:
        return noise
    data = getattr(noise, kind)
    return noise if data is None else noise._replace(**{kind: factors(len(data), fault) * data})


def factors(rows: int, fault: Fault) -> Array:
    """Return 1 + e for the rows that are wrong and 1 for the others, shape (rows, 1)."""
    wrong = (np.arange(rows) == fault.component) | (fault.component < 0)
    return np.where(wrong, 1.0 + fault.excess, 1.0)[:, None]


def changed(fault: Fault, old: Any, new: Any, h: float) -> Any:
    """Return the state that a fault in what comes out of a step makes of the right one."""
    names = type(new)._fields if isinstance(new, tuple) else ()
    if fault.part in CARRIED:
        name = CARRIED[fault.part]
        if name not in names:
            return new
        kept = getattr(old, name) if fault.part == "memory" else (1.0 + fault.excess) * getattr(new, name)
        return new._replace(**{name: kept})
    if names:
        return new._replace(**{names[0]: changed(fault, old[0], new[0], h)})
    c = fault.component if fault.component >= 0 else slice(None)
    moved = np.array(new)
    if fault.part == "clip":
        # A half-space or an interval is left no more: what lies beyond its bound is put onto it.
        moved[c] = np.minimum(moved[c], fault.region.high) if fault.region.high < np.inf else moved[c]
        moved[c] = np.maximum(moved[c], fault.region.low) if fault.region.low > -np.inf else moved[c]
    elif fault.part == "shift":
        moved[c] += h * fault.excess
    else:
        moved[c] = old[c] + (0.0 if fault.part == "freeze" else 1.0 + fault.excess) * (new[c] - old[c])
    return moved


# What a step carries along beside x, and the field that it is in.
CARRIED = {"memory": "memory", "algebraic": "y"}


def rows_of(parts: Parts) -> Array:
    """Return all components, one under the other."""
    return np.concatenate([*parts.values()])


def chosen(inside: Mask, wrong: Any, right: Any) -> Any:
    """Return the wrong state on some paths and the right one on the others."""
    if isinstance(right, tuple):
        return type(right)(*(np.where(inside, a, b) for a, b in zip(wrong, right, strict=True)))
    return np.where(inside, wrong, right)


class Remembering(NamedTuple):
    """x, and the drift at x that the last step has left behind."""

    x: Array
    memory: Array


class RememberedDrift(Scheme):
    """Euler-Maruyama that keeps the drift of its end for the next step: x+ = x + h m + B dW, m+ = f(t + h, x+)."""

    name: ClassVar[str] = "remembered-drift"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source="Maruyama 1955"),
        Claim(measure="weak", value=1.0, source="Kloeden & Platen 1992, section 14.1"),
    )

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Remembering:
        """Return a state with the drift there."""
        return Remembering(state, np.array(np.broadcast_to(problem.drift(t, state), state.shape)))

    def parts(self, problem: SDE, state: Remembering) -> Parts:
        """Return x alone."""
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Remembering, t: float, h: float, noise: Increment) -> Step:
        """Make one step; x has shape (d, P)."""
        x = state.x + h * state.memory + problem.diffused(t, state.x, noise.dW)
        return Step(Remembering(x, np.array(np.broadcast_to(problem.drift(t + h, x), x.shape))))
