"""Errors of schemes against their own modified equations: ``python reports/modified/run.py``.

On equations with periodic coefficients, semigroups of schemes and of equations are matrices on trigonometric
polynomials (times polynomials of the momentum), exact to rounding. With the generator L and the terms h^p L_p of the
modified equation, the mean of u after the time T is

    P_h^(T/h) u = exp(T L) u + h^p int exp((T - s) L) L_p exp(s L) u ds + O(h^(p + 1/2)):

the error is predicted without a free constant, and what is left of it falls by one order more (by half an order
more for schemes with odd powers of sqrt(h)). Terms of third order, with which no modified SDE exists, are predicted,
too. Writes ``errors.csv``, a row for each scheme and equation, and ``errors.svg``.
"""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import scipy

from sdaeverify import Langevin, Scheme
from sdaeverify.arrays import Array
from sdaeverify.probing import Nodes, OneStep
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_schemes
from sdaeverify_orders.order_report import classes_of
from sdaeverify_orders.trees.grow import DRIFT, Tree
from sdaeverify_orders.trees.modified.equation import GeneratorTerm, ModifiedEquation, modified_equation
from sdaeverify_orders.trees.nodes import rule_nodes
from sdaeverify_orders.trees.sdes.universal import class_sde
from sdaeverify_orders.trees.weights import stepped

HERE = Path(__file__).parent
TIME, STEPS = 1.0, (4, 8, 16, 32)
# Modes of a coordinate, by their number; polynomials of the momentum and the scale of its nodes.
MODES, MOMENTA, SCALE = {1: 48, 2: 20}, 22, 0.6
FRICTION, STRENGTH = 1.2, 0.9
# Polynomials of the momentum and trigonometric ones represent means to this.
FLOOR = 1e-8
# Gauss-Hermite nodes a variable: dW, H, K.
COUNTS = {1: (12, 8, 5), 2: (7, 4, 3)}
CLASSES = ("scalar", "additive", "general", "langevin")
LANGEVIN = "langevin"


class Waves(NamedTuple):
    """A function of periodic coordinates: sum of a_r sin(k_r . x + c_r) + c.

    Attributes
    ----------
    sizes, phases : ndarray, shape (R,)
    rates : ndarray, shape (R, d)
        Whole numbers.
    constant : float
    """

    sizes: Array
    rates: Array
    phases: Array
    constant: float

    def __call__(self, x: Array, directions: Sequence[Array] = ()) -> Array:
        """Return the derivative in some directions, shape (P,)."""
        n = len(directions)
        waves = np.sin(self.rates @ x + self.phases[:, None] + 0.5 * np.pi * n)
        for each in directions:
            waves = waves * (self.rates @ each)
        value: Array = self.sizes @ waves
        return value if n else value + self.constant


@dataclass(frozen=True, eq=False)
class Periodic:
    """An equation with periodic coefficients and what semigroups on it are made of.

    Attributes
    ----------
    kind : str
        Name of its class.
    fields : list of list of Waves
        Drift and columns of the diffusion, each with its components; of Langevin dynamics the force.
    """

    kind: str
    fields: list[list[Waves]]

    @property
    def d(self) -> int:
        """Number of periodic coordinates."""
        return len(self.fields[0])

    @property
    def motions(self) -> int:
        """Number of Brownian motions."""
        return 1 if self.kind == LANGEVIN else len(self.fields) - 1

    @property
    def problem(self) -> Any:
        """The equation as a problem."""
        if self.kind == LANGEVIN:
            return Langevin(
                force=lambda q: self.derivative(0, q), friction=FRICTION, strength=STRENGTH, position=[0.3],
                momentum=[0.1], horizon=TIME, noise=frozenset({"dW", "H", "K"}), source="reports/modified",
            )  # fmt: skip
        columns = range(1, self.motions + 1)
        return class_sde(
            frozenset({"additive-noise"}) if self.kind == "additive" else frozenset(),
            drift=lambda _, x: self.derivative(0, x),
            diffusion=lambda _, x: np.stack([self.derivative(j, x) for j in columns], axis=1),
            diffusion_derivative=lambda _, x, y: np.stack([self.derivative(j, x, (y,)) for j in columns], axis=1),
            start=0.1 * np.ones(self.d),
            noise_dim=self.motions,
            source="reports/modified",
        )

    def derivative(self, field: int, x: Array, directions: Sequence[Array] = ()) -> Array:
        """Return a derivative of a coefficient, shape (d, P)."""
        return np.array([each(x, directions) for each in self.fields[field]])

    def differential(self, of: Tree, x: Array) -> Array:
        """Return F(tau), shape (n, P); of trees with leaves of time 0, as coefficients do not depend on it."""
        if self.kind == LANGEVIN:
            return self._langevin(of, x)
        if any(colour < DRIFT for colour in of.colours):
            return np.zeros_like(x)
        return self.derivative(of.colour, x, [self.differential(kid, x) for kid in of.kids])

    def _langevin(self, of: Tree, x: Array) -> Array:
        kids = [self._langevin(kid, x) for kid in of.kids]
        q, p, none = x[:1], x[1:], np.zeros_like(x[:1])
        if of.name == "q":
            return np.concatenate([kids[0][1:], none])
        if of.colour > DRIFT:
            return np.concatenate([none, none + STRENGTH * (of.colour == 1)])
        moved = {"p": lambda: p, "d": lambda: -FRICTION * kids[0][1:]}
        value = moved.get(of.name, lambda: self.derivative(0, q, [kid[:1] for kid in kids]))()
        return np.concatenate([none, value])


@dataclass(frozen=True, eq=False)
class Basis:
    """Functions on periodic coordinates and perhaps a momentum, by their values at nodes.

    Attributes
    ----------
    d : int
        Number of periodic coordinates.
    momentum : bool
        Whether there is a momentum beside them.
    """

    d: int
    momentum: bool

    @property
    def axes(self) -> list[Array]:
        """Nodes of each coordinate."""
        some = MODES[self.d] if not self.momentum else 20
        own = [2.0 * np.pi * np.arange(some) / some] * self.d
        return [*own, SCALE * np.polynomial.hermite_e.hermegauss(MOMENTA)[0]] if self.momentum else own

    @property
    def points(self) -> Array:
        """All nodes, shape (n, S)."""
        return np.array([each.ravel() for each in np.meshgrid(*self.axes, indexing="ij")])

    def values(self, x: Array) -> Array:
        """Return what values at nodes are multiplied with to be those elsewhere, shape (P, S)."""
        parts = [
            _interpolation(axis, row, i == self.d) for i, (axis, row) in enumerate(zip(self.axes, x, strict=True))
        ]
        return reduce(lambda a, b: (a[:, :, None] * b[:, None, :]).reshape(len(a), -1), parts)

    def derivatives(self) -> list[Array]:
        """Return the matrices of partial derivatives."""
        found = []
        for i, axis in enumerate(self.axes):
            ones = [np.eye(len(each)) for each in self.axes]
            ones[i] = _hermite_derivative(axis) if i == self.d else _fourier_derivative(len(axis))
            found.append(reduce(np.kron, ones))
        return found


def _interpolation(axis: Array, x: Array, is_momentum: bool) -> Array:
    if is_momentum:
        to = np.polynomial.hermite_e.hermevander(axis / SCALE, len(axis) - 1)
        return np.asarray(np.polynomial.hermite_e.hermevander(x / SCALE, len(axis) - 1) @ np.linalg.inv(to))
    n = len(axis)
    away = x[:, None] - axis
    with np.errstate(all="ignore"):
        values = np.sin(0.5 * n * away) / (n * np.tan(0.5 * away))
    return np.where(np.abs(np.sin(0.5 * away)) < 1e-13, 1.0, values)


def _fourier_derivative(n: int) -> Array:
    rows = np.arange(n)
    away = rows[:, None] - rows
    with np.errstate(all="ignore"):
        matrix = 0.5 * (-1.0) ** away / np.tan(np.pi * away / n)
    return np.where(away == 0, 0.0, matrix)


def _hermite_derivative(axis: Array) -> Array:
    n = len(axis)
    to = np.polynomial.hermite_e.hermevander(axis / SCALE, n - 1)
    return np.asarray(to @ np.diag(np.arange(1.0, n), 1) @ np.linalg.inv(to) / SCALE)


def generator(of: Periodic, basis: Basis) -> Array:
    """Return the matrix of L."""
    x, D = basis.points, basis.derivatives()
    if of.kind == LANGEVIN:
        F = of.derivative(0, x[:1])[0]
        return _rows(x[1]) * D[0] + _rows(F - FRICTION * x[1]) * D[1] + 0.5 * STRENGTH**2 * D[1] @ D[1]
    f = of.derivative(0, x)
    matrix = sum(_rows(f[i]) * D[i] for i in range(of.d))
    for j in range(1, of.motions + 1):
        b = of.derivative(j, x)
        for i, k in product(range(of.d), repeat=2):
            matrix = matrix + 0.5 * _rows(b[i] * b[k]) * (D[i] @ D[k])
    return np.asarray(matrix)


def correction(of: Periodic, basis: Basis, terms: Sequence[GeneratorTerm]) -> Array:
    """Return the matrix of L_p."""
    x, D = basis.points, basis.derivatives()
    powers: dict[tuple[int, ...], Array] = {(): np.eye(x.shape[1])}
    matrix = np.zeros((x.shape[1], x.shape[1]))
    for term in terms:
        parts = [of.differential(each, x) for each in term.forest]
        for places in product(range(len(x)), repeat=len(parts)):
            factor = term.value * np.prod([part[i] for part, i in zip(parts, places, strict=True)], axis=0)
            if np.any(factor):
                matrix += _rows(factor) * _power(powers, D, tuple(sorted(places)))
    return matrix


def _power(powers: dict[tuple[int, ...], Array], D: Sequence[Array], places: tuple[int, ...]) -> Array:
    if places not in powers:
        powers[places] = D[places[0]] @ _power(powers, D, places[1:])
    return powers[places]


def _rows(values: Array) -> Array:
    return values[:, None]


def transition(scheme: Scheme, of: Periodic, basis: Basis, h: float) -> Array:
    """Return the matrix that takes u to E u after a step of size h."""
    nodes, x, problem = noise_of(scheme, of), basis.points, of.problem
    step, matrix = OneStep(scheme, problem), np.zeros((x.shape[1], x.shape[1]))
    for k, weight in enumerate(nodes.weights):
        one = nodes.select(slice(k, k + 1))._replace(weights=np.ones(1))
        matrix += weight * basis.values(stepped(step, x, one, h, 0.0))
    return matrix


def noise_of(scheme: Scheme, of: Periodic) -> Nodes:
    """Return a rule for the noise of a step, exact to higher degrees than conditions need."""
    M, counts = of.motions, dict(zip(("dW", "H", "K"), COUNTS[of.d], strict=True))
    if scheme.law.bounded or "A" in scheme.noise:
        return rule_nodes(M, scheme.noise, scheme.law, 7)
    names = [name for name in counts if name in scheme.noise]
    rules = [np.polynomial.hermite_e.hermegauss(counts[name]) for name in names for _ in range(M)]
    points = np.array([*product(*(rule[0] for rule in rules))]).T
    weights = np.prod([*product(*(rule[1] / rule[1].sum() for rule in rules))], axis=1)
    parts = {name: points[i * M : (i + 1) * M] for i, name in enumerate(names)}
    scales = {"dW": 1.0, "H": 12.0**-0.5, "K": 720.0**-0.5}
    scaled = {name: scales[name] * part for name, part in parts.items()}
    return Nodes(scaled["dW"], scaled.get("H"), weights, exact=True, K=scaled.get("K"))


def equations() -> Iterator[Periodic]:
    """Yield one equation for each class."""
    rng = np.random.Generator(np.random.Philox(key=20260117))

    def waves(d: int, size: float, constant: float, number: int = 2) -> Waves:
        rates = rng.integers(-1, 2, (number, d)) if d > 1 else np.arange(1.0, number + 1.0)[:, None]
        return Waves(size * rng.uniform(0.5, 1.0, number), 1.0 * rates, rng.uniform(0.0, 6.0, number), constant)

    yield Periodic("scalar", [[waves(1, 0.5, 0.2)], [waves(1, 0.2, 0.6)]])
    yield Periodic("additive", [[waves(1, 0.5, 0.2)], [Waves(np.zeros(1), np.ones((1, 1)), np.zeros(1), 0.7)]])
    noises = [[waves(2, 0.1, c), waves(2, 0.1, 0.4)] for c in (0.6, -0.5)]
    yield Periodic("general", [[waves(2, 0.25, 0.1) for _ in range(2)], *noises])
    yield Periodic(LANGEVIN, [[waves(1, 0.4, 0.0, 1)]])


@dataclass(frozen=True)
class Row:
    """What is found of a scheme on an equation.

    Attributes
    ----------
    equation : ModifiedEquation
    errors, left : tuple of float
        Errors at each step size, and what the modified equation leaves of them; empty without terms.
    """

    equation: ModifiedEquation
    errors: tuple[float, ...] = ()
    left: tuple[float, ...] = ()

    @property
    def cells(self) -> dict[str, object]:
        """The row of the table."""
        of, rates = self.equation, [_rate(self.errors), _rate(self.left)]
        kind = "" if not of.terms else "SDE" if of.exists else "no SDE: terms of third or higher order"
        found = (
            [f"{self.errors[-1]:.2e}", f"{rates[0]:.2f}", f"{self.left[-1]:.2e}", f"{rates[1]:.2f}"]
            if self.errors
            else [""] * 4
        )
        why = of.why_not or ("" if of.terms else f"all means hold up to the weight {of.top}")
        names = ("scheme", "class", "order", "modified", "error", "error_order", "left", "left_order", "why")
        return dict(
            zip(names, (of.scheme, of.kind, f"{of.order:g}" if of.terms else "", kind, *found, why), strict=True)
        )


def _rate(errors: Sequence[float]) -> float:
    """Return the order at the finest steps at which errors are above what matrices leave out."""
    known = [each for each in errors if each > FLOOR]
    return float(np.log2(known[-2] / known[-1])) if len(known) > 1 else float("nan")


def measured(scheme: Scheme, of: Periodic, equation: ModifiedEquation) -> Row:
    """Return the errors of a scheme on an equation, and what its modified equation leaves of them."""
    basis = Basis(of.d, of.kind == LANGEVIN)
    L, L_p = generator(of, basis), correction(of, basis, equation.terms)
    n, u = len(L), observables(basis)
    both = scipy.linalg.expm(TIME * np.block([[L, L_p], [np.zeros_like(L), L]]))
    exact, first = both[:n, :n] @ u, both[:n, n:] @ u
    errors, left = [], []
    inside = np.ones(n, dtype=bool) if not basis.momentum else np.abs(basis.points[1]) < 1.5
    for steps in STEPS:
        h = TIME / steps
        found = np.linalg.matrix_power(transition(scheme, of, basis, h), steps) @ u - exact
        errors.append(float(np.abs(found)[inside].max()))
        left.append(float(np.abs(found - h**equation.order * first)[inside].max()))
    return Row(equation, tuple(errors), tuple(left))


def observables(basis: Basis) -> Array:
    """Return sin and cos of the coordinates, and the kinetic energy, at the nodes."""
    x = basis.points
    rows = [wave(x[i]) for i in range(basis.d) for wave in (np.sin, np.cos)]
    return np.array(rows + ([0.5 * x[1] ** 2] if basis.momentum else [])).T


def rows_of(scheme: Scheme, kinds: Sequence[str] = CLASSES) -> Iterator[Row]:
    """Yield the rows of a scheme: of the classes that it solves."""
    classes, made = classes_of(scheme), {each.kind: each for each in equations()}
    for name in kinds:
        if name not in classes:
            continue
        weight = 8 if name == LANGEVIN and "K" in scheme.noise else None
        equation = modified_equation(scheme, classes[name], made[name].motions if name != LANGEVIN else 2, weight)
        if equation.solves:
            yield measured(scheme, made[name], equation) if equation.terms else Row(equation)


def draw(rows: Sequence[Row], file: Path) -> None:
    """Draw errors and what is left of them."""
    shown = [row for row in rows if row.errors]
    columns = 4
    figure, axes = plt.subplots(
        -(-len(shown) // columns), columns, figsize=(11, 2.6 * -(-len(shown) // columns)), squeeze=False
    )
    for ax, row in zip(axes.flat, shown, strict=False):
        h = [TIME / steps for steps in STEPS]
        ax.loglog(h, row.errors, "o-", label="against the equation")
        ax.loglog(h, row.left, "s--", label="against the modified equation")
        ax.set_title(f"{row.equation.scheme}, {row.equation.kind}", fontsize=8)
        ax.tick_params(labelsize=6)
    for ax in axes.flat[len(shown) :]:
        ax.axis("off")
    axes.flat[0].legend(fontsize=6)
    figure.tight_layout()
    with plt.rc_context({"svg.fonttype": "none", "svg.hashsalt": "modified"}):
        figure.savefig(file, metadata={"Date": None})


def main() -> None:
    """Measure all shipped schemes for SDEs and for Langevin dynamics, and write the table and the picture."""
    registry = load_registry(environ={})
    of_forms = [
        each
        for each in select_schemes(registry, None)
        if {form.__name__ for form in each.forms} & {"SDE", "Langevin"}
    ]
    rows = []
    for scheme in of_forms:
        for row in rows_of(scheme):
            print(row.cells, flush=True)
            rows.append(row)
    with (HERE / "errors.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0].cells), lineterminator="\n")
        table.writeheader()
        table.writerows(row.cells for row in rows)
    draw(rows, HERE / "errors.svg")


if __name__ == "__main__":
    main()
