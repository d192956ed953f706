"""Diagonal noise: elementary weights from the Taylor series of steps on one rich equation.

A coefficient b_j(t, x_j) e_j is never nilpotent, so that no equation with diagonal noise isolates a tree. But a step
on

    f_i = sum_r a_ir sin(l_r . z),   b_j = sum_r c_jr sin(k_jr . (x_j, p, t)),   z = (x, p, t),

with further constant components p, is a power series in sqrt(h) whose coefficient of h^(w/2) is the sum of
phi(tau)/sigma(tau) F(tau) over the trees of weight w. At many states these are linear equations for the weights, more
of them than unknowns: a step that violates them is not a B-series.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy

from sdaeverify import SDE, Array, Scheme
from sdaeverify.probing import Nodes, OneStep
from sdaeverify.trees import Relatives, far_problems

from ..grow import DRIFT, TIME, Tree, closure
from ..weights import stepped
from .equivariance import Coefficient
from .universal import NOISE, with_rows

FAR, PLACES, TIME_0 = far_problems.FAR, far_problems.PLACES, far_problems.TIME_0

SEED = 20260103
# Number of sines per coefficient and of constant components; rates of the sines in x, and their factor in p.
SINES, STILL, RATE, VARIETY = 8, 2, 1.0, 2.5
# Equations per unknown, and least number of states.
SURPLUS, FEWEST = 2.5, 24
# Step sizes are the squares of SIZES Chebyshev points up to LONGEST, for POWERS powers; a further size tests the
# convergence of the series.
SIZES, POWERS, LONGEST, BETWEEN = 12, 11, 0.1, 0.057


class Sines(NamedTuple):
    """Sums of sines: entry (m, r) of `rates` holds the rates of sine r of sum m in each of k variables.

    Attributes
    ----------
    sizes : ndarray, shape (n, R)
    rates : ndarray, shape (n, R, k), or (1, R, k) where all have the same
    """

    sizes: Array
    rates: Array

    def derivative(self, z: Array, directions: Sequence[Array]) -> Array:
        """Return the mixed derivative in directions, shape (n, P); z and directions have shape (n or 1, k, P)."""
        product = _sine(_times(self.rates, z) + 0.5 * np.pi * len(directions))
        for each in directions:
            product = product * (self.rates @ each)
        summed: Array = _times(self.sizes[:, None], product)[:, 0]
        return summed


def _times(matrix: Array, z: Array) -> Array:
    """Return a matrix product with real and imaginary parts separately, ten times as fast as with complex numbers."""
    product: Array = matrix @ z.real + 1j * (matrix @ z.imag) if _is_complex(z) else matrix @ z
    return product


def _is_complex(z: Array) -> bool:
    # Arrays of other libraries, whose values may be traced, are treated as real.
    return isinstance(z, np.ndarray) and np.iscomplexobj(z)


def _sine(z: Array) -> Array:
    sine: Array = np.sin(z) if not _is_complex(z) else _complex_sine(z.real, z.imag)
    return sine


def _complex_sine(x: Array, y: Array) -> Array:
    sine: Array = np.sin(x) * np.cosh(y) + 1j * (np.cos(x) * np.sinh(y))
    return sine


class Unknowns(NamedTuple):
    """Weights of the trees of one weight as unknowns of linear equations at many states.

    Attributes
    ----------
    weight : int
    rows : list of int
        Indices of the trees in the basis.
    matrix, inverse : ndarray, shape (M S, n) and (n, M S)
        F(tau)/sigma(tau) at all states, and its pseudoinverse for least squares.
    """

    weight: int
    rows: list[int]
    matrix: Array
    inverse: Array

    @property
    def gain(self) -> float:
        """Largest error of a weight relative to the error of a coefficient of the series."""
        return float(np.max(np.linalg.norm(self.inverse, axis=1)))

    @property
    def rounding(self) -> float:
        """Standard deviation of the rounding error of a weight.

        Steps have independent errors of about eps. A coefficient of h^(w/2) is a combination of steps of all sizes,
        divided by LONGEST^w, and a weight is a combination of coefficients at all states.
        """
        _, to_coefficients = _sizes()
        of_series = np.linalg.norm(to_coefficients[self.weight - 1]) / LONGEST**self.weight
        return float(np.finfo(float).eps * of_series * self.gain)


@dataclass(frozen=True, eq=False)
class RichEquation:
    """A random equation with diagonal noise.

    Attributes
    ----------
    motions : int
        Number M of nonconstant components, each with its own Brownian motion.
    basis : tuple of Tree
        Trees that the equation distinguishes, with independent elementary differentials.
    """

    motions: int
    basis: tuple[Tree, ...]

    @property
    def states(self) -> int:
        """Number S of random states, enough to distinguish the trees of each weight."""
        most = max(Counter(each.weight for each in self.basis).values())
        return max(FEWEST, int(SURPLUS * most / self.motions))

    @property
    def dimension(self) -> int:
        """Number d of components, including constant ones."""
        return self.motions + STILL

    @property
    def _sines(self) -> tuple[Sines, Sines]:
        normal, M = np.random.Generator(np.random.Philox(key=SEED)).standard_normal, self.motions
        of_drift = RATE * normal((SINES, self.dimension + 1))
        of_drift[:, M:-1] *= VARIETY
        of_noise = RATE * normal((M, SINES, STILL + 2))
        of_noise[..., 1:-1] *= VARIETY
        sizes = normal((2, M, SINES)) / np.sqrt(SINES)
        return Sines(sizes[0], of_drift[None]), Sines(sizes[1], of_noise)

    @property
    def x(self) -> Array:
        """Random states, shape (d, S)."""
        rng = np.random.Generator(np.random.Philox(key=SEED + 1))
        return rng.uniform(-1.0, 1.0, (self.dimension, self.states))

    def _all(self, t: float, x: Array) -> Array:
        return with_rows(x, t)[None]

    def _own(self, t: float, x: Array) -> Array:
        """Return x_j, p and t for each j, shape (M, k, P)."""
        beside = with_rows(x[self.motions :], t)
        own = np.broadcast_to(beside, (self.motions, *beside.shape))
        return np.concatenate([x[: self.motions, None], own], axis=1)

    def drift(self, t: float, x: Array) -> Array:
        """Return f, shape (d, P)."""
        return self._still(self._sines[0].derivative(self._all(t, x), ()))

    def diffusion(self, t: float, x: Array) -> Array:
        """Return B, shape (d, d, P)."""
        return self._on_diagonal(self._still(self._sines[1].derivative(self._own(t, x), ())))

    def diffusion_derivative(self, t: float, x: Array, y: Array) -> Array:
        """Return DB(x) y, shape (d, d, P).

        Parameters
        ----------
        t : float
        x, y : ndarray, shape (d, P)
            State and direction.
        """
        return self._on_diagonal(self._still(self._sines[1].derivative(self._own(t, x), (self._own(0.0, y),))))

    def _still(self, moving: Array) -> Array:
        return with_rows(moving, *[0.0] * STILL)

    def _on_diagonal(self, entries: Array) -> Array:
        columns: Array = np.eye(self.dimension)[..., None] * entries
        return columns

    @cached_property
    def sde(self) -> SDE:
        """The equation as a problem."""
        return self._as_sde(self.drift, self.diffusion, self.x[:, 0], diffusion_derivative=self.diffusion_derivative)

    @cached_property
    def distant(self) -> tuple[Relatives, ...]:
        """The equation far out, X = `FAR` x + C with its components placed among five, and at random times."""
        rng = np.random.Generator(np.random.Philox(key=SEED + 2))
        C = FAR * rng.uniform(-1.0, 1.0, (PLACES + STILL, 1))
        placed = far_problems.placements(self.motions)
        pairs = [
            self._far(placed[k % len(placed)], C, *each) for k, each in enumerate(far_problems.distant_delays(rng))
        ]
        return far_problems.among(pairs, far_problems.far_states(rng, PLACES + STILL))

    def _far(self, placed: Array, C: Array, delay: float, later: float) -> Relatives:
        """Return a pair of the equation far out and this one, both delayed."""
        S = scipy.linalg.block_diag(placed, np.eye(STILL))
        above = self._as_sde(
            lambda t, x: FAR * (S.T @ self.drift(t - delay, S @ (x - C) / FAR)),
            lambda t, x: FAR * np.einsum("ij,ikp,kl->jlp", S, self.diffusion(t - delay, S @ (x - C) / FAR), S),
            C[:, 0],
        )
        below = self._as_sde(
            lambda t, x: self.drift(t - later, x), lambda t, x: self.diffusion(t - later, x), self.x[:, 0]
        )
        return Relatives(below, above, {"x": (S / FAR, -S @ C / FAR)}, S, later, delay=delay)

    def _as_sde(self, drift: Coefficient, diffusion: Coefficient, start: Array, **given: Any) -> SDE:
        return SDE(
            drift=drift,
            diffusion=diffusion,
            start=start,
            noise_dim=len(start),
            noise=NOISE,
            traits=frozenset({"diagonal-noise"}),
            horizon=1.0,
            source="random equation with diagonal noise",
            **given,
        )

    def elementary(self, trees: Sequence[Tree]) -> Array:
        """Return F(tau) at all states, shape (N, M, S); each tree must come after its subtrees."""
        found: dict[Tree, Array] = {}
        z, own = self._all(TIME_0, self.x), self._own(TIME_0, self.x)
        for each in trees:
            vectors = [None if kid.colour == TIME else found[kid] for kid in each.kids]
            if each.colour == DRIFT:
                found[each] = self._sines[0].derivative(z, [self._direction(v) for v in vectors])
                continue
            j = each.colour - 1
            moving = self._sines[1].derivative(own, [self._own_direction(v) for v in vectors])
            found[each] = np.where(np.arange(self.motions)[:, None] == j, moving, 0.0)
        return np.array([found[each] for each in trees])

    @cached_property
    def unknowns(self) -> list[Unknowns]:
        """Linear equations for the weights of the basis, by weight."""
        trees = closure(self.basis)
        differentials = dict(zip(trees, self.elementary(trees), strict=True))
        found = []
        for weight in sorted({each.weight for each in self.basis}):
            rows = [i for i, each in enumerate(self.basis) if each.weight == weight]
            some = [self.basis[i] for i in rows]
            matrix = np.array([differentials[each].ravel() / each.symmetry for each in some]).T
            Q, R = np.linalg.qr(matrix)
            found.append(Unknowns(weight, rows, matrix, np.linalg.solve(R, Q.T)))
        return found

    def _direction(self, vector: Array | None) -> Array:
        """Return a direction in (x, p, t); the time direction if `vector` is None."""
        whole = np.zeros((1, self.dimension + 1, self.states))
        if vector is None:
            whole[0, -1] = 1.0
        else:
            whole[0, : self.motions] = vector
        return whole

    def _own_direction(self, vector: Array | None) -> Array:
        own = np.zeros((self.motions, STILL + 2, self.states))
        own[:, -1 if vector is None else 0] = 1.0 if vector is None else vector
        return own


class TaylorWeights(NamedTuple):
    """Weights of trees from a power series.

    Attributes
    ----------
    psi : ndarray, shape (n, K)
        Weights of the trees of a basis, in units of h^(w/2).
    no_series : float
        Distance of steps from a power series in sqrt(h).
    no_trees : mapping of int to float
        Distance of its coefficients from sums over trees of each weight, as an error of psi.
    """

    psi: Array
    no_series: float
    no_trees: Mapping[int, float]


def taylor_weights(scheme: Scheme, equation: RichEquation, nodes: Nodes) -> TaylorWeights:
    """Compute the weights of trees from the Taylor series of a scheme's steps.

    Parameters
    ----------
    scheme : Scheme
    equation : RichEquation
    nodes : Nodes
        Noise of a step of length 1, of the M Brownian motions of the equation.

    Raises
    ------
    NoStepError
        If a step is truncated or fails.
    """
    count = len(nodes.weights)
    series, no_series = _series(scheme, equation, nodes)
    psi, no_trees = np.empty((len(equation.basis), count)), dict[int, float]()
    for each in equation.unknowns:
        wanted = series[each.weight - 1].reshape(-1, count)
        psi[each.rows] = each.inverse @ wanted
        left = np.sqrt(np.max(np.mean((each.matrix @ psi[each.rows] - wanted) ** 2, axis=0)))
        no_trees[each.weight] = float(left * each.gain)
    return TaylorWeights(psi, no_series, no_trees)


def _series(scheme: Scheme, equation: RichEquation, nodes: Nodes) -> tuple[Array, float]:
    """Return the coefficients of powers of sqrt(h), shape (W, M, S K), and their error at a further step size."""
    step, wide = OneStep(scheme, equation.sde), _with_still(nodes)
    x = np.repeat(equation.x, len(nodes.weights), axis=1)

    def moved(root: float) -> Array:
        return np.asarray(stepped(step, x, wide, root**2) - x)[: equation.motions]

    roots, to_coefficients = _sizes()
    powers = np.arange(1, POWERS + 1)
    series = np.tensordot(to_coefficients, [moved(root) for root in roots.tolist()], axes=1)
    between = np.tensordot((BETWEEN / LONGEST) ** powers, series, axes=1)
    return series / LONGEST ** powers[:, None, None], float(np.max(np.abs(moved(BETWEEN) - between)))


@cache
def _sizes() -> tuple[Array, Array]:
    """Return the square roots of the step sizes, shape (SIZES,), and the map from steps to scaled coefficients."""
    roots = 0.5 * LONGEST * (1.0 - np.cos(np.pi * (np.arange(SIZES) + 0.5) / SIZES))
    return roots, np.linalg.pinv((roots[:, None] / LONGEST) ** np.arange(1, POWERS + 1))


def _with_still(nodes: Nodes) -> Nodes:
    """Return noise with additional motions of zero coefficient; areas are irrelevant for diagonal noise."""

    def more(part: Array | None) -> Array | None:
        return None if part is None else np.concatenate([part, *[part[:1]] * STILL])

    l = len(nodes.dW) + STILL
    dW = np.concatenate([nodes.dW, *[nodes.dW[:1]] * STILL])
    A = np.zeros((l * (l - 1) // 2, len(nodes.weights)))
    return nodes._replace(dW=dW, H=more(nodes.H), K=more(nodes.K), A=A)
