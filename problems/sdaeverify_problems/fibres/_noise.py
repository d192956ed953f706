"""Noise of a fibre, Lindner et al. (2018), (2.8): independent white noise at each point."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array

from ._fibre import Fibre


class FibreNoise(NamedTuple):
    """Noise coefficient (B dw)_i = ds^{-1/2} (A_{i+1/2} + A_{i-1/2})/2 dw_i with A = Dr^{-2} beta C D on edges."""

    fibre: Fibre

    @property
    def strength(self) -> float:
        """The number beta Dr^{-2} ds^{-1/2}, the coefficient if C and D are the identity."""
        return self.fibre.beta / (self.fibre.Dr**2 * np.sqrt(self.fibre.chain.ds))

    @property
    def additive(self) -> bool:
        """Whether C and D are the identity."""
        return self.fibre.C is None and self.fibre.D is None

    @property
    def traits(self) -> frozenset[str]:
        """Traits of the problem: if the noise does not depend on v, DB_j B_k = 0, because it acts on v only."""
        if self.fibre.D is not None:
            return frozenset()
        return frozenset({"additive-noise" if self.additive else "vanishing-milstein-term"})

    def matrix(self, t: float, r: Array, v: Array) -> Array:
        """Return B, shape (n, n, P), or (n, n, 1) if it is constant."""
        n, (N, d, *_) = len(r), self.fibre.chain
        if self.additive:
            return self.strength * np.eye(n)[..., None]
        blocks = np.moveaxis(self._blocks(t, r, v), 2, 0)
        B = np.zeros((N, d, N, d, blocks.shape[-1]), dtype=blocks.dtype)
        B[np.arange(N), :, np.arange(N)] = blocks
        return B.reshape(n, n, -1)

    def product(self, t: float, r: Array, v: Array, w: Array) -> Array:
        """Return B w, shape (n, P), for w of shape (n, P)."""
        if self.additive:
            return self.strength * w
        points = self.fibre.chain.points(w)
        return np.einsum("abip,ibp->iap", self._blocks(t, r, v), points).reshape(w.shape)

    def _blocks(self, t: float, r: Array, v: Array) -> Array:
        # Return the diagonal blocks of B, shape (d, d, N, P).
        chain, C, D = self.fibre.chain, self.fibre.C, self.fibre.D
        x, y, tau = self.fibre.edges(chain.positions(r), chain.velocities(v))
        factors = [A for A in (C and C(x, tau, t), D and D(x, y, tau, t)) if A is not None]
        A = factors[0] if len(factors) == 1 else np.einsum("ab...,bc...->ac...", *factors)
        A = np.broadcast_to(A, (*A.shape[:2], chain.N + 1, A.shape[-1]))
        return (0.5 * self.strength) * (A[:, :, 1:] + A[:, :, :-1])
