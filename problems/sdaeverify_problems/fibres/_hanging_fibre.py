"""Small transverse motion of the straight hanging fibre: exact law of y'' = -K y - D y' + F + sigma W'.

The equation is linear: with z = (y, y') and its generator A, mean and covariance are given by matrix exponentials,
and one step of a scheme without noise is a matrix.
"""

from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array

from ._chain_matrices import scalar_matrices
from ._fibre import Fibre
from ._noise import FibreNoise


class HangingFibre(NamedTuple):
    """Matrices of the equation for y_1..y_N, the displacements perpendicular to a straight fibre.

    Attributes
    ----------
    K : ndarray, shape (N, N)
        alpha^{-2} ds^{-4} S for bending, plus the second difference with edge weights lambda/ds^2 for the tension
        lambda_{i-1/2} = Fr^{-2} (1 - s_{i-1/2}).
    D : ndarray, shape (N, N)
        Dr^{-2} times the mean over edges.
    F : ndarray, shape (N,)
        -Dr^{-2} flow s_i.
    sigma : float
        beta Dr^{-2} ds^{-1/2}.
    """

    K: Array
    D: Array
    F: Array
    sigma: float

    @property
    def generator(self) -> Array:
        """Matrix A of z' = A z + (0, F) + (0, sigma W'), shape (2 N, 2 N)."""
        zero = np.zeros_like(self.K)
        return np.block([[zero, np.eye(len(self.K))], [-self.K, -self.D]])

    @property
    def noise(self) -> Array:
        """Noise coefficient (0, sigma), shape (2 N, N)."""
        return np.concatenate([np.zeros_like(self.K), self.sigma * np.eye(len(self.K))])

    def mean(self, t: float) -> Array:
        """Return E z(t) for z(0) = 0, shape (2 N,)."""
        N = len(self.F)
        augmented = np.zeros((2 * N + 1, 2 * N + 1))
        augmented[:-1, :-1], augmented[N:-1, -1] = self.generator, self.F
        mean: Array = scipy.linalg.expm(t * augmented)[:-1, -1]
        return mean

    def covariance(self, t: float) -> Array:
        """Return Cov z(t) for a deterministic start, shape (2 N, 2 N).

        C(t) = int_0^t e^{sA} Q e^{sA^T} ds, Q = sigma^2 on y', is a block of a single exponential (Van Loan), which
        is accurate for short times only; then C(2t) = C(t) + e^{tA} C(t) e^{tA^T}, a sum of positive terms.
        """
        A = self.generator
        n, Q = len(A), self.noise @ self.noise.T
        doublings = int(np.ceil(np.log2(1.0 + t * np.linalg.norm(A, 1))))
        exponential = scipy.linalg.expm(t / 2**doublings * np.block([[-A, Q], [np.zeros_like(A), A.T]]))
        flow = exponential[n:, n:].T
        covariance: Array = flow @ exponential[:n, n:]
        for _ in range(doublings):
            covariance = covariance + flow @ covariance @ flow.T
            flow = flow @ flow
        return covariance

    def explicit_limit(self) -> float:
        """Return the largest stable step size of (B) and half-explicit: y+ = y + h y', y'+ = y' - h (K y + D y').

        The step has the matrix 1 + h A; its eigenvalues 1 + h nu are in the unit disc if 2 Re nu + h |nu|^2 <= 0.
        """
        nu = np.linalg.eigvals(self.generator)
        return float((-2.0 * nu.real / np.abs(nu) ** 2).min())


def hanging_fibre(fibre: Fibre, flow: float) -> HangingFibre:
    """Return the linearised clamped fibre, straight down, in the flow u = flow (x_2, -x_1); C and D are Id."""
    chain = fibre.chain
    ds, N = chain.ds, chain.N
    S, W = scalar_matrices(chain)
    # The tension of edge i - 1/2 is the weight of the fibre below it; the edge after the last point has none.
    tension = (1.0 - ds * np.arange(1, N + 1)) / fibre.Fr**2
    e = np.eye(N) - np.eye(N, k=-1)
    K = S / (fibre.alpha**2 * ds**4) + e.T @ (tension[:, None] * e) / ds**2
    drag = fibre.Dr**-2
    return HangingFibre(
        K, 0.5 * drag * (W[1:] + W[:-1]), -flow * drag * chain.arc_lengths, FibreNoise(fibre).strength
    )
