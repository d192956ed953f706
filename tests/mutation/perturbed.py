"""Bugs of a kind that no single formula shows: in one component, in rare steps, from some time on, in the past."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from sdaeverify import Increment, Scheme, Step

from .sources import remade

# Which steps go wrong, by their time, their length and the horizon.
When = Callable[[float, float, float], bool]

WHEN: dict[str, When] = {
    "always": lambda t, h, horizon: True,
    "each 7th step": lambda t, h, horizon: round(t / h) % 7 == 6,
    "each 16th step": lambda t, h, horizon: round(t / h) % 16 == 15,
    "after 0.6 T": lambda t, h, horizon: t > 0.6 * horizon,
    "after 0.9 T": lambda t, h, horizon: t > 0.9 * horizon,
    "before 0.1 T": lambda t, h, horizon: t < 0.1 * horizon,
}


def perturbed(scheme: Scheme, bug: str, when: str, name: str) -> Scheme:
    """Return a scheme whose steps are wrong at times.

    Parameters
    ----------
    scheme : Scheme
    bug : str
        ``weaker noise``, ``no step``, ``lag lost`` or ``component 0``.
    when : str
        Key of `WHEN`.
    name : str
        Of the new scheme.
    """
    original = type(scheme)

    def prepare(self: Scheme, problem: Any, h: float) -> Any:
        right = original.prepare(self, problem, h)

        def stepper(state: Any, t: float, noise: Increment) -> Step:
            if not WHEN[when](t, h, problem.horizon):
                return right(state, t, noise)
            return _wrong(bug, right, state, t, noise)

        return stepper

    own = {"name": name, "prepare": prepare, "__module__": __name__}
    cls = dataclass(frozen=True)(type(f"Perturbed{original.__name__}", (original,), own))
    return remade(cls, scheme)


def _wrong(bug: str, right: Any, state: Any, t: float, noise: Increment) -> Step:
    if bug == "no step":
        return Step(state)
    if bug == "weaker noise":
        return right(state, t, noise._replace(dW=0.8 * noise.dW))
    if bug == "lag lost":
        return right(state, t, noise._replace(lagged=0.0 * noise.lagged, ahead=0.0 * noise.ahead))
    step = right(state, t, noise)
    return step._replace(state=_moved(state, step.state))


def _moved(old: Any, new: Any) -> Any:
    """Return the new state with the first component's change enlarged by a tenth."""
    if isinstance(new, tuple):
        return new._replace(**{new._fields[0]: _moved(old[0], new[0])})
    moved = np.array(new)
    moved[0] += 0.1 * (new[0] - old[0])
    return moved
