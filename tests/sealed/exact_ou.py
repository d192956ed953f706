import numpy as np

from sdaeverify import Claim, hookimpl
from sdaeverify_sealed import sealed

WITHIN = Claim(measure="weak", value="unbiased", bound=0.1, quantities=("x",), source="variation of constants")


@sealed("exact-ou", (WITHIN,), problems=("ou",))
def exact_ou(problem, h, T, paths, seed):
    """Draw the final state of dx = -a x dt + s dW from its normal law, with a and s read from the coefficients."""
    rng, x = np.random.default_rng(seed), problem.initial(1)
    a, s = -problem.drift(0.0, np.ones((1, 1)))[0, 0], problem.diffusion(0.0, x)[0, 0]
    mean, variance = np.exp(-a * T) * x[0], s**2 * (1.0 - np.exp(-2.0 * a * T)) / (2.0 * a)
    return mean + np.sqrt(variance) * rng.standard_normal((1, paths))


@hookimpl
def sdaeverify_sealed():
    return [exact_ou]
