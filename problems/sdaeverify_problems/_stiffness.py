"""What problems with a stiffness parameter ask of their numbers before anything is computed from them."""

import numpy as np

from sdaeverify import ParameterError


def check_stiffness(eps: float) -> None:
    """Check the stiffness parameter.

    Raises
    ------
    ParameterError
        Unless it is finite and not negative.
    """
    if not 0.0 <= eps < np.inf:
        raise ParameterError(f"eps must be finite and not negative, got {eps!r}")


def check_positive(**values: float) -> None:
    """Check parameters that are divided by.

    Raises
    ------
    ParameterError
        Naming the first that is not positive and finite.
    """
    for name, value in values.items():
        if not 0.0 < value < np.inf:
            raise ParameterError(f"{name} must be positive and finite, got {value!r}")
