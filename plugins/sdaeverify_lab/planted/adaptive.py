"""Wrong adaptive solvers, with errors in the use of observed noise or of the tolerance.

Each has the claims that its author would make. They are registered with the solvers under names that begin with
``planted-``, and run only if they are named.
"""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, hookimpl
from sdaeverify_adaptive import TICKS, Adaptive, Path, Point
from sdaeverify_adaptive.hashed import normals
from sdaeverify_adaptive.marching import Front, Stretch, Tried
from sdaeverify_adaptive.solvers.embedded import HeunPI, MilsteinPI, heun, milstein
from sdaeverify_adaptive.solvers.nested import HeunNested

HALF = Claim(measure="tolerance", value=0.5, source="made up")
# Ranges of tolerances.
FINEST, FINER, FINE, COARSE = (tuple(2.0**-n for n in range(first, first + 8, 2)) for first in (10, 8, 6, 4))


class Redraw(HeunPI):
    """Heun's scheme that draws a new increment after each rejection, ignoring the observed one."""

    name: ClassVar[str] = "planted-redraw"
    tolerances: ClassVar[tuple[float, ...]] = FINER
    claims: ClassVar[tuple[Claim, ...]] = (HALF,)

    def advance(self, problem: SDE, path: Path, front: Front, tolerance: float) -> Front:
        """Return the state of the integration, with J replaced by a mark where the last step was rejected."""
        moved = super().advance(problem, path, front, tolerance)
        mark = np.broadcast_to(1.0 * (moved.rejected > front.rejected), moved.here.J.shape)
        return moved._replace(here=moved.here._replace(J=mark))

    def ahead(self, path: Path, front: Front) -> Point:
        """Return the end point of the attempted step, on the path or with a new increment."""
        there, here = super().ahead(path, front), front.here
        h = (there.tick - here.tick) * path.tick
        node = there.tick + 2 * TICKS * front.rejected
        drawn = np.sqrt(h) * normals(path.key ^ 1, node, path.rows, (path.dimension,))
        dW = np.where(here.J > 0.0, drawn, there.W - path.at(here.tick).W)
        return there._replace(W=here.W + dW)


class RedrawLaw(Redraw):
    """The redrawing scheme that declares its own noise, which is not detectable: its law is as claimed."""

    name: ClassVar[str] = "planted-redraw-law"
    own_noise: ClassVar[bool] = True
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="tolerance-law", value="unbiased", bound=0.02, quantities=("x",), source="made up"),
    )


class WideBridge(HeunPI):
    """Heun's scheme that refines a rejected step by a bridge of twice the standard deviation."""

    name: ClassVar[str] = "planted-wide-bridge"
    claims: ClassVar[tuple[Claim, ...]] = (HALF,)

    def advance(self, problem: SDE, path: Path, front: Front, tolerance: float) -> Front:
        """Return the state of the integration, with J replaced by the end of a step just rejected."""
        moved = super().advance(problem, path, front, tolerance)
        end = np.minimum(front.here.tick + front.size, TICKS)
        seen = np.where(moved.rejected > front.rejected, end, 0)
        return moved._replace(here=moved.here._replace(J=np.broadcast_to(1.0 * seen, moved.here.J.shape)))

    def ahead(self, path: Path, front: Front) -> Point:
        """Return the end point of the attempted step."""
        there, here = super().ahead(path, front), front.here
        end = here.J[0].astype(np.int64)
        inside = end > there.tick
        seen, begin = path.at(np.where(inside, end, there.tick)).W, path.at(here.tick).W
        part = np.where(inside, (there.tick - here.tick) / np.maximum(end - here.tick, 1), 1.0)
        deviation = there.W - (1.0 - part) * begin - part * seen
        return there._replace(W=(1.0 - part) * here.W + part * seen + 2.0 * deviation)


class Peek(MilsteinPI):
    """Euler's scheme in Ito's sense whose error estimate depends on the increment: (1/2) DB B (dW^2 - h)."""

    name: ClassVar[str] = "planted-peek"
    tolerances: ClassVar[tuple[float, ...]] = FINER
    claims: ClassVar[tuple[Claim, ...]] = (HALF,)

    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Compute a step and its error estimate."""
        return Tried(*milstein(problem, step))


class BatchNorm(HeunPI):
    """Heun's scheme whose error is averaged over all paths solved together, so that they share their steps."""

    name: ClassVar[str] = "planted-batch-norm"
    claims: ClassVar[tuple[Claim, ...]] = (HALF,)

    def norm(self, tried: Tried, x: Array, tolerance: float) -> Array:
        """Return the same error on each path."""
        error = super().norm(tried, x, tolerance)
        return np.full_like(error, np.sqrt(np.mean(error**2)))


class Blind(HeunPI):
    """Heun's scheme with an error estimate from the diffusion only, which is 0 for additive noise."""

    name: ClassVar[str] = "planted-blind"
    claims: ClassVar[tuple[Claim, ...]] = (HALF,)
    longest: ClassVar[int] = TICKS // 32

    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Compute a step and its error estimate."""
        tried = heun(problem, step)
        B, C = problem.diffusion(0.0, step.x), problem.diffusion(0.0, tried.x)
        return tried._replace(error=0.5 * np.einsum("dlp,lp->dp", C - B, step.noise.dW) + 0.0 * tried.x)


class Floor(HeunPI):
    """Heun's scheme with a shortest step of T/64, regardless of the error, without reporting it."""

    name: ClassVar[str] = "planted-floor"
    tolerances: ClassVar[tuple[float, ...]] = FINEST
    claims: ClassVar[tuple[Claim, ...]] = (HALF,)
    shortest: ClassVar[int] = TICKS // 64


class Skip(HeunNested):
    """Heun's scheme that evaluates the middle of a step and skips it if the area there is not large: A <= tol.

    The observed value decides and is then discarded, so that the omitted areas do not have mean zero.
    """

    name: ClassVar[str] = "planted-skip"
    tolerances: ClassVar[tuple[float, ...]] = FINE
    claims: ClassVar[tuple[Claim, ...]] = (HALF,)

    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Compute a step and its error estimate."""
        tried = heun(problem, step)
        return tried._replace(error=self.seen(tried.error, area_of_middle(step)))

    def seen(self, error: Array, area: Array) -> Array:
        """Return the error estimate: the positive part of the area."""
        return np.asarray(np.maximum(area, 0.0) + 0.0 * error)


class SkipMixed(Skip):
    """The skipping scheme with the area added to the difference of Heun's and Euler's step: |D + A| <= tol."""

    name: ClassVar[str] = "planted-skip-mixed"
    tolerances: ClassVar[tuple[float, ...]] = COARSE

    def seen(self, error: Array, area: Array) -> Array:
        """Return the error estimate: the sum of difference and area."""
        return np.asarray(error + area)


def area_of_middle(step: Stretch) -> Array:
    """Return (1/2) (dW'_1 dW''_2 - dW'_2 dW''_1) of the two halves of a step, shape (P,)."""
    middle = step.path.at((step.here.tick + step.there.tick) // 2)
    (a, b), (c, d) = middle.W - step.here.W, step.there.W - middle.W
    return np.asarray(0.5 * (a * d - b * c))


@hookimpl
def sdaeverify_adaptive() -> list[Adaptive]:
    """Register the solvers."""
    return [
        BatchNorm(),
        Blind(),
        Floor(),
        Peek(),
        Redraw(),
        RedrawLaw(),
        Skip(),
        SkipMixed(),
        WideBridge(),
    ]
