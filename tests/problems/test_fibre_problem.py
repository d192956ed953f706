"""What a fibre says of itself as a problem."""

import numpy as np

from facade import Fibre, clamped_chain, fibre_clamped, hanging_fibre, is_resolved


def reference_growth(alpha, horizon):
    """Return the largest factor by which 512 steps 1 + h A + (h A)^2/2 of the hanging fibre multiply a mode."""
    fibre = hanging_fibre(Fibre(chain=clamped_chain(7, 2), alpha=alpha), 1.0)
    z = horizon / 512 * np.linalg.eigvals(fibre.generator)
    return (np.abs(1 + z + z * z / 2) ** 512).max()


def test_reference_is_attached_where_it_is_stable():
    """With alpha = 0.4 it is up to time 0.25, and no longer where it would grow by more than a factor e."""
    horizons = np.geomspace(0.05, 5.0, 41)
    attached = [horizon for horizon in horizons if is_resolved(fibre_of(0.4), horizon)]

    assert fibre_clamped(alpha=0.4, horizon=0.25).pathwise is not None
    assert fibre_clamped(alpha=0.4, horizon=2.0).pathwise is None
    assert max(reference_growth(0.4, horizon) for horizon in attached) < np.e
    assert reference_growth(0.4, 2.0) > 1e3


def fibre_of(alpha):
    return Fibre(chain=clamped_chain(7, 2), alpha=alpha)
