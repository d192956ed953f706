"""Delay and index-1 equations that every scheme solves exactly: rest, motion along a line, and noise.

x moves at a constant velocity or by noise alone, and y follows it: 0 = K (y - x - s t), with x(t - tau) in place of x
if the motion is deterministic. The matrix K is full and the equation depends on time. Further terms of the
coefficients vanish on the solution: a step that evaluates them at a wrong lagged value or a wrong y has an error
proportional to them.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, Parts
from ...noise.brownian import BROWNIAN
from ..trivial import NOISES, RATE, SHORTER, SOURCE, WIDE, WIDE_NOISE, WIDE_RATE, H, Trivial, Trivials

# Delays, in steps: between mesh points, on a mesh point, shorter than a step, and none.
DELAYS = (2.7, 2.0, 0.3, 0.0)
# A delay that does not shrink with the step, so that a lagged value in the drift matters; and the factor of the
# steps.
LONG, LESS_SHORT = 10.7 * H, 2.0**-10
# Coefficients of terms that vanish on the solution; unequal, so that errors of a lagged value in both do not cancel.
PULL, TIE = 0.8, 0.5
START, SLOPE = np.array([1.0, -0.5, 0.7, 0.2, -0.9, 0.4]), np.array([0.3, 0.7, -0.6, 0.5, 0.2, -0.4])
# du/dy, neither diagonal nor symmetric.
MATRIX = np.eye(WIDE) + 0.3 * WIDE_NOISE


class Path(NamedTuple):
    """A motion and the noise that drives it.

    Attributes
    ----------
    c : ndarray, shape (d,)
        Velocity; 0 if there is noise.
    S : ndarray, shape (d, l)
    algebraic : bool
        Whether there is a y.
    """

    c: Array
    S: Array
    algebraic: bool

    @property
    def start(self) -> Array:
        """Initial value of x, shape (d,)."""
        return START[: len(self.c)]

    @property
    def slope(self) -> Array:
        """The vector s, shape (d, 1)."""
        return SLOPE[: len(self.c), None]

    @property
    def matrix(self) -> Array:
        """The matrix K, shape (d, d)."""
        return MATRIX[: len(self.c), : len(self.c)]

    @property
    def follows(self) -> bool:
        """Whether y follows the lagged x; with noise it follows x itself."""
        return not self.S.any()

    def name(self, lagged: str) -> str:
        """Return the equation as text, given the text of the lagged value of x in the form."""
        equation = "dx = S dW" if self.S.any() else "dx = c dt" if self.c.any() else "dx = 0"
        return equation + (f", y = {lagged if self.follows else 'x'} + s t" if self.algebraic else "")


def trivial_delays(form: Callable[..., Any]) -> Trivials:
    """Return the problems dx = 0, dx = c dt and dx = S dW with lagged values of every kind.

    Parameters
    ----------
    form : callable
        Constructor of the problem: `DelaySDAE`.
    """
    on_few_steps = [
        tuple(_two_sizes(form, steps, path) for path in paths) for steps in DELAYS for paths in _equations()
    ]
    long = (_delayed(form, LONG, path) for path in _equations()[1])
    return *on_few_steps, tuple(trivial._replace(shorter=LESS_SHORT) for trivial in long)


def trivial_index_one(form: Callable[..., Any]) -> Trivials:
    """Return the problems dx = 0, dx = c dt and dx = S dW without lagged values.

    Parameters
    ----------
    form : callable
        Constructor of the problem: `IndexOneSDAE`.
    """
    return tuple(tuple(_undelayed(form, path) for path in paths) for paths in _equations())


def _equations() -> tuple[tuple[Path, ...], ...]:
    """Return the variants of each equation: full noise, diagonal noise and one motion, each with and without y.

    The last one has many components and motions.
    """
    moved = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
    small = tuple(
        tuple(Path(a * RATE, b * S, algebraic) for S in NOISES for algebraic in (True, False)) for a, b in moved
    )
    # A scheme that is made for few motions is tried with one.
    wide = tuple(
        Path(0.0 * WIDE_RATE[: len(S)], S, algebraic) for S in (WIDE_NOISE, NOISES[-1]) for algebraic in (True, False)
    )
    return *small, wide


def _two_sizes(form: Callable[..., Any], steps: float, path: Path) -> Trivial:
    coarse, fine = (_delayed(form, steps * h, path) for h in (H, H * SHORTER))
    return coarse._replace(finer=fine)


def _delayed(form: Callable[..., Any], tau: float, path: Path) -> Trivial:
    c, S, follows = path.c, path.S[..., None], path.follows

    def behind(x: Array, v: Array) -> Array:
        return np.asarray(v - x + tau * c[:, None]) if follows else 0.0 * x

    def unmet(t: float, x: Array, v: Array, y: Array) -> Array:
        return np.asarray(y - (v if follows else x) - t * path.slope)

    def drift(t: float, x: Array, v: Array, y: Array) -> Array:
        tie = unmet(t, x, v, y) if path.algebraic else 0.0
        return np.asarray(c[:, None] + PULL * behind(x, v) + TIE * tie)

    problem = form(
        drift=drift,
        diffusion=lambda _t, x, v, _y: S + PULL * behind(x, v)[:, None],
        delay=tau,
        history=lambda t: path.start + t * c,
        **_constraint(path, lambda *at: np.tensordot(path.matrix, unmet(*at), 1), path.start - tau * c),
        **_shared(path),
    )
    return Trivial(path.name("x(t - tau)"), problem, _solution(path, tau))


def _undelayed(form: Callable[..., Any], path: Path) -> Trivial:
    def unmet(t: float, x: Array, y: Array) -> Array:
        return np.asarray(y - x - t * path.slope)

    problem = form(
        drift=lambda t, x, y: path.c[:, None] + (TIE * unmet(t, x, y) if path.algebraic else 0.0 * x),
        diffusion=lambda _t, x, _y: path.S[..., None] + 0.0 * x[:1, None],
        start=path.start,
        **_constraint(path, lambda *at: np.tensordot(path.matrix, unmet(*at), 1), path.start),
        **_shared(path),
    )
    return Trivial(path.name("x"), problem, _solution(path, 0.0))


def _constraint(path: Path, u: Callable[..., Array], y: Array) -> dict[str, Any]:
    return {"constraint": u, "algebraic": y} if path.algebraic else {}


def _shared(path: Path) -> dict[str, Any]:
    return {
        "noise_dim": path.S.shape[1],
        "noise": frozenset(BROWNIAN),
        "horizon": 1.0,
        "traits": frozenset() if path.follows else frozenset({"additive-noise"}),
        "source": SOURCE,
    }


def _solution(path: Path, tau: float) -> Callable[[float, Array], Parts]:
    c = path.c[:, None]

    def solution(t: float, W: Array) -> Parts:
        x = path.start[:, None] + t * c + path.S @ W
        return {"x": x, "y": x - tau * c + t * path.slope} if path.algebraic else {"x": x}

    return solution
