"""The joining of neighbouring steps of a Brownian motion: the inverse of its refinement."""

from facade import join_areas
from sdaeverify.studying import LevelNoise


def aggregate(fine: LevelNoise) -> LevelNoise:
    """Join neighbouring steps, the inverse of `refine`.

    dW = dW_1 + dW_2,   H = (H_1 + H_2)/2 + (dW_1 - dW_2)/4,   K = (K_1 + K_2)/4 + (H_1 - H_2)/8,

    and Chen's relation for A.

    Parameters
    ----------
    fine : LevelNoise
        Arrays of shape (2 n, l, P).

    Returns
    -------
    LevelNoise
        Arrays of shape (n, l, P).
    """
    W1, W2 = fine.dW[0::2], fine.dW[1::2]
    if fine.H is None:
        return LevelNoise(W1 + W2, None)
    H1, H2 = fine.H[0::2], fine.H[1::2]
    K = None if fine.K is None else 0.25 * (fine.K[0::2] + fine.K[1::2]) + 0.125 * (H1 - H2)
    A = None if fine.A is None else join_areas(fine.A, fine.dW)
    return LevelNoise(W1 + W2, 0.5 * (H1 + H2) + 0.25 * (W1 - W2), K=K, A=A)
