"""What a problem that contradicts itself is refused with."""

import numpy as np
import pytest

from sdaeverify import ProblemError


def refusal(build, kind=ProblemError, **changes):
    """Return the one line that an error says when a problem is built."""
    with np.errstate(all="ignore"), pytest.raises(kind) as caught:
        build(**changes)
    assert "\n" not in str(caught.value)
    return str(caught.value)
