"""Trees of index-1 equations: the trees of an SDE, with additional nodes of weight zero for the constraint.

With dx = f(t, x, y) dt + sum_j b_j(t, x, y) dW_j and 0 = u(t, x, y), where without loss of generality u_y = -Id at
the point, the derivatives of y along a solution are trees with the root u, no root u having a single subtree with
root u:

    0 = prod_i z_tau_i - y_tau    for tau = [tau_1, ..., tau_k]_u,

where z are components of x or y, or t - t_0. So for the solution they are products of their subtrees.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ...arrays import Array
from ...noise.brownian import BROWNIAN
from ..trees.far_problems import FAR, LATER, among, distant_delays, far_states, placements
from ..trees.tree_class import OVER_NOISE, PRODUCT, TIME, Grove, Node, Posed, Relatives, TreeClass, Written

ALL = frozenset({"x", "y", TIME})
NODES = (Node("f", "x", ALL), Node("b", "x", ALL, OVER_NOISE), Node("u", "y", ALL, PRODUCT, least=1))
ADDITIVE = (NODES[0], Node("b", "x", integral=OVER_NOISE, most=0), NODES[2])
# Random equations: numbers of differential and algebraic components below and above, and the sizes of terms.
LOW, HIGH, SEED = (2, 1), (5, 3), 20260105
SIZES = (0.7, 0.3, 0.1)
START = 0.5 * np.cos(np.arange(1.0, HIGH[0] + 1.0))
SOURCE = '''def drift(t, x, y):
    """Return f(t, x, y), shape ({d}, P)."""
    f = np.zeros(x.shape, dtype=np.result_type(x, y))
{drift}    f[{last}] = -x[{last}]
    return f


def diffusion(t, x, y):
    """Return B(t, x, y), shape ({d}, {motions}, {paths})."""
    B = np.zeros({shape})
{diffusion}    B[{last}, 0] = 1.0
    return B


def constraint(t, x, y):
    """Return u(t, x, y), shape ({q}, P)."""
    u = np.zeros(y.shape, dtype=np.result_type(x, y))
{constraint}    return u - y
'''
Coefficient = Callable[[float, Array, Array], Array]
Given = TypeVar("Given")
# Of t, x and y.
Function = Callable[[float, Array, Array], Given]


@dataclass(frozen=True)
class IndexOneTrees(TreeClass):
    """Equations of index 1 with any smooth coefficients, or with a constant diffusion.

    Attributes
    ----------
    form : type
        `IndexOneSDAE`.
    additive : bool
        Whether the diffusion is constant.
    """

    form: Callable[..., Any]
    additive: bool = False

    @property
    def name(self) -> str:  # type: ignore[override]
        """The name of the class."""
        return "index-1-additive" if self.additive else "index-1"

    @property
    def nodes(self) -> tuple[Node, ...]:  # type: ignore[override]
        """The kinds of nodes."""
        return ADDITIVE if self.additive else NODES

    def pose(self, grove: Grove) -> Posed:
        """Return the equation of trees in x and in y, each with one additional component that is constant."""
        system = _Products(grove)
        problem = self._equation(
            system.drift,
            system.constant_diffusion if self.additive else system.diffusion,
            system.constraint,
            system.start,
            drift_partials=system.drift_partials,
            constraint_partials=system.constraint_partials,
            algebraic=system.algebraic,
            noise_dim=grove.motions,
        )
        rows = [(tree.node.of, int(row)) for tree, row in zip(grove.trees, system.rows, strict=True)]
        return Posed(problem, rows, [1.0] * len(grove.trees), np.eye(grove.motions))

    def written(self, grove: Grove) -> Written:
        """Return the equation of trees in x and in y as source code."""
        system = _Products(grove)
        places = [f"{tree.node.of}[{row}]" for tree, row in zip(grove.trees, system.rows, strict=True)]
        lines: dict[str, list[str]] = {"f": [], "b": [], "u": []}
        for tree, row in zip(grove.trees, system.rows, strict=True):
            target = f"B[{row}, {tree.motion}]" if tree.node.name == "b" else f"{tree.node.name}[{row}]"
            lines[tree.node.name].append(f"    {target} = {tree.product(places)}\n")
        last, q = system.size - 1, max(1, len(system.of["u"]))
        functions = SOURCE.format(
            d=system.size,
            q=q,
            last=last,
            motions=grove.motions,
            paths="1" if self.additive else "P",
            shape=f"({system.size}, {grove.motions}, "
            + ("1)" if self.additive else "x.shape[1]), dtype=np.result_type(x, y)"),
            drift="".join(lines["f"]),
            diffusion="".join(lines["b"]),
            constraint="".join(lines["u"]) or f"    u[0] = x[{last}]\n",
        )
        arguments = {
            **{name: name for name in ("drift", "diffusion", "constraint")},
            "start": f"np.zeros({system.size})",
            "algebraic": q,
            "noise_dim": grove.motions,
        }
        beside = (f"x[{last}]  dx = -x dt + dW_1", *([] if lines["u"] else [f"y[0]  x[{last}]"]))
        traits = frozenset({"additive-noise"} if self.additive else ())
        return Written(self.form.__name__, functions, arguments, tuple(places), beside, traits)

    def relatives(self, motions: int) -> Relatives:
        """Return random equations: above, f is A^+ f(t + s, A x + c, C y + e) + N k(t, x, y); b and u likewise."""
        return self._related(motions, _Scale(1.0, np.zeros((HIGH[0], 1))), np.eye(motions))

    def distant(self, motions: int) -> tuple[Relatives, ...]:
        """Return the equations at random times, with the one above for `FAR` x + X, `FAR` y, 5 motions."""
        rng, placed = np.random.Generator(np.random.Philox(key=SEED + 1)), placements(motions)
        scales = [_Scale(FAR, -FAR * START[:, None], *each) for each in distant_delays(rng)]
        pairs = [self._related(motions, each, placed[k % len(placed)]) for k, each in enumerate(scales)]
        return among(pairs, far_states(rng, HIGH[0]))

    def _related(self, motions: int, scale: "_Scale", placed: Array) -> Relatives:
        """Return an equation below with one above, among whose motions are those of the one below."""
        rng = np.random.Generator(np.random.Philox(key=SEED))
        normal = rng.standard_normal
        maps = {name: (normal((n, m)), normal((n, 1))) for name, n, m in zip("xy", LOW, HIGH, strict=True)}
        f, F = _lifted(rng, maps, "x", 1)
        b, B = _lifted(rng, maps, "x", motions, constant=self.additive)
        u, U = _lifted(rng, maps, "y", 1)
        (A, c), (C, e) = maps["x"], maps["y"]
        start = (A @ START[:, None] + c)[:, 0]
        later = scale.later(u.partials)
        below = self._random(
            scale.later(f),
            scale.later(b),
            lambda *z: scale.later(u)(*z) + (e - z[2])[:, None],
            start,
            drift_partials=scale.later(f.partials),
            constraint_partials=lambda *z: _minus_y(later(*z)),
        )

        above = self._random(
            scale.above(F),
            lambda t, x, y: np.einsum("dlp,lm->dmp", scale.above(B)(t, x, y), placed),
            lambda t, x, y: scale.above(U)(t, x, y) - y[:, None],
            scale.start,
            drift_partials=scale.partials_above(F.partials),
            constraint_partials=lambda *z: _minus_y(scale.partials_above(U.partials)(*z)),
        )
        moved = {"x": (A / scale.size, c - A @ scale.x / scale.size), "y": (C / scale.size, e)}
        return Relatives(below, above, moved, placed, LATER + scale.late, delay=scale.delay)

    def _random(self, f: Coefficient, b: Coefficient, u: Coefficient, start: Array, **given: Any) -> Any:
        probe = np.zeros((1, 1)) + start[:, None]
        of_y = HIGH[1] if len(start) == HIGH[0] else LOW[1]
        return self._equation(
            lambda t, x, y: f(t, x, y)[:, 0],
            b,
            lambda t, x, y: u(t, x, y)[:, 0],
            start,
            algebraic=of_y,
            noise_dim=b(0.0, probe, np.zeros((of_y, 1))).shape[1],
            **given,
        )

    def _equation(self, f: Coefficient, b: Coefficient, u: Coefficient, start: Array, **given: Any) -> Any:
        return self.form(
            drift=f,
            diffusion=b,
            constraint=u,
            start=start,
            noise=frozenset(BROWNIAN),
            traits=frozenset({"additive-noise"}) if self.additive else frozenset(),
            horizon=1.0,
            source="trees of index-1 equations",
            **given,
        )


class _Scale(NamedTuple):
    """Size, shift and delay of random equations.

    Attributes
    ----------
    size : float
    x : ndarray, shape (5, 1)
        X: the equation above is an equation for size x + X and size y.
    delay, late : float
        Delays of the equations above and below.
    """

    size: float
    x: Array
    delay: float = 0.0
    late: float = 0.0

    @property
    def start(self) -> Array:
        """A start of the equation above of the same size as its coefficients, shape (5,)."""
        return np.asarray(self.size * START + 0.75 * self.x[:, 0])

    def later(self, field: Function[Given]) -> Function[Given]:
        """Return a coefficient shifted in time by `late`; before its start it is that of time 0, so that y exists."""
        return lambda t, x, y: field(max(t - self.late, 0.0), x, y)

    def above(self, field: Coefficient) -> Coefficient:
        """Return a coefficient of the equation above."""
        return lambda t, x, y: self.size * field(max(t - self.delay, 0.0), (x - self.x) / self.size, y / self.size)

    def partials_above(
        self, partials: Callable[[float, Array, Array], Given]
    ) -> Callable[[float, Array, Array], Given]:
        """Return the derivatives of a coefficient of the equation above."""
        return lambda t, x, y: partials(max(t - self.delay, 0.0), (x - self.x) / self.size, y / self.size)


def _minus_y(partials: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return the derivatives of u - y, given those of u."""
    in_x, in_y = partials
    return in_x, in_y - np.eye(len(in_y))[..., None]


def _lifted(
    rng: np.random.Generator,
    maps: Mapping[str, tuple[Array, Array]],
    part: str,
    columns: int,
    *,
    constant: bool = False,
) -> tuple["_Field", "_Lifted"]:
    """Return random fields below and above that the maps of x and y relate, for one part of the equation."""
    rows, more = maps[part][0].shape
    inverse, kernel = np.linalg.pinv(maps[part][0]), np.linalg.svd(maps[part][0])[2][rows:].T
    below = _Field.random(rng, (rows, columns), 0 if constant else sum(LOW) + 1)
    beside = _Field.random(rng, (more - rows, columns), 0 if constant else sum(HIGH) + 1)
    return below, _Lifted(below, beside, *maps["x"], *maps["y"], inverse, kernel)


@dataclass(frozen=True, eq=False)
class _Lifted:
    """The field A^+ f(t + s, A x + c, C y + e) + N k(t, x, y) above a field f.

    Attributes
    ----------
    below, beside : _Field
        f and k.
    A, c, C, e : ndarray
        The maps of x and y.
    inverse, kernel : ndarray
        The pseudoinverse and the kernel of the map of the part of the equation.
    """

    below: "_Field"
    beside: "_Field"
    A: Array
    c: Array
    C: Array
    e: Array
    inverse: Array
    kernel: Array

    def __call__(self, t: float, x: Array, y: Array) -> Array:
        """Return the values, shape (n, l, P)."""
        below = self.below(t + LATER, self.A @ x + self.c, self.C @ y + self.e)
        related = np.einsum("ij,jnp->inp", self.inverse, below)
        return np.asarray(related + np.einsum("ij,jnp->inp", self.kernel, self.beside(t, x, y)))

    def partials(self, t: float, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the derivatives of the first column in x and y, shapes (n, d, P) and (n, q, P)."""
        below = self.below.partials(t + LATER, self.A @ x + self.c, self.C @ y + self.e)
        related = (
            np.einsum("ij,jkp,kl->ilp", self.inverse, part, map_, optimize=True)
            for part, map_ in zip(below, (self.A, self.C), strict=True)
        )
        beside = (np.einsum("ij,jkp->ikp", self.kernel, part) for part in self.beside.partials(t, x, y))
        in_x, in_y = (np.asarray(one + other) for one, other in zip(related, beside, strict=True))
        return in_x, in_y


@dataclass(frozen=True, eq=False)
class _Field:
    """A quadratic field c + L z + Q (z, z), where z are the first V of x, y and t.

    Attributes
    ----------
    constant : ndarray, shape (n, l)
    linear : ndarray, shape (n, l, V)
    quadratic : ndarray, shape (n, l, V, V)
    """

    constant: Array
    linear: Array
    quadratic: Array

    @classmethod
    def random(cls, rng: np.random.Generator, shape: tuple[int, int], variables: int) -> "_Field":
        """Draw a random field of a number of variables; constant if it is 0."""
        shapes = (shape, (*shape, variables), (*shape, variables, variables))
        return cls(*(size * rng.standard_normal(s) for size, s in zip(SIZES, shapes, strict=True)))

    def __call__(self, t: float, x: Array, y: Array) -> Array:
        """Return the values, shape (n, l, P)."""
        z = self._variables(t, x, y)
        n, l, count = self.linear.shape
        matrix = np.concatenate([self.linear, self.quadratic.reshape(n, l, count**2)], axis=2).reshape(n * l, -1)
        products = (z[:, None] * z).reshape(-1, z.shape[1])
        return np.asarray(self.constant[..., None] + (matrix @ np.concatenate([z, products])).reshape(n, l, -1))

    def partials(self, t: float, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the derivatives of the first column in x and y, shapes (n, d, P) and (n, q, P)."""
        z, Q = self._variables(t, x, y), self.quadratic[:, 0]
        n, count, _ = Q.shape
        slopes = ((Q + Q.swapaxes(1, 2)).reshape(n * count, count) @ z).reshape(n, count, -1)
        found = self.linear[:, 0, :, None] + slopes
        return found[:, : len(x)], found[:, len(x) : len(x) + len(y)]

    def _variables(self, t: float, x: Array, y: Array) -> Array:
        return np.concatenate([x, y, np.full((1, x.shape[1]), t)])[: self.linear.shape[2]]


@dataclass(frozen=True, eq=False)
class _Products:
    """The coefficients of the equation of trees: products of components around c, where y has its own part.

    Attributes
    ----------
    grove : Grove
    """

    grove: Grove

    @cached_property
    def of(self) -> dict[str, Array]:
        """Indices of the trees by the name of their roots' nodes."""
        names = np.array([tree.node.name for tree in self.grove.trees])
        return {name: np.flatnonzero(names == name) for name in "fbu"}

    @property
    def rows(self) -> Array:
        """Rows of the trees in x and in y, which have one further component each."""
        in_y = np.array([tree.node.of == "y" for tree in self.grove.trees])
        return np.where(in_y, np.cumsum(in_y), np.cumsum(~in_y)) - 1

    @property
    def size(self) -> int:
        """Number d of components of x."""
        return len(self.grove.trees) - len(self.of["u"]) + 1

    @property
    def origin(self) -> Array:
        """The point c in x and y, shape (d + q, 1)."""
        return np.asarray(0.75 * np.cos(1.0 + 2.0 * np.arange(len(self.grove.trees) + 2)))[:, None]

    @property
    def start(self) -> Array:
        """The start of x."""
        return self.origin[: self.size, 0]

    @property
    def algebraic(self) -> Array:
        """The y at time 0, where only products of times are nonzero."""
        x, y = self.origin[: self.size], self.origin[self.size :].copy()
        for _ in self.of["u"]:
            y += self.constraint(0.0, x, y)
        return y[:, 0]

    @cached_property
    def kids(self) -> Array:
        """Indices of the factors of each tree among x, y, 1 and t - t_0, shape (N, K)."""
        trees, one = self.grove.trees, len(self.origin)
        kids = np.full((len(trees), max([1, *(len(tree.kids) for tree in trees)])), one)
        for row, tree in zip(kids, trees, strict=True):
            row[: len(tree.kids)] = [one + 1 if kid < 0 else self._place(kid) for kid in tree.kids]
        return kids

    def _place(self, tree: int) -> int:
        return int(self.rows[tree] + (self.size if self.grove.trees[tree].node.of == "y" else 0))

    def _factors(self, name: str, t: float, x: Array, y: Array) -> Array:
        """Return the factors of the trees whose root is the named node, shape (K, n, P)."""
        z = np.concatenate([x, y]) - self.origin
        one, time = np.ones((1, x.shape[1])), np.full((1, x.shape[1]), t - self.grove.time)
        return np.concatenate([z, one, time])[self.kids[self.of[name]].T]

    def _spread(self, name: str, values: Array, rows: int) -> Array:
        spread = np.zeros((rows, *values.shape[1:]), dtype=values.dtype)
        spread[self.rows[self.of[name]]] = values
        return spread

    def drift(self, t: float, x: Array, y: Array) -> Array:
        """Return f, shape (d, P)."""
        return self._spread("f", np.prod(self._factors("f", t, x, y), axis=0), len(x))

    def constraint(self, t: float, x: Array, y: Array) -> Array:
        """Return u, shape (q, P)."""
        products = np.prod(self._factors("u", t, x, y), axis=0)
        return np.asarray(self._spread("u", products, len(y)) - (y - self.origin[self.size :]))

    def diffusion(self, t: float, x: Array, y: Array) -> Array:
        """Return B, shape (d, M, P)."""
        return self._in_columns(np.prod(self._factors("b", t, x, y), axis=0))

    def constant_diffusion(self, _t: float, _x: Array, _y: Array) -> Array:
        """Return B of additive noise, shape (d, M, 1)."""
        return self._in_columns(np.ones((len(self.of["b"]), 1)))

    def _in_columns(self, values: Array) -> Array:
        B = np.zeros((self.size, self.grove.motions, values.shape[1]), dtype=values.dtype)
        B[self.rows[self.of["b"]], [self.grove.trees[place].motion for place in self.of["b"]]] = values
        return B

    def drift_partials(self, t: float, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the derivatives of f in x and y."""
        return self._partials("f", t, x, y)

    def constraint_partials(self, t: float, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the derivatives of u in x and y."""
        in_x, in_y = self._partials("u", t, x, y)
        return in_x, in_y - np.eye(len(y))[..., None]

    def _partials(self, name: str, t: float, x: Array, y: Array) -> tuple[Array, Array]:
        factors, kids = self._factors(name, t, x, y), self.kids[self.of[name]]
        whole = np.zeros((len(kids), len(self.origin) + 2, x.shape[1]))
        for k, column in enumerate(kids.T):
            whole[np.arange(len(kids)), column] += np.prod(np.delete(factors, k, axis=0), axis=0)
        spread = self._spread(name, whole, len(x) if name == "f" else len(y))
        return spread[:, : len(x)], spread[:, len(x) : len(x) + len(y)]
