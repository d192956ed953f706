"""Principal branch of Lambert's W function, for an argument given by its logarithm."""

import numpy as np
import scipy


def lambert_of_log(logarithm: float, negative: bool = False) -> complex:
    """Return W_0(z) of z = e^logarithm or -e^logarithm, the root w of w e^w = z with the largest real part.

    W_0(z) is Wright's omega(log z), which does not overflow. For z from -1/e to 0, where both W_0 and W_{-1} are
    real, omega has a branch cut, and its values there are partly those of W_{-1}: SciPy's Lambert function is used
    there.

    Parameters
    ----------
    logarithm : float
        log |z|.
    negative : bool, optional
        Whether z is negative.

    Returns
    -------
    complex
    """
    if negative and logarithm <= -1.0:
        return complex(scipy.special.lambertw(-np.exp(logarithm)).real)
    return complex(scipy.special.wrightomega(logarithm + (1j * np.pi if negative else 0.0)))
