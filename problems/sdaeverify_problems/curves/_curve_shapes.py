"""Closed curves, given by a parameter of period 2 pi and as the zeros of quadratic functions."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sdaeverify import Array

from .._quadrics import Quadrics

SADDLE = np.array([[0.0, -0.7, 0.0], [-0.7, 0.0, 0.0], [0.0, 0.0, 0.0]])


class Shape(NamedTuple):
    """A closed curve x = gamma(theta), the zeros of zeta; x_1 = radius cos theta, x_2 = sin theta."""

    radius: float
    gamma: Callable[[Array], Array]
    zeta: Quadrics


SHAPES = {
    "ellipse": Shape(
        2.0,
        lambda z: np.concatenate([2.0 * np.cos(z), np.sin(z)]),
        Quadrics(np.diag([0.25, 1.0])[None], np.zeros((1, 2)), np.array([-0.5])),
    ),
    "space": Shape(
        1.0,
        lambda z: np.concatenate([np.cos(z), np.sin(z), 0.7 * np.cos(z) * np.sin(z)]),
        Quadrics(
            np.stack([np.diag([1.0, 1.0, 0.0]), SADDLE]), np.eye(3)[[0, 2]] * [[0.0], [1.0]], np.array([-0.5, 0.0])
        ),
    ),
}
