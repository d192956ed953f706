"""The form dx = f dt + g dW, 0 = u(t, x, y) of index 1: the delay form without delay."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ..checks import vector
from ..features import Feature
from ..generic import GenericClass
from ..problem import briefly_signed
from ..trees.tree_class import TreeClass
from ..trivial import Trivials
from .delay_features import undelayed_features
from .delay_sdae import DelaySDAE
from .generic import INDEX_ONE_FEATURES, draw_index_one
from .partials import Partials
from .trivial_delays import trivial_index_one
from .universal import IndexOneTrees


@dataclass(frozen=True)
class Pastless:
    """A function of (t, x, y) that accepts the arguments (t, x, v, y) of schemes for delay equations.

    Attributes
    ----------
    f : callable, (t, x, y) -> object; of (t, x) if y is not an argument
    of_y : bool
        Whether y is an argument.
    """

    f: Callable[..., Any]
    of_y: bool = True

    def __call__(self, t: float, x: Array, *rest: Array) -> Any:
        """Return f(t, x, y), where y is the last argument; a lagged value before y, which equals x, is ignored."""
        return self.f(t, x, *rest[-1:]) if self.of_y else self.f(t, x)


def _with_past(df: Callable[..., tuple[Array, Array]], t: float, x: Array, y: Array) -> Partials:
    # The derivatives in x, v and y; those in v are 0.
    in_x, in_y = df(t, x, y)
    return Partials(in_x, np.zeros_like(in_x), in_y)


@briefly_signed
@dataclass(frozen=True, kw_only=True, eq=False)
class IndexOneSDAE(DelaySDAE):
    """A stochastic differential-algebraic equation of index 1 (Ito), an electric circuit for example.

        dx = f(t, x, y) dt + g(t, x, y) dW,    0 = u(t, x, y),

    where the constraint contains no noise and determines y: du/dy is regular. It is a `DelaySDAE` with delay 0, so
    schemes for that form solve it, too.

    The state of a scheme for it is a ``DelayState(x, y)``, which a step returns as well. The step calls
    ``problem.drift(t, x, y)``, ``problem.diffused(t, x, y, noise.dW)`` for g dW, ``problem.constraint(t, x, y)``, and
    ``problem.eliminated(t, x)`` for the y that solves the constraint.

    Attributes
    ----------
    drift : callable, (t, x, y) -> ndarray, shape (d, P)
        f, for x of shape (d, P) and y of shape (q, P).
    diffusion : callable, (t, x, y) -> ndarray, shape (d, l, P) or (d, l, 1)
        g, one column for each Brownian motion.
    start : array_like, shape (d,)
        x at time 0.
    constraint : callable, (t, x, y) -> ndarray, shape (q, P), optional
        u; if omitted, there is no y.
    algebraic : array_like, shape (q,), or int, optional
        y at time 0, which must be consistent. If it is an int, the number q, y is solved for.
    solved : callable, (t, x) -> ndarray, shape (q, P), optional
        The y that solves the constraint; by Newton's method if omitted.
    drift_partials, constraint_partials : callable, (t, x, y) -> two matrices, optional
        The derivatives in x and y of f and of u; by complex step if omitted.
    dissipation, dissipation_without_y : Dissipation, optional
        See `DelaySDAE`.
    horizon, noise_dim, source, units, traits, noise, observables, truths
        As for any `Problem`.
    controls, chart, domain, relaxation_time, fastest_time
        As for any `Problem`, and seen_as, which only views set.

    Raises
    ------
    ProblemError
        As for `DelaySDAE`.
    """

    drift: Callable[..., Array]
    diffusion: Callable[..., Array]
    start: ArrayLike
    constraint: Callable[..., Array] | None = None
    solved: Callable[..., Array] | None = None
    drift_partials: Callable[..., Partials] | None = None
    constraint_partials: Callable[..., Partials] | None = None
    delay: float = field(init=False, default=0.0)
    history: Callable[[float], ArrayLike] = field(init=False)

    arguments = "t, x, y"

    def __post_init__(self) -> None:
        start = vector("start", self.start)
        for name in ("drift", "diffusion", "constraint", "solved", "drift_partials", "constraint_partials"):
            given = getattr(self, name)
            # A copy of a problem receives functions that its original has wrapped already.
            if given is not None and not isinstance(given, Pastless):
                derivative = partial(_with_past, given) if name.endswith("partials") else given
                object.__setattr__(self, name, Pastless(derivative, of_y=name != "solved"))
        object.__setattr__(self, "start", start)
        object.__setattr__(self, "history", lambda _: start)
        super().__post_init__()

    def diffused(self, t: float, x: Array, *rest: Array) -> Array:
        """Return g(t, x, y) w.

        Parameters
        ----------
        t : float
        x : ndarray, shape (d, P)
        *rest : ndarray
            The last two are y, shape (q, P), and w, shape (l, P); a lagged value before them is ignored.

        Returns
        -------
        ndarray, shape (d, P)
        """
        y, w = rest[-2:]
        return super().diffused(t, x, x, y, w)

    def eliminated(self, t: float, x: Array, v: Array | None = None) -> Array:  # noqa: ARG002 - the past of no delay
        """Return the y that solves the constraint, shape (q, P); NaN if Newton's method fails."""
        return super().eliminated(t, x, x)

    @classmethod
    def generic_classes(cls) -> tuple[GenericClass, ...]:
        """Return the class of all polynomial problems of the form."""
        return (GenericClass("IndexOneSDAE", partial(draw_index_one, IndexOneSDAE), INDEX_ONE_FEATURES),)

    @classmethod
    def trivial_problems(cls) -> Trivials:
        """Return the problems that every scheme for the form solves exactly; none has a delay."""
        return trivial_index_one(IndexOneSDAE)

    @classmethod
    def features(cls) -> tuple[Feature, ...]:
        """Return the features of delay equations that need no delay."""
        return undelayed_features()

    @classmethod
    def tree_classes(cls) -> tuple[TreeClass, ...]:
        """Return the classes of equations with any diffusion and with a constant one."""
        return IndexOneTrees(cls), IndexOneTrees(cls, additive=True)
