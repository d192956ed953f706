"""The two array conventions of the package.

Paths come last: a state of n components on P paths has shape ``(n, P)``, a matrix ``(m, n, P)``.
An array of real numbers may arrive complex where a derivative is taken by complex step.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Mask = NDArray[np.bool_]
Parts = Mapping[str, Array]
