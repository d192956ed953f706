"""The noise of one step as one array of independent standard normals."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...noise.laws import Law
from .nodes import SEED, Nodes, count_atoms, gauss_hermite, step_nodes, tensor_rule
from .one_step import OneStep

# Multiples of random signs, in standard deviations, at which a function is tested for being affine in the noise.
# Size: of the trial noises.
REACH = (0.5, 2.0, 5.0, 9.5, 30.0, 60.0)
# Size: trial noises.
DIRECTIONS = 4
# Random points; a region with a share of 1/100 of the noise is missed with probability 0.99^256 = 0.08.
# Size: trial noises.
SCATTERED = 256
# Most nodes of a rule: the step is evaluated at that many noises for k + 1 states.
# Size: of a rule.
LARGEST = 7_000
# Number from which atoms are many, and the tolerance of their first two moments.
# Size: atoms of which all are used.
# Rounding: sums over up to 7000 atoms err by 7000 eps = 1.6e-12 at most; where they do, all atoms are used.
MANY, STANDARD = 100, 1e-12
# Standard deviations outside which the normal law has a mass of 1e-21.
# Rounding: 1e-21 is less than EPS.
CUT = 9.5


class StepNoise(NamedTuple):
    """Variables that drive a scheme's step.

    Attributes
    ----------
    motions : int
        Number l of Brownian motions.
    areas : bool
        Whether the scheme uses H as well as dW.
    law : Law
    """

    motions: int
    areas: bool
    law: Law

    @classmethod
    def of(cls, one_step: OneStep) -> "StepNoise":
        """Return the noise of a scheme's step on a problem."""
        return cls(one_step.view.noise_dim, "H" in one_step.scheme.noise, one_step.scheme.law)

    @property
    def normals(self) -> int:
        """Number n of variables: l, or 2 l with H."""
        return self.motions * (2 if self.areas else 1)

    @property
    def tractable(self) -> bool:
        """Whether all atoms of a discrete law can be enumerated; True for a normal law."""
        return not self.law.bounded or count_atoms(self.law.atoms(self.motions, areas=self.areas)) <= LARGEST

    @property
    def has_many_atoms(self) -> bool:
        """Whether the law has many atoms, of mean 0 and covariance Id: affine functions need fewer points."""
        atoms = self.rule(0) if self.law.bounded else None
        if atoms is None or len(atoms.weights) < MANY:
            return False
        x = atoms.dW if atoms.H is None else np.concatenate([atoms.dW, np.sqrt(12.0) * atoms.H])
        moments = np.abs(x @ atoms.weights).max(), np.abs((x * atoms.weights) @ x.T - np.eye(len(x))).max()
        return bool(max(moments) <= STANDARD)

    def nodes(self, x: Array, weights: Array | None = None) -> Nodes:
        """Return K nodes of a step of length 1 from standard normal values x, shape (n, K); weights default to 1."""
        H = x[self.motions :] / np.sqrt(12.0) if self.areas else None
        return Nodes(x[: self.motions], H, np.ones(x.shape[1]) if weights is None else weights)

    def rule(self, count: int) -> Nodes | None:
        """Return the atoms, or the product of Gauss-Hermite rules with `count` nodes; None if it is too large."""
        if not self.law.bounded and count**self.normals > LARGEST:
            return None
        return _nodes(self, count)

    def split_rule(self, count: int) -> Nodes | None:
        """Return the product of Gauss-Legendre rules with `count` nodes on both sides of 0; None if too large."""
        if self.law.bounded or (2 * count) ** self.normals > LARGEST:
            return None
        q, w = np.polynomial.legendre.leggauss(count)
        half = 0.5 * CUT * (1.0 + q)
        z = np.concatenate([-half, half])
        weights = np.tile(0.5 * CUT * w, 2) * np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)
        rule = tensor_rule([(z, weights)] * self.normals)
        return self.nodes(rule.x, rule.weights)

    def simplex(self) -> Array:
        """Return the vertices v_0, ..., v_n of a regular simplex with sum v_i = 0 and sum v_i v_i^T = (n + 1) Id.

        With equal weights they are a rule of degree 2 with the fewest nodes.
        """
        # Helmert's orthogonal matrix without its constant row.
        n = self.normals
        rows = np.tril(np.ones((n, n + 1))) - np.eye(n, n + 1, 1) * np.arange(1, n + 1)[:, None]
        return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True) * np.sqrt(n + 1.0))

    def trials(self) -> Array:
        """Return points that reach 60 standard deviations in every variable, shape (n, 12)."""
        rng = np.random.Generator(np.random.Philox(key=SEED + 3))
        signs = rng.choice([-1.0, 1.0], size=(self.normals, len(REACH)))
        return np.concatenate([signs * REACH, -signs * REACH], axis=1)

    def scattered(self) -> Array:
        """Return many random normal points, shape (n, P): a small region of the noise has one of them."""
        return np.random.Generator(np.random.Philox(key=SEED + 24)).standard_normal((self.normals, SCATTERED))

    def directions(self) -> Array:
        """Return unit vectors along the axes and in some random directions, shape (n, D)."""
        if self.normals == 1:
            return np.ones((1, 1))
        rng = np.random.Generator(np.random.Philox(key=SEED + 4))
        further = rng.standard_normal((self.normals, DIRECTIONS))
        return np.concatenate([np.eye(self.normals), further / np.linalg.norm(further, axis=0)], axis=1)


@lru_cache(maxsize=64)
def _nodes(noise: StepNoise, count: int) -> Nodes:
    if noise.law.bounded:
        return step_nodes(noise.motions, count, areas=noise.areas, law=noise.law)
    rule = tensor_rule([gauss_hermite(count)] * noise.normals)
    return noise.nodes(rule.x, rule.weights)
