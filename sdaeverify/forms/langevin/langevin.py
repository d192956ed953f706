"""The form dq = p dt, dp = (F(q) - gamma p) dt + sigma dW: Langevin dynamics of unit mass without constraints."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array, Parts
from ...errors import ProblemError
from ...noise.brownian import BROWNIAN
from ..checks import PROBES, check_known, check_not_negative, check_shape, columns, vector
from ..features import Feature, differ, pilot_states
from ..problem import Problem, briefly_signed
from ..sde.sde import SDE
from ..sde.waves import MOST, SEED, random_waves
from ..sde.waves import SOURCE as RANDOM_SOURCE
from ..traits import ADDITIVE
from ..trees.tree_class import TreeClass
from ..trivial import SOURCE, SPEED, Trivial, Trivials
from .universal import LangevinTrees


class Damped(Problem):
    """Positions and momenta with a ``force``, a ``friction`` and noise of one ``strength``."""

    absent: ClassVar[str] = "has no friction of its own"


@briefly_signed
@dataclass(frozen=True, kw_only=True, eq=False)
class Langevin(Damped):
    """Langevin dynamics dq = p dt, dp = (F(q) - gamma p) dt + sigma dW, q and p in R^n, W in R^n.

    Attributes
    ----------
    force : callable, q -> ndarray, shape (n, P)
        F, for positions q of shape (n, P).
    friction : float
        gamma, finite and not negative, unit 1/time.
    strength : float
        sigma, finite and not negative.
    position, momentum : array_like, shape (n,)
        q and p at time 0.
    noise_dim : int
        n, set by the form.
    horizon, source, units, traits, noise, observables, truths, controls, chart, domain
        As for any `Problem`.
    relaxation_time, fastest_time
        As for any `Problem`, and seen_as, which only views set.

    Raises
    ------
    ProblemError
        If shapes are inconsistent, or if a number is negative or not finite.
    """

    force: Callable[[Array], Array]
    friction: float
    strength: float
    position: ArrayLike
    momentum: ArrayLike
    noise_dim: int = field(init=False)

    def __post_init__(self) -> None:
        for name in ("position", "momentum"):
            object.__setattr__(self, name, vector(name, getattr(self, name)))
        object.__setattr__(self, "noise_dim", len(cast("Array", self.position)))
        super().__post_init__()
        check_not_negative(self, "friction", "strength")
        n, given = self.noise_dim, len(cast("Array", self.momentum))
        if given != n:
            raise ProblemError(f"momentum has {given} components, position has {n}")
        x = self.initial(PROBES)
        check_shape("force(q)", self.force(x[:n]), (n, PROBES))
        check_known(self, self.parts(x))

    def _all_traits(self) -> frozenset[str]:
        return super()._all_traits() | ADDITIVE

    def initial(self, paths: int) -> Array:
        """Return q stacked on p on every path, shape (2 n, P)."""
        return columns(np.concatenate([cast("Array", self.position), cast("Array", self.momentum)]), paths)

    def parts(self, x: Array) -> Parts:
        """Return positions and momenta of a state of shape (2 n, P)."""
        return {"q": x[: self.noise_dim], "p": x[self.noise_dim :]}

    def view(self, form: type[Problem]) -> Problem | None:
        """Return the problem itself, or the same equations as one first-order system if an `SDE` is requested."""
        return self.ito() if form is SDE else super().view(form)

    def random_like(self) -> "Langevin":
        """Return dynamics with a random force; no powers of friction and strength have a simple product."""
        n, rng = min(self.noise_dim, MOST), np.random.Generator(np.random.Philox(key=SEED))
        waves, (q, p) = random_waves(rng, np.ones((n, n))), rng.uniform(-0.5, 0.5, (2, n))
        return Langevin(
            force=lambda q: waves(0.0, q),
            friction=1.57,
            strength=0.83,
            position=q,
            momentum=p,
            horizon=1.0,
            source=RANDOM_SOURCE,
        )

    @classmethod
    def trivial_problems(cls) -> Trivials:
        """Return the problems that every scheme for the form solves exactly."""
        return _trivial_dynamics()

    @classmethod
    def features(cls) -> tuple[Feature, ...]:
        """Return the only feature of the form, a nonlinear force; order conditions cover several positions."""
        return (Feature("a force that is not linear", lambda problem: problem.is_nonlinear),)

    @property
    def is_nonlinear(self) -> bool:
        """Whether second differences of the force are nonzero at some positions."""
        q = pilot_states(self)[: self.noise_dim]
        moved = [q + part for part in (-1.0, 0.0, 1.0)]
        low, middle, high = (np.broadcast_to(self.force(at), q.shape) for at in moved)
        return differ([low + high, 2.0 * middle])

    @classmethod
    def tree_classes(cls) -> tuple[TreeClass, ...]:
        """Return the classes of dynamics with any force, and with a force that has a potential."""
        return LangevinTrees(cls), LangevinTrees(cls, gradient=True)

    def ito(self) -> SDE:
        """Return the equation of x = (q, p)."""
        return cast("SDE", self._sde)

    def _make_sde(self) -> SDE:
        n, gamma = self.noise_dim, self.friction
        B = np.concatenate([np.zeros((n, n)), self.strength * np.eye(n)])[..., None]

        def drift(_: float, x: Array) -> Array:
            return np.concatenate([x[n:], self.force(x[:n]) - gamma * x[n:]])

        return SDE(
            drift=drift,
            diffusion=lambda *_: B,
            diffusion_derivative=lambda *_: np.zeros_like(B),
            start=self.initial(1)[:, 0],
            names={"q": slice(0, n), "p": slice(n, None)},
            **self.shared_fields,
            source=f"first-order system of: {self.source}",
            seen_as="first-order system",
        )


FRICTION = 0.5
# Degrees of freedom; one is tried if two fail.
SIZES = 2, 1
# Number of random frictions and strengths, with uniform logarithms from 2^-5 to 2^5.
DRAWN, PARAMETERS = 8, 5.0


def _trivial_dynamics() -> Trivials:
    """Return the problems of rest, damped motion and motion driven by noise."""
    both, kick = ("q", "p"), (0.4, 0.7)
    return (
        tuple(_make_trivial("q at rest", 0.0, (0.0, 0.0), both, n) for n in SIZES),
        tuple(_make_trivial("dp = -gamma p dt", SPEED, (0.0, 0.0), both, n) for n in SIZES),
        tuple(_make_trivial("dp = (c - gamma p) dt + sigma dW", SPEED, kick, ("p",), n) for n in SIZES),
        *((_make_trivial(*each),) for each in _other_parameters()),
    )


def _other_parameters() -> Iterator[tuple[Any, ...]]:
    """Yield motions driven by noise without friction, and with random frictions and strengths of different sizes."""
    rng = np.random.Generator(np.random.Philox(key=SEED))
    for friction, sigma in [(0.0, 0.7), *np.exp2(rng.uniform(-PARAMETERS, PARAMETERS, (DRAWN, 2))).tolist()]:
        name = f"dp = (c - gamma p) dt + sigma dW, gamma = {friction:.2g}, sigma = {sigma:.2g}"
        yield name, SPEED, (0.4, sigma), ("p",), 1, friction


def _make_trivial(
    name: str,
    speed: float,
    kick: tuple[float, float],
    known: tuple[str, ...],
    size: int,
    friction: float = FRICTION,
) -> Trivial:
    (force, sigma), along, start = kick, np.array([[1.0], [-0.5]])[:size], np.array([0.3, 0.8])[:size]
    problem = Langevin(
        force=lambda q: force * along + 0.0 * q,
        friction=friction,
        strength=sigma,
        position=start,
        momentum=speed * along[:, 0],
        noise=frozenset(BROWNIAN),
        horizon=1.0,
        source=SOURCE,
    )

    def solution(t: float, W: Array) -> Parts:
        decayed = -np.expm1(-friction * t) / friction if friction else t
        p = along * (speed + decayed * (force - friction * speed)) + sigma * W
        parts = {"q": start[:, None] + decayed * speed * along + 0.0 * W, "p": p}
        return {key: parts[key] for key in known}

    return Trivial(name, problem, solution)
