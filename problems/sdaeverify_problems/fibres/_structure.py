"""Coupling structure of a fibre with derivatives in closed form, in O(N) operations per path."""

from dataclasses import dataclass

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Structure
from sdaeverify.numerics import BlockBanded, directional

from ._chain_matrices import scalar_matrices
from ._fibre import Fibre


@dataclass(frozen=True, eq=False, kw_only=True)
class FibreStructure(Structure):
    """Structure with one node per point: forces couple points up to distance two, constraints adjacent ones.

    Attributes
    ----------
    fibre : Fibre
    bending : BlockBanded
        -alpha^{-2} ds^{-4} S, blocks of shape (d, d, 1), of bandwidth min(2, N - 1).
    before, behind : ndarray, shape (3, N, 1, 1, 1)
        Dr^{-2}/2 times the weights of the points i - 1, i, i + 1 in the edges i - 1/2 and i + 1/2.
    """

    fibre: Fibre
    bending: BlockBanded
    before: Array
    behind: Array

    def force_blocks(self, problem: HolonomicSDAE, t: float, r: Array, v: Array) -> tuple[BlockBanded, BlockBanded]:
        """Return d_r a = -alpha^{-2} ds^{-4} S + Dr^{-2} <Du> and d_v a = -Dr^{-2} <1> with edge means <.>."""
        if self.fibre.C is not None:
            return super().force_blocks(problem, t, r, v)
        Du = self._flow_derivative(t, r)
        pulled = self.before * Du[:-1] + self.behind * Du[1:]
        one = np.eye(self.fibre.chain.d)[..., None]
        return self.bending + BlockBanded(pulled, 1), BlockBanded(-(self.before + self.behind) * one, 1)

    def constraint_blocks(self, problem: HolonomicSDAE, r: Array) -> BlockBanded:
        """Return Dg(r): the rows e_i^T/ds^2 of point i - 1 and -e_i^T/ds^2 of point i."""
        return self._pairs(self.fibre.chain.edges(r))

    def curvature_rows(self, problem: HolonomicSDAE, r: Array, v: Array) -> BlockBanded:
        """Return v^T Hess g: the rows of `constraint_blocks` with v_i - v_{i-1} in place of e_i."""
        return self._pairs(self.fibre.chain.differences(v))

    def curvature_sum(self, problem: HolonomicSDAE, r: Array, c: Array) -> BlockBanded:
        """Return H(c): multiples of Id, -(c_{i-1/2} + c_{i+1/2})/ds^2 on the diagonal and c/ds^2 next to it."""
        own = self.by_slot(c)[:, 0] / self.fibre.chain.ds**2
        after = np.concatenate([own[1:], np.zeros_like(own[:1])])
        rows = np.stack([own, -(own + after), after])
        rows[0, 0] = 0.0
        return BlockBanded(rows[:, :, None, None] * np.eye(self.fibre.chain.d)[..., None], 1)

    def _pairs(self, e: Array) -> BlockBanded:
        rows = self.by_slot(e)[:, :, : self.fibre.chain.d] / self.fibre.chain.ds**2
        blocks = np.stack([rows, -rows])
        blocks[0, 0] = 0.0
        return BlockBanded(blocks, 1)

    def _flow_derivative(self, t: float, r: Array) -> Array:
        # Return Du on all edges, shape (N + 1, d, d, P).
        chain, flow = self.fibre.chain, self.fibre.flow
        x = chain.positions(r)
        middle = np.moveaxis(0.5 * (x[1:] + x[:-1]), 1, 0)
        units = np.eye(chain.d)[..., None, None]
        Du = np.stack([directional(lambda y: flow(y, t), middle, unit) for unit in units], axis=1)
        return np.broadcast_to(np.moveaxis(Du, 2, 0), (chain.N + 1, *Du.shape[:2], Du.shape[-1]))


def fibre_structure(fibre: Fibre) -> FibreStructure:
    """Return the structure of a fibre; the first point has a constraint only if the chain is clamped."""
    chain, d = fibre.chain, fibre.chain.d
    (S, W), bends = scalar_matrices(chain), min(2, chain.N - 1)
    bending, scale = -(fibre.alpha**-2) / chain.ds**4, 0.5 / fibre.Dr**2
    return FibreStructure(
        nodes=chain.N,
        owners=tuple(range(1 if chain.root is None else 0, chain.N)),
        width=2,
        reach=1,
        fibre=fibre,
        bending=BlockBanded(bending * _diagonals(S, bends) * np.eye(d)[..., None], bends),
        before=scale * _diagonals(W[:-1], 1),
        behind=scale * _diagonals(W[1:], 1),
    )


def _diagonals(matrix: Array, width: int) -> Array:
    # Return the diagonals of a matrix, shape (N, N), up to offset `width`, by rows: shape (2 width + 1, N, 1, 1, 1).
    N = len(matrix)
    diagonals = np.zeros((2 * width + 1, N, 1, 1, 1))
    for k in range(-width, width + 1):
        rows = np.arange(max(0, -k), min(N, N - k))
        diagonals[k + width, rows, 0, 0, 0] = matrix[rows, rows + k]
    return diagonals
