"""Position of a delay on a mesh, tau = (m - delta) h, and lagged values of a run: Qu, Huang & Liu (2010), (2.11)."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...noise.brownian import Increment
from .partials import Partials

# Relative tolerance for a delay to be a whole number of steps, because both T/N and tau are rounded.
WHOLE = 1e-11


class Lag(NamedTuple):
    """Lagged x at the beginning and the end of a step; at the end, the part known before the step is made.

    Attributes
    ----------
    now : ndarray, shape (d, P)
        xb_n, the value at t_n - tau.
    known : ndarray, shape (d, P)
        xb_{n+1} - weight x_{n+1}.
    weight : float
        delta if the delay is shorter than a step (m = 1), 1 without delay, else 0.
    """

    now: Array
    known: Array
    weight: float

    def ahead(self, x: Array) -> Array:
        """Return xb_{n+1} for x_{n+1} = x."""
        return self.known + self.weight * x if self.weight else self.known

    def total(self, change: Partials) -> Array:
        """Return the total derivative by x_{n+1} of a function at the step's end; xb_{n+1} may depend on x_{n+1}."""
        return change.x + self.weight * change.v if self.weight else change.x


class Mesh(NamedTuple):
    """Position of a delay on a grid of constant step size.

    Attributes
    ----------
    m : int
        Number of steps that the delay spans, rounded up; 0 without delay.
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
    """The lagged values of a run; stores m + 1 states per path, independent of the length of the run.

    x_n for n >= 0 are the pushed states. Before time 0 the history is evaluated without interpolation, because 0 is a
    mesh point.

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
        """Store x_{n+1} and increase n by 1."""
        self.step += 1
        self.ring[self.step % len(self.ring)] = x

    def add_past(self, noise: Increment) -> Increment:
        """Return the noise of the next step with the lagged values of its beginning and, if known, of its end."""
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
        # With m = 1 the newer point of xb_{n+1} is the unknown x_{n+1}.
        share = (1.0 - delta) * old
        return share if known and m == 1 else share + delta * self._look_up(n - m + 1)

    def _look_up(self, n: int) -> Array:
        value: Array = self.ring[n % len(self.ring)].copy()
        value.flags.writeable = False
        return value
