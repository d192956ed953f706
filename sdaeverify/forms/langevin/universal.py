"""Trees of Langevin dynamics: Nystroem trees, where the friction is a number.

With dq = p dt and dp = (F(q) + gamma d(p)) dt + sigma dW, d(p) = -p, a step is a sum over trees of the nodes

    q [m]: a position moved by the momentum m,      f [q_1, ..., q_k]: D^k F (q_1, ..., q_k),
    d [m]: friction on the momentum m,              b_j: sigma e_j,      p: the momentum before the step.

Since d is linear and the same in all components, D^k F (.., d(m), ..) does not show where in a tree friction acts.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np

from ...arrays import Array
from ...noise.brownian import BROWNIAN
from ..trees.far_problems import FAR, among, distant_delays, far_states
from ..trees.tree_class import OVER_NOISE, PRODUCT, Grove, Node, Posed, Relatives, TreeClass, Written

Q, P = frozenset({"q"}), frozenset({"p"})
NODES = (
    Node("p", "p", integral=PRODUCT, most=0),
    Node("q", "q", P, least=1, most=1),
    Node("f", "p", Q),
    Node("d", "p", P, least=1, most=1, scaled=True),
    Node("b", "p", integral=OVER_NOISE, most=0),
)
# The momentum before the step, sigma, and the size of each force derived from a potential. The forces that the
# potential exerts on the factors of a tree have the size of its square, 5e-17.
MOMENTUM, STRENGTH, FAINT = 1.25, 0.8, 2.0**-27
# Random dynamics: degrees of freedom, friction, and the sizes of terms of the force.
LOW, HIGH, FRICTION, SEED = 2, 5, 1.5, 20260104
SIZES = (0.7, 0.4, 0.1)

SOURCE = '''def force(q):
    """Return F(q), shape ({d}, P)."""
    F = np.zeros_like(q)
{force}    return F
'''


@dataclass(frozen=True)
class LangevinTrees(TreeClass):
    """Langevin dynamics with any smooth force, or with a force that is a gradient.

    Attributes
    ----------
    form : type
        `Langevin`.
    gradient : bool
        Whether F = -grad U. With U = -sum e Q_tau Q_tau_1 ... Q_tau_k, the force on Q_tau is the required product,
        and the forces on the other positions are smaller than rounding.
    """

    form: Callable[..., Any]
    gradient: bool = False

    nodes = NODES
    motions = 2
    # The friction is the negative of the number.
    numbers = (-0.6, -0.05)

    @property
    def name(self) -> str:  # type: ignore[override]
        """The name of the class."""
        return "langevin-gradient" if self.gradient else "langevin"

    def pose(self, grove: Grove) -> Posed:
        """Return dynamics with one degree of freedom for each momentum; each noise momentum has its own motion."""
        momenta, freedoms = _freedoms(grove)
        sizes, driven = self._sizes(grove), np.zeros((len(momenta), grove.motions))
        start = np.zeros(len(momenta))
        for n, place in enumerate(momenta):
            tree = grove.trees[place]
            if tree.node.integral == OVER_NOISE:
                driven[n, tree.motion] = 1.0
            elif tree.node.integral == PRODUCT:
                start[n] = MOMENTUM
        forces = [
            [freedoms[place], *(freedoms[kid] for kid in grove.trees[place].kids)]
            for place in momenta
            if grove.trees[place].node.name == "f"
        ]
        # Forces from a potential are too small compared with positions that are not 0.
        origin = (0.0 if self.gradient else 0.75) * np.cos(1.0 + 2.0 * np.arange(len(momenta)))
        problem = self._dynamics(self._force(forces, origin[:, None]), -grove.number, origin, start)
        rows = [(tree.node.of, n) for tree, n in zip(grove.trees, freedoms, strict=True)]
        return Posed(problem, rows, sizes, driven)

    def written(self, grove: Grove) -> Written | None:
        """Return source code of dynamics whose forces are products of positions; None if `gradient` is true."""
        if self.gradient:
            return None
        momenta, freedoms = _freedoms(grove)
        places = tuple(f"{tree.node.of}[{n}]" for tree, n in zip(grove.trees, freedoms, strict=True))
        trees = [grove.trees[place] for place in momenta]
        forces = [f"    F[{n}] = {tree.product(places)}\n" for n, tree in enumerate(trees) if tree.node.name == "f"]
        arguments = {
            "force": "force",
            "friction": -grove.number,
            "strength": STRENGTH,
            "position": f"np.zeros({len(momenta)})",
            "momentum": [MOMENTUM if tree.node.integral == PRODUCT else 0.0 for tree in trees],
        }
        functions = SOURCE.format(d=len(momenta), force="".join(forces))
        return Written(self.form.__name__, functions, arguments, places, ("each momentum has noise",), exact=False)

    def _sizes(self, grove: Grove) -> list[float]:
        own = {"p": MOMENTUM, "b": STRENGTH, "f": FAINT if self.gradient else 1.0, "q": 1.0}
        sizes: list[float] = []
        for tree in grove.trees:
            sizes.append(own[tree.node.name] * prod(sizes[kid] for kid in tree.kids))
        return sizes

    def _force(self, forces: list[list[int]], origin: Array) -> Callable[[Array], Array]:
        """Return the force with products of positions as components, using operations of all array libraries."""
        size = max((len(factors) for factors in forces), default=1)
        moved = [(each, k) for each in forces for k in range(len(each) if self.gradient else 1)]
        places, counts = np.zeros((len(moved), size), dtype=int), np.zeros((len(moved), size, 1))
        onto = np.zeros((len(origin), len(moved)))
        for term, (factors, k) in enumerate(moved):
            rest = factors[:k] + factors[k + 1 :]
            places[term, : len(rest)], counts[term, : len(rest)] = rest, 1.0
            onto[factors[k], term] = FAINT if self.gradient else 1.0

        def force(q: Array) -> Array:
            products = (counts * (q - origin)[places] + (1.0 - counts)).prod(axis=1)
            total: Array = onto @ products
            return total

        return force

    def relatives(self, motions: int) -> Relatives:  # noqa: ARG002 - each degree of freedom has its own motion
        """Return random dynamics G(q) = A^+ F(A q + c) + N k(q), AN = 0, in R^5, and with F in R^2."""
        return self._related(1.0, np.zeros((HIGH, 1)))

    def distant(self, motions: int) -> tuple[Relatives, ...]:  # noqa: ARG002 - as for `relatives`
        """Return the same dynamics in the plane, and in R^5 the dynamics of Q = `FAR` q + C and P = `FAR` p."""
        rng = np.random.Generator(np.random.Philox(key=SEED + 1))
        C = FAR * rng.uniform(-1.0, 1.0, (HIGH, 1))
        pair, states = self._related(FAR, C), far_states(rng, 2 * HIGH)
        # The dynamics are autonomous: they are their own delayed ones.
        delays = distant_delays(rng)
        return among([pair._replace(delay=above, later=below) for above, below in delays], states)

    def _related(self, size: float, C: Array) -> Relatives:
        """Return dynamics in the plane, and in R^5 the dynamics of size q + C and size p."""
        rng = np.random.Generator(np.random.Philox(key=SEED))
        normal = rng.standard_normal
        A, c = normal((LOW, HIGH)), normal((LOW, 1))
        inverse, kernel = np.linalg.pinv(A), np.linalg.svd(A)[2][LOW:].T
        F, k = _random_force(rng, LOW, LOW), _random_force(rng, HIGH - LOW, HIGH)
        q, p = normal((2, HIGH))

        def lifted(z: Array) -> Array:
            q = (z - C) / size
            return np.asarray(size * (inverse @ F(A @ q + c) + kernel @ k(q)))

        below = self._dynamics(F, FRICTION, A @ q + c[:, 0], A @ p)
        above = self._dynamics(lifted, FRICTION, size * q + C[:, 0], size * p, size * STRENGTH)
        return Relatives(below, above, {"q": (A / size, c - A @ C / size), "p": (A / size, 0.0 * c)}, A)

    def _dynamics(
        self, force: Callable[[Array], Array], friction: float, q: Array, p: Array, strength: float = STRENGTH
    ) -> Any:
        return self.form(
            force=force,
            friction=friction,
            strength=strength,
            position=q,
            momentum=p,
            noise=frozenset(BROWNIAN),
            horizon=1.0,
            source="trees of Langevin dynamics",
        )


def _freedoms(grove: Grove) -> tuple[list[int], list[int]]:
    """Return the indices of the momenta, and for each tree its degree of freedom: that of its momentum or subtree."""
    momenta = [place for place, tree in enumerate(grove.trees) if tree.node.of == "p"]
    owners = (place if tree.node.of == "p" else tree.kids[0] for place, tree in enumerate(grove.trees))
    numbers = {place: n for n, place in enumerate(momenta)}
    return momenta, [numbers[owner] for owner in owners]


def _random_force(rng: np.random.Generator, rows: int, dimension: int) -> Callable[[Array], Array]:
    """Draw a random quadratic force with `rows` components on a space of another dimension."""
    shapes = ((rows, 1), (rows, dimension), (rows, dimension, dimension))
    constant, linear, quadratic = (size * rng.standard_normal(s) for size, s in zip(SIZES, shapes, strict=True))

    def force(q: Array) -> Array:
        bent: Array = np.einsum("nij,ip,jp->np", quadratic, q, q)
        return constant + linear @ q + bent

    return force
