"""Invariant laws of a modified equation: the sampled potential, temperatures and variances.

Overdamped dynamics dx = -grad V dt + sqrt(2 kT) dW have the density rho = exp(-V/kT)/Z, and the modified equation has
rho (1 + h^p g) with L g = -q, where int L_p u rho = int u q rho (Abdulle, Vilmart & Zygalakis 2014). If g is a sum of
products of derivatives of V, the scheme samples V - kT h^p g to leading order.

Langevin dynamics satisfy <L_p u> + <L u>_p = 0 for the change <.>_p of means. For the energy u, L u is
gamma (d kT - |p|^2), so that the change of the kinetic temperature follows from means with respect to the exact law.
Up to p = 2 these are, by integration by parts, multiples of the mean of the Laplacian of U and of powers of gamma,
which a harmonic potential determines (Leimkuhler & Matthews 2013).
"""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from sdaeverify import Array

from ..grow import DRIFT, Tree
from ..stationary import Polynomial, by_parts
from .equation import ModifiedEquation
from .numbers import number_words

# By order p: products with 2 p derivatives of V, and the contraction of their indices.
INVARIANTS = {
    1: (("|grad V|^2", ("i", "i")), ("lap V", ("ii",))),
    2: (
        ("|grad V|^4", ("i", "i", "j", "j")),
        ("|grad V|^2 lap V", ("i", "i", "jj")),
        ("V''[grad V, grad V]", ("i", "j", "ij")),
        ("(lap V)^2", ("ii", "jj")),
        ("|V''|^2", ("ij", "ij")),
        ("grad V . grad lap V", ("i", "ijj")),
        ("lap^2 V", ("iijj",)),
    ),
}
# Factor of the error 1e-8 of weights, above which a discrepancy means that no formula exists.
SURE = 100.0
# Stiffnesses and frictions for the fit, and the largest order at which a harmonic potential gives the temperature.
PLACES, GENERAL = [*product((0.5, 0.8, 1.3), (0.6, 1.0, 1.7))], 2


def law_lines(of: ModifiedEquation) -> Iterator[str]:
    """Yield lines on the invariant law of a modified equation."""
    h = "h" if of.order == 1.0 else f"h^{of.order:g}"
    if of.kind == "overdamped-gradient":
        yield f"sampled potential  {_potential_words(of, h)}"
    if of.kind.startswith("langevin") and of.order >= 1.0 and float(of.order).is_integer():
        momentum, position = harmonic_variances(of)
        if momentum is not None and position is not None:
            yield from _variance_lines(of, momentum, position)


def _potential_words(of: ModifiedEquation, h: str) -> str:
    found = sampled_potential(of)
    if found is None:
        return "has no formula in derivatives of V"
    parts = [f"{number_words(c, _error(of))}{' kT' * bool(power)}{_power(power)} {name}" for name, power, c in found]
    return f"V + {h} ({_joined(parts)})" if parts else f"V, to {h}"


def _power(power: int) -> str:
    return f"^{power}" if power > 1 else ""


def _joined(parts: Sequence[str]) -> str:
    first, *rest = parts
    return first + "".join(f" - {part[1:]}" if part.startswith("-") else f" + {part}" for part in rest)


def _error(of: ModifiedEquation) -> float:
    return SURE * max(each.error for each in of.terms)


def sampled_potential(of: ModifiedEquation) -> list[tuple[str, int, float]] | None:
    """Return the terms (name, power of kT, coefficient) of h^p in the sampled potential; None without a formula.

    Parameters
    ----------
    of : ModifiedEquation
        Modified equation for the class overdamped-gradient.
    """
    d, p = of.motions, int(of.order)
    if p != of.order or p not in INVARIANTS or d < 2:
        return None
    wanted: dict[tuple[tuple[int, ...], ...], float] = {}
    for each in of.terms:
        for monomial, c in by_parts(each.forest, d).items():
            wanted[monomial] = wanted.get(monomial, 0.0) - each.value * c
    images = [_generated(_contracted(factors, d), d) for _, factors in INVARIANTS[p]]
    rows = {
        monomial: row for row, monomial in enumerate(dict.fromkeys((*wanted, *(m for each in images for m in each))))
    }
    matrix, right = np.zeros((len(rows), len(images))), np.zeros(len(rows))
    for column, image in enumerate(images):
        for monomial, c in image.items():
            matrix[rows[monomial], column] = c
    for monomial, value in wanted.items():
        right[rows[monomial]] = value
    g = np.linalg.lstsq(matrix, right, rcond=None)[0]
    if np.max(np.abs(matrix @ g - right)) > _error(of):
        return None
    told = [
        (name, p + 1 - len(factors), -float(c) * (-1.0) ** len(factors))
        for (name, factors), c in zip(INVARIANTS[p], g, strict=True)
    ]
    return [each for each in told if abs(each[2]) > _error(of)]


def _contracted(factors: Sequence[str], d: int) -> Polynomial:
    """Return a product of derivatives of phi in coordinates, contracted over repeated letters."""
    letters = sorted(set("".join(factors)))
    total: Polynomial = {}
    for values in product(range(1, d + 1), repeat=len(letters)):
        place = dict(zip(letters, values, strict=True))
        monomial = tuple(sorted(tuple(sorted(place[letter] for letter in factor)) for factor in factors))
        total[monomial] = total.get(monomial, 0) + 1
    return total


def _generated(g: Polynomial, d: int) -> Polynomial:
    """Return L g = sum of d_i d_i g + d_i phi d_i g."""
    total: Polynomial = {}
    for i in range(1, d + 1):
        first = _derived(g, i)
        for monomial, c in _derived(first, i).items():
            total[monomial] = total.get(monomial, 0) + c
        for monomial, c in first.items():
            moved = tuple(sorted((*monomial, (i,))))
            total[moved] = total.get(moved, 0) + c
    return total


def _derived(g: Polynomial, i: int) -> Polynomial:
    total: Polynomial = {}
    for monomial, c in g.items():
        for place, factor in enumerate(monomial):
            further = tuple(sorted((*factor, i)))
            key = tuple(sorted((*monomial[:place], further, *monomial[place + 1 :])))
            total[key] = total.get(key, 0) + c
    return total


def harmonic_variances(of: ModifiedEquation) -> tuple[dict[tuple[int, int], float] | None, ...]:
    """Return the h^p changes of <p^2>/kT and k <q^2>/kT for the potential k q^2/2, by powers (of k, of gamma).

    Parameters
    ----------
    of : ModifiedEquation
        Modified equation of Langevin dynamics.

    Returns
    -------
    tuple of dict or None
        Changes of the momentum and of the position; None if a change is not such a polynomial.
    """
    changes = np.array([_change(of, k, gamma) for k, gamma in PLACES])
    p = int(of.order)
    powers = [(i, p - 2 * i) for i in range(p // 2 + 1)]
    matrix = np.array([[k**i * gamma**j for i, j in powers] for k, gamma in PLACES])
    return tuple(_fitted(powers, matrix, column, _error(of)) for column in changes.T)


def _fitted(
    powers: Sequence[tuple[int, int]], matrix: Array, values: Array, error: float
) -> dict[tuple[int, int], float] | None:
    found = np.linalg.lstsq(matrix, values, rcond=None)[0]
    if np.max(np.abs(matrix @ found - values)) > error:
        return None
    return {power: float(c) for power, c in zip(powers, found, strict=True) if abs(c) > error}


def _change(of: ModifiedEquation, k: float, gamma: float) -> tuple[float, float]:
    """Return the changes of <p^2> and k <q^2>, with kT = 1, for a stiffness and a friction."""

    def mean(S: Array) -> float:
        return sum(each.value * _mean_of_term(each.forest, S, k, gamma) for each in of.terms)

    of_q, of_p, of_both = (mean(np.array(S)) for S in (((1, 0), (0, 0)), ((0, 0), (0, 1)), ((0, 1), (1, 0))))
    mixed = -of_q
    momentum = (of_p - k * mixed) / gamma
    return momentum, momentum - gamma * mixed + of_both


def _mean_of_term(forest: Sequence[Tree], S: Array, k: float, gamma: float) -> float:
    """Return the mean of a derivative of u = z^T S z/2 with z = (q, p); third derivatives vanish."""
    moments = np.diag([1.0 / k, 1.0, 1.0])
    if len(forest) > 2:
        return 0.0
    rows = [_linear(each, k, gamma) for each in forest]
    if len(forest) == 1:
        rows.insert(0, np.eye(2, 3))
    return float(np.einsum("ai,ij,bj,ab->", rows[0], moments, rows[1], S))


def _linear(of: Tree, k: float, gamma: float) -> Array:
    """Return F(tau) for a harmonic potential as a matrix on (q, p, 1), shape (2, 3)."""
    found = np.zeros((2, 3))
    found[0 if of.name == "q" else 1] = _row(of, k, gamma)
    return found


def _row(of: Tree, k: float, gamma: float) -> Array:
    if of.colour > DRIFT:
        # One degree of freedom has one motion.
        return np.array([0.0, 0.0, (2.0 * gamma) ** 0.5 * (of.colour == 1)])
    if of.name == "p":
        return np.array([0.0, 1.0, 0.0])
    if of.name == "f" and len(of.kids) != 1:
        return np.array([0.0 if of.kids else -k, 0.0, 0.0])
    factor = {"q": 1.0, "d": -gamma, "f": -k}[of.name]
    return np.asarray(factor * _row(of.kids[0], k, gamma))


def _variance_lines(
    of: ModifiedEquation, momentum: dict[tuple[int, int], float], position: dict[tuple[int, int], float]
) -> Iterator[str]:
    h, error = f"h^{of.order:g}" if of.order > 1.0 else "h", _error(of)
    if of.order <= GENERAL:
        yield f"kinetic temperature  {_variance(momentum, h, '<lap U>/d', error)}"
    yield f"U = k q^2/2: <p^2> = {_variance(momentum, h, 'k', error)}, k <q^2> = {_variance(position, h, 'k', error)}"


def _variance(change: dict[tuple[int, int], float], h: str, stiffness: str, error: float) -> str:
    parts = [
        " ".join(filter(None, (number_words(c, error), _named(stiffness, i), _named("gamma", j))))
        for (i, j), c in change.items()
    ]
    return f"kT (1 + {h} ({_joined(parts)}))" if parts else f"kT, to {h}"


def _named(name: str, power: int) -> str:
    return "" if not power else name if power == 1 else f"{name}^{power}"
