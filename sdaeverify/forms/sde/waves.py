"""Random waves, from which forms make random equations on which no two common mistakes have the same effect.

On dx = a x dt + b x dW drift, Stratonovich's correction and x are multiples of each other, so that a wrong drift has
several explanations. A mistake of a step is made on every equation: it must be visible on a random one, too.
"""

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array

SEED = 20261128
# Size: components and motions of a random equation, of which three show correlations and wrong indices.
MOST = 3
# Number of waves of a coefficient, and the size of its constant part.
# Chosen.
WAVES, CONSTANT = 2, 0.6
SOURCE = "random equation"


class Waves(NamedTuple):
    """n functions c + sum_k a_k cos(w_k . x + s_k t + p_k).

    Attributes
    ----------
    sizes, phases, speeds : ndarray, shape (n, K)
    waves : ndarray, shape (n, K, d)
    constant : ndarray, shape (n,)
    """

    sizes: Array
    waves: Array
    phases: Array
    speeds: Array
    constant: Array

    def __call__(self, t: float, x: Array) -> Array:
        """Return the functions at states of shape (d, P), shape (n, P)."""
        angles = np.einsum("nkd,dp->nkp", self.waves, x) + (self.phases + self.speeds * t)[..., None]
        return np.asarray(self.constant[:, None] + np.einsum("nk,nkp->np", self.sizes, np.cos(angles)))


def random_waves(rng: np.random.Generator, depends: Array) -> Waves:
    """Return random functions of time and of the components that a mask of shape (n, d) selects.

    Parameters
    ----------
    rng : Generator
    depends : ndarray, shape (n, d)
        1 for the components that a function depends on, else 0.
    """
    n, d = depends.shape
    sizes, phases, speeds = rng.uniform(0.2, 0.5, (n, WAVES)), *rng.uniform(0.0, 6.0, (2, n, WAVES))
    waves = rng.uniform(0.5, 1.5, (n, WAVES, d)) * rng.choice([-1.0, 1.0], (n, WAVES, 1))
    return Waves(sizes, waves * depends[:, None], phases, 0.2 * speeds, CONSTANT * rng.choice([-1.0, 1.0], n))


def random_coefficients(d: int, noises: int, traits: frozenset[str]) -> dict[str, Any]:
    """Return the arguments of a random SDE with a kind of noise, of at most three components and motions.

    Parameters
    ----------
    d, noises : int
        Numbers of components and of Brownian motions of an SDE of this kind.
    traits : frozenset of str
        Traits of that SDE.
    """
    rng = np.random.Generator(np.random.Philox(key=SEED))
    M, kept = min(noises, MOST), traits & {"additive-noise", "diagonal-noise"}
    n = M if "diagonal-noise" in kept else min(d, MOST)
    depends = np.eye(n) if "diagonal-noise" in kept else np.ones((n * M, n))
    constant = rng.uniform(0.4, 0.9, (n, M, 1)) * (np.eye(n)[..., None] if "diagonal-noise" in kept else 1.0)
    diffusion = partial(_diffusion, random_waves(rng, depends), constant, kept)
    drift, start = random_waves(rng, np.ones((n, n))), rng.uniform(-0.5, 0.5, n)
    return {"drift": drift, "diffusion": diffusion, "start": start, "noise_dim": M, "traits": kept}


def _diffusion(noise: Waves, constant: Array, traits: frozenset[str], t: float, x: Array) -> Array:
    if "additive-noise" in traits:
        return constant
    if "diagonal-noise" in traits:
        return np.asarray(noise(t, x)[:, None] * np.eye(len(x))[..., None])
    return noise(t, x).reshape(*constant.shape[:2], -1)
