"""The universal SDE of a class, whose components are the trees: a step on it gives their elementary weights.

    dx_tau = prod_i x_tau_i dW_c    for tau = [tau_1, ..., tau_k]_c,  with dW_0 = dt and t - t_0 in place of a leaf t

has F(tau)(0) = sigma(tau) e_tau at the origin. Component tau of the solution is the iterated integral I(tau), and
component tau of a step that is a B-series x + sum phi(tau)/sigma(tau) F(tau)(x) is phi(tau). The origin is moved to a
nonzero point c and a nonzero time t_0, because a step with coefficients taken at 0.98 x is correct at zero.

Coefficients are made of NumPy functions without assignment, so that solvers of other libraries can run them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from sdaeverify import SDE, Array
from sdaeverify.trees import far_problems

from ..grow import DRIFT, TIME_LEAF, Tree

TIME_0 = far_problems.TIME_0

# Noise that the problem declares; its horizon is 1.
NOISE = frozenset({"dW", "H", "K", "A"})


@dataclass(frozen=True, eq=False)
class Universal:
    """Coefficients of the universal SDE.

    Attributes
    ----------
    trees : sequence of Tree
        Trees, each after its subtrees.
    motions : int
        Number of Brownian motions; without noise, one with zero coefficient.
    traits : frozenset of str
        Traits of the class.
    """

    trees: Sequence[Tree]
    motions: int
    traits: frozenset[str] = frozenset()

    @property
    def origin(self) -> Array:
        """Point c, shape (N, 1)."""
        return np.asarray(0.75 * np.cos(1.0 + 2.0 * np.arange(len(self.trees))))[:, None]

    @cached_property
    def kids(self) -> Array:
        """Indices of the factors of each tree, shape (N, K): N is a factor of 1, and N + 1 is t - t_0."""
        places = {each: place for place, each in enumerate(self.trees)} | {TIME_LEAF: len(self.trees) + 1}
        most = max((len(each.kids) for each in self.trees), default=0)
        kids = np.full((len(self.trees), max(most, 1)), len(self.trees))
        for row, each in zip(kids, self.trees, strict=True):
            row[: len(each.kids)] = [places[kid] for kid in each.kids]
        return kids

    @property
    def colours(self) -> Array:
        """Colours of the roots, shape (N,)."""
        return np.array([each.colour for each in self.trees])

    @property
    def sde(self) -> SDE:
        """The universal SDE as a problem."""
        is_constant = "additive-noise" in self.traits
        return class_sde(
            self.traits,
            drift=self.drift,
            diffusion=self.constant_diffusion if is_constant else self.diffusion,
            diffusion_derivative=None if is_constant else self.diffusion_derivative,
            start=self.origin[:, 0],
            noise_dim=self.motions,
            source="universal SDE of rooted trees",
        )

    def drift(self, t: float, x: Array) -> Array:
        """Return f, shape (N, P)."""
        moved: Array = (self.colours == DRIFT)[:, None] * self._products(t, x)
        return moved

    def diffusion(self, t: float, x: Array) -> Array:
        """Return B, shape (N, M, P)."""
        return self._in_columns(self._products(t, x))

    def constant_diffusion(self, _t: float, _x: Array) -> Array:
        """Return B of additive noise, shape (N, M, 1)."""
        return self._in_columns(np.ones((len(self.trees), 1)))

    def diffusion_derivative(self, t: float, x: Array, y: Array) -> Array:
        """Return DB(x) y, shape (N, M, P).

        Parameters
        ----------
        t : float
        x, y : ndarray, shape (N, P)
            State and direction.
        """
        moved = with_rows(y, 0.0, 0.0)
        first, *others = (part * moved[kids] for kids, part in self._cofactors(t, x))
        return self._in_columns(sum(others, first))

    def _products(self, t: float, x: Array) -> Array:
        product: Array = np.prod(self._factors(t, x), axis=0)
        return product

    def _cofactors(self, t: float, x: Array) -> list[tuple[Array, Array]]:
        """Return for each factor position the component and the product of the other factors."""
        factors, places = self._factors(t, x), np.arange(self.kids.shape[1])
        return [(kids, np.prod(factors[np.delete(places, k)], axis=0)) for k, kids in enumerate(self.kids.T)]

    def _factors(self, t: float, x: Array) -> Array:
        return with_rows(x - self.origin, 1.0, t - TIME_0)[self.kids.T]

    def _in_columns(self, values: Array) -> Array:
        columns: Array = (self.colours[:, None] == np.arange(1, self.motions + 1))[..., None] * values[:, None]
        return columns


@dataclass(frozen=True, kw_only=True, eq=False)
class ClassSDE(SDE):
    """An SDE that declares the traits of a class without checking them.

    The universal SDE of a quotient does not satisfy its relations: any equation is used, and the conditions modulo
    the relations are tested on it.
    """

    def _check_traits(self, x: Array) -> None:
        pass

    def _grows_linearly(self) -> bool:
        # Classes contain equations to which the theorems on orders in mean square apply.
        return True


def class_sde(traits: frozenset[str], **given: Any) -> SDE:
    """Return an SDE that declares the traits of a class, with all noise drawn.

    Parameters
    ----------
    traits : frozenset of str
        Traits of the class.
    **given
        Further arguments of `SDE`.
    """
    return ClassSDE(noise=NOISE, horizon=1.0, traits=traits, **given)


def with_rows(x: Array, *values: float) -> Array:
    """Append a constant row for each value to an array, shape (d + k, P).

    Parameters
    ----------
    x : ndarray, shape (d, P)
    *values : float
    """
    return np.concatenate([x, *(value + 0.0 * x[:1] for value in values)])
