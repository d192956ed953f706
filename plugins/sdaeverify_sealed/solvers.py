"""Sealed solvers to begin with: schemes that draw their increments from a seed of their own."""

from abc import abstractmethod
from typing import Any, ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Langevin, Problem, Scheme, hookimpl
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2

from .contract import Ends, Sealed

# Weak orders of smooth schemes are whole numbers: a margin of nearly 1/2 tells them apart.
MARGIN, BIASED = 0.45, 0.005


class OwnNoise(Sealed):
    """A scheme of one step that is run with random numbers of its own."""

    @property
    @abstractmethod
    def scheme(self) -> Scheme:
        """The scheme."""

    def refuses(self, problem: Any) -> str:
        """Refuse what the scheme refuses."""
        return self.scheme.why_not(problem)

    def run(self, problem: Any, h: float, T: float, paths: int, seed: int) -> Ends:
        """Draw one increment after the other and make the steps."""
        rng, scheme = np.random.default_rng(seed), self.scheme
        state = scheme.start(problem, paths, h)
        step, W = scheme.prepare(problem, h), np.zeros((problem.noise_dim, paths))
        for n in range(round(T / h)):
            dW = self.drawn(rng, h, W.shape)
            state = step(state, n * h, Increment(dW, None)).state
            W += dW
        return Ends(scheme.parts(problem, state), W)

    def drawn(self, rng: np.random.Generator, h: float, shape: tuple[int, ...]) -> Array:
        """Return the increments of one step.

        Parameters
        ----------
        rng : Generator
            Of the run.
        h : float
            Step size, the variance of an increment.
        shape : tuple of int
            (l, P).
        """
        return np.asarray(np.sqrt(h) * rng.standard_normal(shape))


class OwnEuler(OwnNoise):
    """Euler-Maruyama with a seed: x+ = x + h f + B dW."""

    name: ClassVar[str] = "own-euler"
    form: ClassVar[type[Problem]] = SDE
    steps: ClassVar[tuple[int, ...]] = (4, 8, 16)
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=1.0, margin=MARGIN, source="Kloeden & Platen 1992, section 14.1"),
        Claim(measure="invariant", value=1.0, margin=MARGIN, source="Talay & Tubaro 1990"),
    )
    scheme: ClassVar[Scheme] = EulerMaruyama()


class OwnPlaten(OwnNoise):
    """Platen's explicit scheme of weak order 2 with a seed, its increments being normal."""

    name: ClassVar[str] = "own-platen"
    form: ClassVar[type[Problem]] = SDE
    steps: ClassVar[tuple[int, ...]] = (1, 2, 4)
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=2.0, margin=MARGIN, source="Kloeden & Platen 1992, section 15.1"),
    )
    scheme: ClassVar[Scheme] = PlatenWeak2()


class OwnBAOAB(OwnNoise):
    """BAOAB with a seed."""

    name: ClassVar[str] = "own-baoab"
    form: ClassVar[type[Problem]] = Langevin
    steps: ClassVar[tuple[int, ...]] = (1, 2, 4)
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=2.0, margin=MARGIN, source="Leimkuhler & Matthews 2013"),
        Claim(
            measure="invariant",
            value="unbiased",
            bound=BIASED,
            quantities=("q^2", "cos q"),
            source="Leimkuhler & Matthews 2013: exact for harmonic forces",
        ),
    )
    scheme: ClassVar[Scheme] = BAOAB()


@hookimpl
def sdaeverify_sealed() -> list[Sealed]:
    """Register the solvers."""
    return [OwnEuler(), OwnPlaten(), OwnBAOAB()]
