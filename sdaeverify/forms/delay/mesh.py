"""A mesh against a delay, tau = (m - delta) h, and the lagged values of a run: Qu, Huang & Liu (2010), (2.11)."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...noise.brownian import Increment
from .partials import Partials

# A delay is a whole number of steps if it is one to so many parts of itself: T/N and tau are both rounded.
WHOLE = 1e-11


class Lag(NamedTuple):
    """x at the lag of a step's begin and end, the latter as far as it is known before the step is made.

    Attributes
    ----------
    now : ndarray, shape (d, P)
        xb_n, the value at t_n - tau.
    known : ndarray, shape (d, P)
        xb_{n+1} - weight x_{n+1}.
    weight : float
        delta where the delay is shorter than a step (m = 1), 1 without delay, else 0.
    """

    now: Array
    known: Array
    weight: float

    def ahead(self, x: Array) -> Array:
        """Return xb_{n+1} where x_{n+1} is x."""
        return self.known + self.weight * x if self.weight else self.known

    def total(self, change: Partials) -> Array:
        """Return the derivative by x_{n+1} of a function at the step's end, at which xb_{n+1} may depend on it."""
        return change.x + self.weight * change.v if self.weight else change.x


class Mesh(NamedTuple):
    """How a delay lies on steps of one length.

    Attributes
    ----------
    m : int
        Steps that a delay reaches back, counted up; 0 without delay.
    delta : float
        m - tau/h, between 0 and 1: 0 on a constrained mesh.
    """

    m: int
    delta: float

    @classmethod
    def of(cls, delay: float, h: float) -> "Mesh":
        """Return the mesh of steps of size h."""
        ratio = delay / h
        if abs(ratio - round(ratio)) <= WHOLE * ratio:
            return cls(round(ratio), 0.0)
        m = int(np.ceil(ratio))
        return cls(m, m - ratio)

    @property
    def weight(self) -> float:
        """Weight of x_{n+1} in xb_{n+1}."""
        return 1.0 if not self.m else self.delta if self.m == 1 else 0.0


class Recall:
    """The lagged values of a run: m + 2 states a path at most, whatever its length.

    x_n for n >= 0 is what was pushed; left of 0 the history takes its place, without interpolation: 0 is a mesh
    point.

    Parameters
    ----------
    mesh : Mesh
    h : float
    delay : float
    history : callable, t -> ndarray, shape (d, 1)
    start : ndarray, shape (d, P)
        x_0.
    """

    def __init__(self, mesh: Mesh, h: float, delay: float, history: Callable[[float], Array], start: Array) -> None:
        self.mesh, self.h, self.delay, self.history = mesh, h, delay, history
        self.ring = np.zeros((mesh.m + 1, *start.shape))
        self.step = -1
        self.push(start)

    def push(self, x: Array) -> None:
        """Note x_{n+1}, after which n grows by 1."""
        self.step += 1
        self.ring[self.step % len(self.ring)] = x

    def add_past(self, noise: Increment) -> Increment:
        """Return the noise of the next step with the lagged values of its begin and, as far as known, of its end."""
        return noise._replace(lagged=self.lagged(), ahead=self._lagged_value(self.step + 1, known=True))

    def lagged(self) -> Array:
        """Return xb_n, the value at t_n - tau."""
        return self._lagged_value(self.step, known=False)

    def _lagged_value(self, n: int, *, known: bool) -> Array:
        m, delta = self.mesh
        if n <= m - delta:
            return np.broadcast_to(self.history(min(0.0, n * self.h - self.delay)), self.ring.shape[1:])
        old = self._look_up(n - m)
        if not delta:
            return old
        # With m = 1 the newer point of xb_{n+1} is the unknown itself.
        share = (1.0 - delta) * old
        return share if known and m == 1 else share + delta * self._look_up(n - m + 1)

    def _look_up(self, n: int) -> Array:
        value: Array = self.ring[n % len(self.ring)].copy()
        value.flags.writeable = False
        return value
