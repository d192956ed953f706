"""What problems of every form have in common."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from inspect import Signature, signature
from typing import Any, NamedTuple, TypeVar, get_args

import numpy as np

from ..arrays import Array, Mask, Parts, each
from ..errors import ProblemError, is_blank
from ..noise.brownian import BROWNIAN, USUAL, Increment, complete
from ..noise.records import NoiseRecord
from .chart import Chart
from .controls import Control
from .domain import NONNEGATIVE, Domain
from .equation import Equation
from .features import Feature
from .generic import GenericClass
from .names import article
from .traits import ADDITIVE, COMMUTING, GENERAL, why_unknown
from .tree_class import TreeClass
from .trivial import Trivials
from .truths import InvariantMean, Moment, MomentEquation, Pathwise, Truth, generator_of

K = TypeVar("K")
Form = TypeVar("Form", bound=type)
Observable = Callable[[float, Parts], Array]

# What a view of the same states has of its own.
OWN = {"source", "seen_as"}


class Residual(NamedTuple):
    """A constraint's defect and the size of the terms that cancel in it.

    Attributes
    ----------
    value : ndarray, shape (m, P)
    scale : ndarray, shape (P,)
        Rounding errors of `value` are a few eps times this.
    """

    value: Array
    scale: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """Data, observables and truths of a problem of any form.

    Attributes
    ----------
    horizon : float
        Final time T, in the problem's unit of time.
    noise_dim : int
        Number l of independent Brownian motions.
    source : str
        Where the problem is from, with equation number.
    units : str
    traits : frozenset of str
    noise : frozenset of str
        What is drawn for it: ``dW``, and ``H`` unless it is left out to save half of the random numbers; with it, on
        demand, ``K`` and the Levy areas ``A``. It belongs to the problem, so that no scheme's paths depend on which
        other schemes take part.
    observables : mapping of str to callable, (t, parts) -> ndarray, shape (P,)
    truths : tuple of Truth
    controls : tuple of Control
        One for each order of a measure that may be gated on it.
    chart : Chart, optional
        One or two coordinates that all components but pure outputs are functions of.
    domain : Domain, optional
        States that solutions do not leave, if these are not all: single steps are probed in it.
    relaxation_time : float
        Time in which the solution forgets its start by a factor e, in the problem's unit of time; infinite where
        it has no invariant law, or none that is known.
    fastest_time : float
        Time in which its fastest component relaxes, where that can be much shorter than all other times: steps that
        are no shorter do not follow it, and say nothing of an order as h tends to 0. Infinite where there is none.
    seen_as : str
        What it is a view of another problem as; empty for a problem of its own.
    """

    # The traits that a form declares: a class of its own adds to those of all forms.
    declared_traits = GENERAL

    horizon: float
    noise_dim: int
    source: str
    units: str = "dimensionless"
    traits: frozenset[str] = frozenset()
    noise: frozenset[str] = USUAL
    observables: Mapping[str, Observable] = field(default_factory=dict)
    truths: tuple[Truth, ...] = ()
    controls: tuple[Control, ...] = ()
    chart: Chart | None = None
    domain: Domain | None = None
    relaxation_time: float = np.inf
    fastest_time: float = np.inf
    seen_as: str = ""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.horizon) and self.horizon > 0):
            raise ProblemError(f"horizon must be a positive time, got {self.horizon!r}")
        if not (np.issubdtype(type(self.noise_dim), np.integer) and self.noise_dim >= 1):
            raise ProblemError(f"noise_dim must be a whole number of at least 1, got {self.noise_dim!r}")
        declared = {record.name for record in self.records}
        drawn = self.noise - declared
        if drawn != {"dW"} and not USUAL <= drawn <= {*BROWNIAN}:
            beside = "".join(f", with {name}" for name in sorted(declared))
            expected = f"dW, or dW and H with K or A or both{beside}"
            raise ProblemError(f"noise must be {expected}, got {sorted(self.noise)}")
        object.__setattr__(self, "noise", self.noise | declared)
        object.__setattr__(self, "traits", self._all_traits())
        self._check_source_and_truths()

    def _check_source_and_truths(self) -> None:
        if not isinstance(self.source, str) or is_blank(self.source):
            raise ProblemError(
                f"source expects a text that names where the problem is from, got {self.source!r:.200}"
            )
        if not (isinstance(self.truths, tuple | list) and all(isinstance(truth, Truth) for truth in self.truths)):
            kinds = ", ".join(kind.__name__ for kind in get_args(Truth))
            raise ProblemError(f"truths expects a tuple of truths ({kinds}), got {self.truths!r:.200}")
        for truth in self.truths:
            if (
                isinstance(truth, Moment | InvariantMean | MomentEquation)
                and truth.observable not in self.observables
            ):
                known = sorted(self.observables)
                raise ProblemError(f"a truth is about observable {truth.observable!r}; known are {known}")

    def _all_traits(self) -> frozenset[str]:
        traits = frozenset(self.traits) | ({"scalar-noise"} if self.noise_dim == 1 else frozenset())
        if unknown := why_unknown(traits, type(self)):
            raise ProblemError(unknown)
        if self.domain is not None and not isinstance(self.domain, Domain):
            raise ProblemError(f"domain must be a Domain, such as Domain.orthant(), got {self.domain!r:.200}")
        traits |= {NONNEGATIVE} if self.domain is not None and self.domain.nonnegative else frozenset()
        if not (self.has_constraints or self.seen_as):
            traits |= {"unconstrained"}
        if self.has_constraints:
            traits |= {"constrained"}
        traits |= {"no-delay"}
        traits |= ADDITIVE if traits & {"additive-noise", "overdamped-gradient"} else frozenset()
        return traits | {"commutative-noise"} if traits & COMMUTING else traits

    @property
    def pathwise(self) -> Pathwise | None:
        """The truth on a given Brownian path, if one is attached."""
        return next((truth for truth in self.truths if isinstance(truth, Pathwise)), None)

    @property
    def time_unit(self) -> float:
        """The unit of time, or the horizon where that is shorter: steps are probed in parts of it."""
        return min(1.0, self.horizon)

    @property
    def longest_unit(self) -> float:
        """What no unit of time is longer than, however slow the equation is: the horizon."""
        return self.horizon

    @property
    def shared_fields(self) -> dict[str, Any]:
        """The fields that a view of the same states takes over."""
        return {own.name: getattr(self, own.name) for own in fields(Problem) if own.name not in OWN}

    def view(self, form: "type[Problem]") -> "Problem | None":
        """Return this problem as one of another form, or None where it has no such view."""
        return self if isinstance(self, form) else None

    def giving(self, names: Collection[str]) -> "Problem":  # noqa: ARG002 - forms with pure outputs use it
        """Return the problem of some components alone, where they obey an equation of their own; else the whole one.

        Parameters
        ----------
        names : collection of str
            Of the components that a scheme gives; empty for all.
        """
        return self

    @cached_property
    def with_moment_equations(self) -> "Problem":
        """The problem with L phi of each `MomentEquation` as an observable whose invariant mean is 0."""
        known = [truth for truth in self.truths if isinstance(truth, MomentEquation)]
        equation = self.equation() if known else None
        if equation is None:
            return self
        observables = {truth.name: generator_of(equation, self.observables[truth.observable]) for truth in known}
        means = (InvariantMean(observable=truth.name, value=0.0, source=truth.source) for truth in known)
        others = (truth for truth in self.truths if not isinstance(truth, MomentEquation))
        return replace(self, observables={**self.observables, **observables}, truths=(*others, *means))

    # Made once: making an equation checks it, and what is found for it serves all schemes that see it.
    @cached_property
    def _sde(self) -> Any:
        return self._make_sde()

    def _make_sde(self) -> Any:
        """Return the SDE that a form without one of its own is seen as."""

    def capability(self, kind: type[K]) -> K | None:
        """Return what the problem offers of a kind, or None; `why_not` says why not.

        A kind is a class that says what one can do with it: `Delayed`, `StiffnessFamily`, or one of a third party. A
        form offers a kind by deriving from it, or by returning an object of it here.
        """
        return self if isinstance(self, kind) else None

    def why_not(self, kind: type[Any]) -> str:
        """Return why the problem does not offer a kind, in the kind's words, or an empty string if it does."""
        return "" if self.capability(kind) is not None else f"{article(type(self).__name__)} {kind.absent}"

    def observe(self, name: str, t: float, parts: Parts) -> Array | None:
        """Return the values of an observable, or None where a component that it needs is not among the parts.

        Parameters
        ----------
        name : str
            Of the observable.
        t : float
        parts : mapping of str to ndarray, shape (n, P)
        """
        try:
            return np.asarray(self.observables[name](t, parts))
        except KeyError:
            return None

    @property
    def records(self) -> tuple[NoiseRecord, ...]:
        """Noise that drives it beside its Brownian motions; it belongs to the form."""
        return ()

    def drawn(self, rng: np.random.Generator, h: float, paths: int, far: Any = 1.0) -> Increment:
        """Return random noise of one step of size h, its normals `far` times as large as they are by law.

        Parameters
        ----------
        rng : numpy.random.Generator
        h : float
            Step size, in the problem's unit of time.
        paths : int
            Number P of paths.
        far : float or ndarray, shape (P,)
            By which factor the normals are larger than the law's, to see states that are rarely reached.
        """
        dW, areas = far * np.sqrt(h) * rng.standard_normal((2, self.noise_dim, paths))
        records = {r.name: each(lambda data: data[0], r.begin(rng, h, paths)) for r in self.records}
        drawn = Increment(dW, areas / np.sqrt(12.0) if "H" in self.noise else None, records=records)
        return complete(drawn, far**2 * h, self.noise, rng)

    @classmethod
    def trivial_problems(cls) -> Trivials:
        """Return problems of the form that every scheme for it solves exactly; none unless the form knows some."""
        return ()

    @classmethod
    def trivial_problems_in(cls, domain: Domain) -> Trivials:  # noqa: ARG003 - forms that know some use it
        """Return such problems whose solutions stay in a domain; none unless the form knows some."""
        return ()

    @classmethod
    def features(cls) -> tuple[Feature, ...]:
        """Return features that problems of the form may have, for the note on what a run has not met; none here."""
        return ()

    @classmethod
    def tree_classes(cls) -> tuple[TreeClass, ...]:
        """Return the classes of equations of the form that order conditions are known of; none unless it says so."""
        return ()

    @classmethod
    def generic_classes(cls) -> tuple[GenericClass, ...]:
        """Return the classes of equations of the form from which members are drawn; none unless the form has some."""
        return ()

    def ito(self) -> Equation | None:
        """Return the Ito equation that all comparable components obey, or None where there is none.

        Its names are those of `parts`, in their order.
        """
        return None

    def own_diffusion(self, t: float, x: Array) -> Array | None:  # noqa: ARG002 - forms with a projection have one
        """Return the diffusion as its author gave it, at states of the equation, where that has another one."""
        return None

    def equation(self) -> Equation | None:
        """Return the equation of all comparable components that one step of a scheme is compared with.

        It is the Ito equation, unless the form has other noise that drives these components: then `ito` is none.
        """
        return self.ito()

    def coefficients(self, t: float, x: Array) -> tuple[Array, ...]:
        """Return all coefficients of `equation` at states x, rows in the order of its names; empty without one."""
        equation = self.equation()
        return () if equation is None else (equation.drift(t, x), equation.diffusion(t, x))

    def recall(self, h: float, paths: int) -> Any:  # noqa: ARG002 - forms with a delay use it
        """Return the lagged values of a run with steps of size h on so many paths; None without delay."""
        return None

    def add_past(self, h: float, noise: Increment) -> Increment:
        """Return the noise of a first step of size h from time 0, with the past that drives it, too."""
        recall = self.recall(h, noise.dW.shape[-1])
        driven: Increment = noise if recall is None else recall.add_past(noise)
        return driven

    def state(self, x: Array, t: float = 0.0) -> Any:  # noqa: ARG002 - forms with a constraint in time use it
        """Return the state at time t whose components are the rows of x, in the order of `ito`'s names."""
        return x

    @property
    def has_constraints(self) -> bool:
        """Whether `residuals` has anything to return."""
        return False

    def admissible(self, x: Array) -> Array:
        """Return states that keep all constraints near the columns of x, rows in the order of `ito`'s names."""
        return x

    @property
    def moving_constraints(self) -> bool:
        """Whether constraints depend on time or on the past: `residuals` is then given ``t`` and ``lagged``, too."""
        return False

    def kick(self, t: float, parts: Parts, noise: Increment) -> Array | None:
        """Return what the noise of a short step adds to components, shape (d, P); None where nobody can tell.

        Parameters
        ----------
        t : float
        parts : mapping of str to ndarray, shape (k, P)
            The components of a state.
        noise : Increment
        """
        equation = self.equation()
        if equation is None or not set(equation.names or ("x",)) <= set(parts):
            return None
        x = np.concatenate([parts[name] for name in equation.names or ("x",)])
        return np.asarray(equation.diffused(t, x, noise.dW))

    @property
    def free_rows(self) -> slice:
        """Rows of a state, as `ito` names them, that can be as large as one likes and keep all constraints."""
        return slice(0, 0) if self.has_constraints else slice(None)

    @property
    def norm_parts(self) -> tuple[str, ...]:
        """The components that `squared_norm` is about; all of them if it names none."""
        return ()

    def squared_norm(self, parts: Parts) -> Array:
        """Return the square of the norm of a state, shape (P,): that of Euclid, unless the form has another one."""
        return np.asarray(sum((part**2).sum(axis=0) for part in parts.values()))

    def index_lost(self, t: float, h: float, parts: Parts, noise: Increment) -> Mask:  # noqa: ARG002 - as above
        """Tell on which paths a constraint's root is lost within a step, whoever makes it.

        Parameters
        ----------
        t : float
            Start of the step.
        h : float
            Its size.
        parts : dict of str to ndarray
            Components at the start of the step.
        noise : Increment
            Of the step.
        """
        return np.zeros(noise.dW.shape[-1], dtype=bool)

    def without_index(self, t: float, x: Array, v: Array) -> Mask:  # noqa: ARG002 - as above
        """Tell at which x and lagged v a constraint of index 1 has no root that is regular, as it was at time 0.

        Parameters
        ----------
        t : float
        x, v : ndarray, shape (d, P)
            The solution at t, and a delay before t.
        """
        return np.zeros(x.shape[-1], dtype=bool)

    def residuals(self, parts: Parts) -> Mapping[str, Residual]:  # noqa: ARG002 - forms with constraints use it
        """Return the defect of each constraint by name; a problem without constraints has none."""
        return {}


def briefly_signed(form: Form) -> Form:
    """Leave the types out of the signature that `help` shows of a form: its docstring tells them in fewer words."""
    init = vars(form)["__init__"]
    init.__signature__ = Signature(
        [each.replace(annotation=each.empty) for each in signature(init).parameters.values()]
    )
    return form


def components(problem: Any) -> int:
    """Return the number of components of a problem's state."""
    return sum(len(part) for part in problem.parts(problem.initial(1)).values())
