"""Mistakes with unknown numbers, which are fitted to the rates of short steps.

Each family returns the mistake with the numbers that fit best; whether it explains the rates is decided as for
mistakes without numbers.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import permutations

import numpy as np
import scipy

from ...arrays import Array
from .given_rates import DEFECT, RESOLUTION, Given, Mistake, Rates, squares

# Words: multiples of time and state among which the search for the best one begins, and its accuracy; near the
# minimum of a sum of squares it is about the root of eps.
MULTIPLES, ACCURACY = np.linspace(-3.0, 3.0, 25), 1e-9
CHANGES = {
    "the drift is": ("drift",),
    "the diffusion is": ("diffusion",),
    "the coefficients are": ("drift", "diffusion"),
}
# Size: number of components, all of whose orders are tested.
MOST = 4
# Words: part of the largest singular value below which columns count as dependent.
DEPENDENT = 1e-3

Pairs = Sequence[tuple[Given, Rates]]


def fitted_mistakes(pairs: Pairs) -> Iterator[Mistake]:
    """Yield the mistakes with fitted numbers.

    Parameters
    ----------
    pairs : sequence of (Given, Rates)
        The equation at some points, and the rates of short steps there.
    """
    beside = np.concatenate([rates.f - given.drift() for given, rates in pairs], axis=1)
    if np.abs(beside).max() > 0.0:
        yield from _further_drifts(pairs, beside)
    yield from _at_multiples(pairs)
    yield from _in_another_order(len(beside))


def _further_drifts(pairs: Pairs, beside: Array) -> Iterator[Mistake]:
    """Yield further drifts B v, c x and v with the constants that fit best."""
    B = np.concatenate([given.diffusion() for given, _ in pairs], axis=2)
    v = fitted(np.moveaxis(B, 2, 0).reshape(-1, B.shape[1]), beside.T.reshape(-1, 1))
    if v is not None:
        means = f"the increments have a mean of size h: dW + {_times(vector_text(v[:, 0]), 'h')}"
        yield _further(
            lambda each: np.einsum("ijn,j->in", each.diffusion(), v[:, 0]), f"{means} is used in place of dW"
        )
    x = np.concatenate([given.x for given, _ in pairs], axis=1)
    c = float(x.ravel() @ beside.ravel()) / max(float(x.ravel() @ x.ravel()), np.finfo(float).tiny)
    yield _further(lambda each: c * each.x, f"there is a further drift {_times(number_text(c), 'x')}")
    a = beside.mean(axis=1)
    yield _further(
        lambda each: np.broadcast_to(a[:, None], each.x.shape), f"there is a further drift {vector_text(a)}"
    )


def _further(drift: Callable[[Given], Array], sentence: str) -> Mistake:
    return Mistake(lambda each: each.drift() + drift(each), None, sentence)


def fitted(columns: Array, right: Array) -> Array | None:
    """Return the least squares solution, or None if the columns are dependent.

    Parameters
    ----------
    columns : ndarray, shape (n, l)
    right : ndarray, shape (n, k)
    """
    if not (np.isfinite(columns).all() and np.isfinite(right).all()):
        return None
    found, _, _, sizes = np.linalg.lstsq(columns, right, rcond=None)
    return np.asarray(found) if sizes.min() > DEPENDENT * sizes.max() else None


def _at_multiples(pairs: Pairs) -> Iterator[Mistake]:
    """Yield coefficients at the multiples of time or state that fit best."""
    for what, parts in CHANGES.items():
        for name in ("t", "x"):
            c = _best_multiple(pairs, name, parts)
            if min(abs(c), abs(c - 1.0)) > DEFECT:
                drift, noise = (_at(part, name, c) if part in parts else None for part in ("drift", "diffusion"))
                where = f"evaluated at {_times(number_text(c), name)} in place of {name}"
                yield Mistake(drift, noise, f"{what} {where}")


def _at(part: str, name: str, c: float) -> Callable[[Given], Array]:
    """Return a coefficient at another multiple of time or state."""

    def changed(given: Given) -> Array:
        at: Array = getattr(given, part)(**{name: c * getattr(given, name)})
        return at

    return changed


def _best_multiple(pairs: Pairs, name: str, parts: Sequence[str]) -> float:
    """Return the multiple at which coefficients are nearest to the measured rates in mean square."""

    def distance(c: float) -> float:
        total = 0.0
        for part in parts:
            changed = _at(part, name, c)
            for given, rates in pairs:
                value = changed(given)
                off = value - rates.f if part == "drift" else squares(value) - rates.Q
                total += float((off**2).sum())
        return total if np.isfinite(total) else np.inf

    # Coefficients may be even functions, and times are positive.
    among = MULTIPLES[MULTIPLES >= 0.0] if name == "t" else MULTIPLES
    first, width = min(among.tolist(), key=distance), float(MULTIPLES[1] - MULTIPLES[0])
    found = scipy.optimize.minimize_scalar(
        distance, bounds=(first - width, first + width), method="bounded", options={"xatol": ACCURACY}
    )
    return float(found.x)


def _in_another_order(d: int) -> Iterator[Mistake]:
    """Yield drifts whose arguments or components are in another order."""
    for order in orders(d):
        words = f"in the order {order_text(order)}"
        yield Mistake(
            lambda each, order=order: each.drift(x=each.x[order]),  # type: ignore[misc]
            None,
            f"the drift is evaluated at the components of the state {words}",
        )
        yield Mistake(
            lambda each, order=order: each.drift()[order],  # type: ignore[misc]
            None,
            f"the components of the drift are {words}",
        )


def orders(d: int) -> list[list[int]]:
    """Return the orders of d components other than 0, 1, ...: all for few components, else reversed and by halves."""
    usual = list(range(d))
    some = map(list, permutations(usual)) if d <= MOST else [usual[::-1], usual[d // 2 :] + usual[: d // 2]]
    return [each for each in some if each != usual]


def order_text(order: Sequence[int]) -> str:
    """Return an order of components, counted from 1."""
    return ", ".join(str(each + 1) for each in order)


def number_text(value: float) -> str:
    """Return a number with four digits."""
    return f"{value + 0.0:.4g}"


def vector_text(v: Array) -> str:
    """Return a vector, or its number if all components are equal."""
    same = np.abs(v - v[0]).max() <= DEFECT * np.abs(v).max()
    return number_text(float(v[0])) if same else f"[{', '.join(map(number_text, v.tolist()))}]"


def factor_text(what: str, factor: float) -> str:
    """Return that something is multiplied by a factor, or an empty string for the factor 1.

    Parameters
    ----------
    what : str
    factor : float
    """
    named = {0.0: "is left out", -1.0: "has the wrong sign", 0.5: "is halved", 2.0: "is doubled"}
    for value, words in named.items():
        if abs(factor - value) <= RESOLUTION:
            return f"{what} {words}"
    return "" if abs(factor - 1.0) <= DEFECT else f"{what} is multiplied by {factor:.4g}"


def _times(number: str, what: str) -> str:
    return {"1": what, "-1": f"-{what}"}.get(number, f"{number} {what}")
