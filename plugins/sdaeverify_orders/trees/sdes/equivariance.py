"""Test whether a step commutes with affine maps between spaces of different dimensions.

A map from vector fields to steps is a B-series if and only if it commutes with them (McLachlan, Modin, Munthe-Kaas &
Verdier 2016). Invertible maps would admit series with traces, such as (tr DB_1) B_1, which the universal SDE cannot
detect because its derivatives are nilpotent. For y = A x + c with A from R^5 onto R^2 and a field g on R^2,

    G(t, x) = A^+ g(t + s, A x + c) + N k(t, x),    A N = 0,

is related to g for every k, so that A Phi_G(t, x) + c = Phi_g(t + s, A x + c) on each path. The shift s of time
detects a step that takes a coefficient at time 0 instead of t, because trees of low weight have no leaf t.

The test is repeated with equations `above` that are far out, X = 2^20 x + C with some of five motions, and with both
equations at random times: a step that clips at 10, freezes coefficients at t = 1, is different at each eighth
multiple of its size or scales the fourth motion commutes with the maps of the first pair.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from sdaeverify import SDE, Array, Scheme
from sdaeverify.probing import Nodes, OneStep
from sdaeverify.trees import Relatives, far_problems

from ..classes import EquationClass
from ..weights import stepped
from .universal import class_sde, with_rows

FAR, LATER = far_problems.FAR, far_problems.LATER

LOW, HIGH = 2, 5
# Step size, short because Newton's method finds roots of random polynomials only for short steps.
H = 2.0**-4
SEED = 20260102
# Sizes of the terms of a random field.
CONSTANT, LINEAR, QUADRATIC = 0.7, 0.4, 0.1

Coefficient = Callable[[float, Array], Array]


@dataclass(frozen=True, eq=False)
class Fields:
    """Random quadratic coefficients in R^d, which depend on time.

    Attributes
    ----------
    constant : ndarray, shape (d, n)
        Constant terms, one column for each of n fields.
    linear : ndarray, shape (d, n, d + 1)
        Coefficients of the components and of time.
    quadratic : ndarray, shape (d, n, d + 1, d + 1)
    """

    constant: Array
    linear: Array
    quadratic: Array

    def __call__(self, t: float, x: Array) -> Array:
        """Evaluate all fields, shape (d, n, P)."""
        z = with_rows(x, t)
        bent: Array = np.einsum("dnij,ip,jp->dnp", self.quadratic, z, z)
        straight: Array = np.einsum("dni,ip->dnp", self.linear, z)
        return self.constant[..., None] + straight + bent

    def straight(self) -> "Fields":
        """Return the fields without quadratic terms and without dependence on time."""
        of_state = np.append(np.ones(self.linear.shape[2] - 1), 0.0)
        return Fields(self.constant, of_state * self.linear, 0.0 * self.quadratic)

    def frozen(self) -> "Fields":
        """Return the constant parts of the fields."""
        return Fields(self.constant, 0.0 * self.linear, 0.0 * self.quadratic)


def random_fields(rng: np.random.Generator, rows: int, fields: int, dimension: int) -> Fields:
    """Return random quadratic fields with `rows` components on a space of dimension `dimension`.

    Parameters
    ----------
    rng : numpy.random.Generator
    rows, fields, dimension : int
        Components and number of the fields, and dimension of the space.
    """
    d = dimension + 1
    normal = rng.standard_normal
    return Fields(
        CONSTANT * normal((rows, fields)),
        LINEAR * normal((rows, fields, d)),
        QUADRATIC * normal((rows, fields, d, d)),
    )


@dataclass(frozen=True, eq=False)
class Family:
    """Coefficients of two random equations of a class, and the affine map y = A x + c that relates them.

    Attributes
    ----------
    kind : EquationClass
        Class; for a quotient, the equations need not satisfy its relations, because a step does not depend on them.
    map : ndarray, shape (2, 5)
        Matrix A.
    shift : ndarray, shape (2, 1)
        Shift c.
    below, above : tuple of callable
        Coefficients f and B in R^2 and in R^5; (t, x) of `above` corresponds to (t + `LATER`, y) of `below`.
    start : ndarray, shape (5,)
    calls : list
        Gains an element with each call of the drift of `below` at complex states.
    """

    kind: EquationClass
    map: Array
    shift: Array
    below: tuple[Coefficient, Coefficient]
    above: tuple[Coefficient, Coefficient]
    start: Array
    calls: list[None] = field(default_factory=list)

    @cached_property
    def near(self) -> Relatives:
        """The two equations near the origin."""
        f, B = self.below
        below = _equation(self.kind, f, B, self._start_below, self.calls)
        above = _equation(self.kind, *self.above, self.start, [])
        return Relatives(below, above, {"x": (self.map, self.shift)}, self._motions, LATER)

    @property
    def _start_below(self) -> Array:
        return np.asarray(self.map @ self.start + self.shift[:, 0])

    @property
    def _motions(self) -> Array:
        return np.eye(self.above[1](0.0, self.start[:, None]).shape[1])

    @cached_property
    def distant(self) -> tuple[Relatives, ...]:
        """Pairs with `above` as X = `FAR` x + C, its motions placed among five, and with both at random times.

        Empty for a linear class, because schemes that read A and a of A x + a from values at unit vectors would lose
        A to rounding of a.
        """
        if self.kind.linear:
            return ()
        rng = np.random.Generator(np.random.Philox(key=SEED + 1))
        placed = far_problems.placements(len(self._motions)) if self.kind.motions is None else [self._motions]
        pairs = [self._far(placed[k % len(placed)], *each) for k, each in enumerate(far_problems.distant_delays(rng))]
        return far_problems.among(pairs, far_problems.far_states(rng, HIGH))

    def _far(self, placed: Array, delay: float, later: float) -> Relatives:
        """Return a pair whose equations above and below are delayed."""
        (f, B), (F, K), A = self.below, self.above, self.map
        late, C = later - LATER, -FAR * self.start[:, None]
        below = _equation(self.kind, lambda t, y: f(t - late, y), lambda t, y: B(t - late, y), self._start_below, [])
        above = _equation(
            self.kind,
            lambda t, x: FAR * F(t - delay, (x - C) / FAR),
            lambda t, x: FAR * np.einsum("dlp,lm->dmp", K(t - delay, (x - C) / FAR), placed),
            0.0 * self.start,
            [],
        )
        maps = {"x": (A / FAR, self.shift - A @ C / FAR)}
        return Relatives(below, above, maps, placed, later, delay=delay)

    def uses_drift_derivative(self, scheme: Scheme, nodes: Nodes) -> bool:
        """Return whether a step of a scheme calls the derivative of the drift, as an implicit one does.

        Parameters
        ----------
        scheme : Scheme
        nodes : Nodes
            Nodes of the noise of the step.
        """
        before, below = len(self.calls), self.near.below
        stepped(OneStep(scheme, below), below.initial(len(nodes.weights)), nodes, H)
        return len(self.calls) > before


@lru_cache(maxsize=16)
def related_equations(kind: EquationClass, motions: int) -> Family:
    """Return equations of a class that are related by affine maps, cached for all schemes.

    Parameters
    ----------
    kind : EquationClass
        Class; for a quotient, the equations need not satisfy its relations.
    motions : int
        Number of Brownian motions; 0 for zero noise.
    """
    rng = np.random.Generator(np.random.Philox(key=SEED))
    A, shift = rng.standard_normal((LOW, HIGH)), rng.standard_normal((LOW, 1))
    inverse, kernel = np.linalg.pinv(A), np.linalg.svd(A)[2][LOW:].T
    f, k = random_fields(rng, LOW, 1, LOW), random_fields(rng, HIGH - LOW, 1, HIGH)
    B, K = (random_fields(rng, rows, max(motions, 1), d) for rows, d in ((LOW, LOW), (HIGH - LOW, HIGH)))
    if kind.linear:
        f, k, B, K = (each.straight() for each in (f, k, B, K))
    if kind.additive:
        B, K = B.frozen(), K.frozen()
    share = 1.0 if motions else 0.0

    def lifted(below: Fields, beside: Fields, scale: float) -> Coefficient:
        return lambda t, x: scale * (_times(inverse, below(t + LATER, A @ x + shift)) + _times(kernel, beside(t, x)))

    below, above = (f, lambda t, x: share * B(t, x)), (lifted(f, k, 1.0), lifted(B, K, share))
    return Family(kind, A, shift, below, above, 0.5 * np.cos(np.arange(1.0, HIGH + 1.0)))


def _times(matrix: Array, fields: Array) -> Array:
    product: Array = np.einsum("ij,jnp->inp", matrix, fields)
    return product


def _equation(kind: EquationClass, f: Coefficient, B: Coefficient, start: Array, calls: list[None]) -> SDE:
    def drift(t: float, x: Array) -> Array:
        # Complex arguments occur in derivatives by complex steps.
        if isinstance(x, np.ndarray) and np.iscomplexobj(x):
            calls.append(None)
        return f(t, x)[:, 0]

    return class_sde(
        kind.traits,
        drift=drift,
        diffusion=B,
        start=start,
        noise_dim=B(0.0, start[:, None]).shape[1],
        source="random polynomials",
    )
