"""Identification of the noise that a wrong step uses, from its moves at the nodes of a rule.

With s = sqrt(h) and the noise s xi a step from x moves by

    Phi(x; xi) - x = J(x) + s a(x; xi) + O(h),    where J and a do not depend on the noise,
                                                  E (Phi(x; xi) - x) = J + s E a + h m(x) + O(h^(3/2)).

A right step has J = 0, a = B(x) xi and m = f(x). If a = B(x) w with the same w for all x and m = f, the step uses the
increments s w in place of dW, and nothing else is wrong to this order. The values of w at the nodes
show which function of the noise it is: a matrix times dW, another part of the noise, the modulus of dW.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ..step.nodes import Nodes
from ..step.one_step import OneStep
from .fitted_mistakes import fitted, number_text, order_text, orders
from .given_rates import RESOLUTION, Given, near

# Words: largest step size in units of time, and number of sizes with the ratio 4. The coefficients are those of the
# polynomial in s through all sizes. Their errors are 2^-35, 2^-25 and 2^-17 times the coefficient of s^5, the
# elementary symmetric polynomials of degree 5, 4 and 3 of 2^-5, ..., 2^-9; its mean is 0 for polynomials of dW.
SIZE, LEVELS = 2.0**-10, 5


class Function(NamedTuple):
    """A function of a standard normal variable, with its mean and its mean square, which rules have inexactly."""

    of: Callable[[Array], Array]
    mean: float
    square: float


# Theorem: elementary, E |xi| = sqrt(2/pi) and E xi^6 = 15.
FUNCTIONS = {
    "|dW|": Function(np.abs, sqrt(2.0 / pi), 1.0),
    "dW^2/sqrt(h)": Function(np.square, 1.0, 3.0),
    "(dW^2 - h)/sqrt(h)": Function(lambda xi: xi**2 - 1.0, 0.0, 2.0),
    "sqrt(h) sign(dW)": Function(np.sign, 0.0, 1.0),
    "dW^3/h": Function(lambda xi: xi**3, 0.0, 15.0),
}
IN_PLACE = "in place of dW"
MEAN = "the increments have a mean of size sqrt(h)"
LEFT_OUT = "the state is left out: a step returns its move alone"
ADDED = "the drift is added without the step size"
ROOT = "the drift is multiplied by sqrt(h) where h is meant"
NONLINEAR = f"a nonlinear function of the noise is used {IN_PLACE}"


@dataclass(frozen=True, eq=False)
class Moves:
    """Coefficients of the moves of short steps at points and nodes.

    Attributes
    ----------
    given : sequence of Given
        The equation at the points, n of them in all.
    nodes : Nodes
    jump, first : ndarray, shape (d, K, n)
        J and a.
    mean : ndarray, shape (d, n)
        m.
    """

    given: Sequence[Given]
    nodes: Nodes
    jump: Array
    first: Array
    mean: Array

    def joined(self, of: Callable[[Given], Array]) -> Array:
        """Return a function of the equation at all points, shape (..., n)."""
        return np.concatenate([np.asarray(of(each)) for each in self.given], axis=-1)

    def is_step(self, drift: Callable[[Given], Array], noise: Callable[[Given], Array]) -> bool:
        """Return whether a and m are those of a step with the noise a, shape (d, K, n), and the drift m."""
        return self.has_first(self.joined(noise)) and self.has_mean(self.joined(drift))

    def has_first(self, a: Array) -> bool:
        """Return whether a is given, relative to that of a right step."""
        return near(self.first, a, RESOLUTION, self.joined(self.noise_of))

    def has_mean(self, m: Array) -> bool:
        """Return whether m is given, relative to that of a right step."""
        return near(self.mean, m, RESOLUTION, self.joined(Given.drift))

    def noise_of(self, given: Given, x: Array | None = None) -> Array:
        """Return B xi at the nodes, shape (d, K, n), by default at the points."""
        return np.asarray(np.einsum("ijn,jk->ikn", given.diffusion(x=x), self.nodes.dW))

    @property
    def jumps(self) -> bool:
        """Whether a step of size 0 would change the state."""
        size = sum(np.abs(self.joined(part)).max() for part in (lambda each: each.x, Given.drift, self.noise_of))
        return bool(np.abs(self.jump).max() > RESOLUTION * size)

    @property
    def increments(self) -> Array | None:
        """The w of a = B w at the nodes, shape (l, K); None if it is not the same for all x."""
        B = self.joined(Given.diffusion)
        d, l, n = B.shape
        columns = np.moveaxis(B, 2, 0).reshape(-1, l)
        w = fitted(columns, np.moveaxis(self.first, 2, 0).reshape(n * d, -1)) if np.any(B) else None
        return w if w is not None and self.has_first(np.einsum("ijn,jk->ikn", B, w)) else None


def moves_at(step: OneStep, given: Given, nodes: Nodes, h: float) -> Array:
    """Return the displacements of a step at points and nodes, shape (d, n, K).

    Parameters
    ----------
    step : OneStep
    given : Given
        The n points.
    nodes : Nodes
    h : float
        Size of the step.
    """
    wide = np.repeat(given.x, len(nodes.weights), axis=1)
    made = step.make(wide.copy(), given.t, h, nodes.increment(h, given.x.shape[1]))
    return np.asarray((step.read(made.state) - wide).reshape(*given.x.shape, -1))


def moves_of(step: OneStep, given: Sequence[Given], nodes: Nodes) -> Moves:
    """Return the coefficients of the moves of short steps.

    Parameters
    ----------
    step : OneStep
    given : sequence of Given
        The equation at a few times.
    nodes : Nodes
    """
    s = np.sqrt(SIZE * step.time_unit) * 2.0 ** -np.arange(LEVELS)
    by_size = [np.concatenate([moves_at(step, each, nodes, float(r) ** 2) for each in given], axis=1) for r in s]
    J, a, m = np.tensordot(np.linalg.inv(np.vander(s, increasing=True))[:3], np.stack(by_size), axes=1)
    return Moves(given, nodes, np.moveaxis(J, 1, 2), np.moveaxis(a, 1, 2), m @ nodes.weights)


def used_noise(moves: Moves, *, paths: bool) -> str:
    """Return a sentence on the moves of order 0 and 1/2 of a step, or an empty string.

    Parameters
    ----------
    moves : Moves
    paths : bool
        Whether noise that is not dW but has its law is a mistake.
    """
    if moves.jumps:
        return _of_jump(moves)
    w = moves.increments
    if w is None or not moves.has_mean(moves.joined(Given.drift)):
        return _of_root(moves)
    return _of_increments(w, moves.nodes, paths=paths)


def _of_increments(w: Array, nodes: Nodes, *, paths: bool) -> str:
    """Return the sentence on increments w in place of xi, or an empty string if they are xi or may have its law."""
    if _is_zero(w - nodes.dW):
        return ""
    if (text := _linear_text(w, nodes)) is not None:
        return text if paths or not _has_law(w, nodes) else ""
    if len(found := _functions(w, nodes.dW)) == 1:
        return _function_text(*found.popitem(), paths=paths)
    # Rules do not have the moments of any function exactly, so that it may be right in law.
    return NONLINEAR if paths else ""


def _has_law(w: Array, nodes: Nodes) -> bool:
    """Return whether a w that is linear in the noise has the mean and the covariance of xi."""
    return _is_zero(w @ nodes.weights) and _is_zero((w * nodes.weights) @ w.T - np.eye(len(w)))


def _is_zero(a: Array) -> bool:
    return bool(np.abs(a).max() <= RESOLUTION)


def _multiple(w: Array, value: Array) -> float:
    return float((w * value).sum() / (value * value).sum())


def _is_multiple(w: Array, value: Array) -> bool:
    return _is_zero(w - _multiple(w, value) * value)


def _functions(w: Array, xi: Array) -> dict[str, float]:
    """Return the functions of xi of which w is a multiple, with the factors."""
    values = {text: function.of(xi) for text, function in FUNCTIONS.items()}
    return {text: _multiple(w, value) for text, value in values.items() if _is_multiple(w, value)}


def _function_text(text: str, c: float, *, paths: bool) -> str:
    """Return the sentence on a multiple of a function of xi, or an empty string if it has the law of xi."""
    _, mean, square = FUNCTIONS[text]
    if not paths and mean == 0.0 and abs(c * c * square - 1.0) <= RESOLUTION:
        return ""
    factor = number_text(c)
    return f"{f'{MEAN}: ' if mean else ''}{text if factor == '1' else f'{factor} {text}'} is used {IN_PLACE}"


def _linear_text(w: Array, nodes: Nodes) -> str | None:
    """Return the sentence on a w that is linear in the noise, empty for a multiple of dW; None for another w."""
    every = {"dW": nodes.dW, "H": nodes.H, "K": nodes.K, "sqrt(h)": np.ones((1, w.shape[1]))}
    parts = {name: part for name, part in every.items() if part is not None}
    rows = np.concatenate([*parts.values()])
    found = fitted(rows.T, w.T)
    if found is None or not _is_zero(w - found.T @ rows):
        return None
    columns = np.split(found.T, np.cumsum([len(part) for part in parts.values()])[:-1], axis=1)
    factors = {name: M for name, M in zip(parts, columns, strict=True) if not _is_zero(M)}
    if factors.keys() <= {"dW"}:
        return _of_matrix(factors.get("dW", np.zeros((len(w), len(w)))))
    lead = f"{MEAN}: " if "sqrt(h)" in factors else ""
    return f"{lead}{_sum_text([(_factor_text(M), name) for name, M in factors.items()])} is used {IN_PLACE}"


def _of_matrix(M: Array) -> str:
    """Return the sentence on M dW in place of dW; empty for multiples of dW other than -dW, named elsewhere."""
    l = len(M)
    if _is_zero(M + np.eye(l)):
        return f"the noise has the wrong sign: -dW is used {IN_PLACE}"
    if _is_zero(M - M[0, 0] * np.eye(l)):
        return ""
    order = M.argmax(axis=1)
    if _is_zero(M - np.eye(l)[order]) and len({*order.tolist()}) == l:
        used = ", ".join(f"motion {j + 1} in place of {i + 1}" for i, j in enumerate(order.tolist()) if i != j)
        return f"the Brownian motions are exchanged: {used}"
    return f"the increments are mixed: M dW is used {IN_PLACE} with M = {_matrix_text(M)}"


def _factor_text(M: Array) -> str:
    c = float(M[0, 0])
    is_multiple = _is_zero(M - c * np.eye(len(M))) if M.shape[0] == M.shape[1] else _is_zero(M - c)
    return number_text(c) if is_multiple else _matrix_text(M)


def _matrix_text(M: Array) -> str:
    rows = (f"[{', '.join(map(number_text, row))}]" for row in np.where(np.abs(M) <= RESOLUTION, 0.0, M).tolist())
    return f"[{', '.join(rows)}]"


def _sum_text(terms: Sequence[tuple[str, str]]) -> str:
    """Return a sum of factors times names, such as dW - 12 K."""
    text = ""
    for factor, name in terms:
        sign, size = ("-", factor[1:]) if factor.startswith("-") else ("+", factor)
        lead = f" {sign} " if text else "-" * (sign == "-")
        text += f"{lead}{'' if size == '1' else f'{size} '}{name}"
    return text


def _of_root(moves: Moves) -> str:
    """Return that the drift is multiplied by sqrt(h), or an empty string."""
    f = moves.joined(Given.drift)
    noise = moves.joined(moves.noise_of)
    c = _multiple(moves.first - noise, np.broadcast_to(f[:, None], noise.shape)) if np.any(f) else 0.0
    if abs(c) <= RESOLUTION or not (moves.has_first(noise + c * f[:, None]) and _is_drift_multiple(moves)):
        return ""
    return ROOT if number_text(c) == "1" else f"{ROOT}, and by {number_text(c)}"


def _is_drift_multiple(moves: Moves) -> bool:
    f = moves.joined(Given.drift)
    return moves.has_mean(_multiple(moves.mean, f) * f)


def _of_jump(moves: Moves) -> str:
    """Return the sentence on a step that changes the state as h -> 0, or an empty string."""
    x, f, J = moves.joined(lambda each: each.x), moves.joined(Given.drift), moves.jump
    if not near(J, np.broadcast_to(J[:, :1], J.shape), RESOLUTION, x[:, None]):
        return ""
    J = J[:, 0]
    if near(J, -x, RESOLUTION, x) and moves.is_step(Given.drift, moves.noise_of):
        return LEFT_OUT
    c = _multiple(J, f) if np.any(f) else 0.0
    if near(J, c * f, RESOLUTION, x) and moves.has_first(moves.joined(moves.noise_of)) and _is_drift_multiple(moves):
        b = _multiple(moves.mean, f)
        terms = [(number_text(c), "f"), *([(number_text(b), "h f")] if abs(b) > RESOLUTION else [])]
        return f"{ADDED}: {_sum_text(terms)} in place of h f"
    return next(_in_other_orders(moves, x + J), "")


def _in_other_orders(moves: Moves, after: Array) -> Iterator[str]:
    """Yield that a step reads or returns the components of the state in another order."""
    x = moves.joined(lambda each: each.x)
    for order in orders(len(x)):
        if not near(after, x[order], RESOLUTION, x):
            continue
        text = f"in the order {order_text(order)}"
        if moves.is_step(
            lambda each, o=order: each.drift(x=each.x[o]),  # type: ignore[misc]
            lambda each, o=order: moves.noise_of(each, each.x[o]),  # type: ignore[misc]
        ):
            yield f"the components of the state are read {text}"
        if moves.is_step(
            lambda each, o=order: each.drift()[o],  # type: ignore[misc]
            lambda each, o=order: moves.noise_of(each)[o],  # type: ignore[misc]
        ):
            yield f"the components of the state are returned {text}"
