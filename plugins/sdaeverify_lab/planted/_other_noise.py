"""Schemes whose steps receive changed noise in place of the drawn noise."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from sdaeverify import Array, Increment, Problem, Scheme, Step


def first(rows: Array) -> Array:
    """Return an array with all rows replaced by the first one."""
    return np.repeat(rows[:1], len(rows), axis=0)


# Changes of dW and H in a step of size h.
CHANGES: Mapping[str, Callable[[Array, float], Array]] = MappingProxyType({
    "none": lambda rows, h: 0.0 * rows,
    "of size h": lambda rows, h: np.sqrt(h) * rows,
    "clipped": lambda rows, h: np.clip(rows, -np.sqrt(h), np.sqrt(h)),
    "swapped": lambda rows, h: rows[::-1],
    "first": lambda rows, h: first(rows),
    "0.9": lambda rows, h: 0.9 * rows,
    "doubled": lambda rows, h: 2.0 * rows,
    "negative": lambda rows, h: -rows,
    "variance + 1 %": lambda rows, h: np.sqrt(1.01) * rows,
})  # fmt: skip


@dataclass(frozen=True)
class OtherNoise(Scheme):
    """Mixin that changes dW and H before it passes them to the step of the scheme.

    Attributes
    ----------
    dW, H : str
        Changes of dW and H, keys of `CHANGES`; empty for no change.
    """

    dW: str = ""
    H: str = ""

    def step(self, problem: Problem, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step of the scheme with the changed increment."""
        wrong = {name: CHANGES[how] for name, how in (("dW", self.dW), ("H", self.H)) if how}
        changed = {name: change(getattr(noise, name), h) for name, change in wrong.items()}
        return super().step(problem, state, t, h, noise._replace(**changed))
