"""The base class of problems of all forms."""

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
from .traits import ADDITIVE, COMMUTING, GENERAL, Trait, known_traits, why_unknown
from .trees.tree_class import TreeClass
from .trivial import Trivials
from .truths import InvariantMean, Moment, MomentEquation, Pathwise, Truth, generator_of

K = TypeVar("K")
Form = TypeVar("Form", bound=type)
Observable = Callable[[float, Parts], Array]

# Fields that a view of the same states does not inherit.
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
        Source of the problem, with equation number.
    units : str
    traits : frozenset of str
    noise : frozenset of str
        Noise to be drawn: ``dW``, and ``H`` unless it is omitted to save half of the random numbers; with it, on
        demand, ``K`` and the Levy areas ``A``. It belongs to the problem, so that a scheme's paths do not depend on
        the other schemes of the run.
    observables : mapping of str to callable, (t, parts) -> ndarray, shape (P,)
    truths : tuple of Truth
    controls : tuple of Control
        One for each order of a measure that may be gated on it.
    chart : Chart, optional
        One or two coordinates that determine all components except pure outputs.
    domain : Domain, optional
        Set of states that solutions do not leave, if not the whole space; single steps are probed in it.
    relaxation_time : float
        Time in which the solution forgets its start by a factor e, in the problem's unit of time; infinite if
        it has no invariant law, or if the time is unknown.
    fastest_time : float
        Time in which its fastest component relaxes, if that can be much shorter than all other times. Steps that
        are not shorter do not resolve it, and show no order as h tends to 0. Infinite if there is no such component.
    seen_as : str
        For a view of another problem, the name of the view; empty otherwise.
    """

    # Traits that a form declares; a subclass adds to those of all forms.
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
        """The pathwise truth, if one is attached."""
        return next((truth for truth in self.truths if isinstance(truth, Pathwise)), None)

    @property
    def time_unit(self) -> float:
        """The unit of time, limited by the horizon; probed step sizes are fractions of it."""
        return min(1.0, self.horizon)

    @property
    def longest_unit(self) -> float:
        """Upper bound of units of time, however slow the equation is: the horizon."""
        return self.horizon

    @property
    def shared_fields(self) -> dict[str, Any]:
        """The fields that a view of the same states inherits."""
        return {own.name: getattr(self, own.name) for own in fields(Problem) if own.name not in OWN}

    def view(self, form: "type[Problem]") -> "Problem | None":
        """Return this problem in another form, or None if it has no such view."""
        return self if isinstance(self, form) else None

    def giving(self, names: Collection[str]) -> "Problem":  # noqa: ARG002 - forms with pure outputs use it
        """Return the problem of some components alone if they obey a closed equation, else the whole one.

        Parameters
        ----------
        names : collection of str
            The components that a scheme gives; empty for all.
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

    # Cached, because making an equation checks it, and results computed for it are shared by all schemes.
    @cached_property
    def _sde(self) -> Any:
        return self._make_sde()

    def _make_sde(self) -> Any:
        """Return the view as an SDE, for forms without an own implementation of `view`."""

    def capability(self, kind: type[K]) -> K | None:
        """Return the problem as an object of a capability class, or None; see `why_not` for the reason.

        A capability is a class of operations: `Delayed`, `StiffnessFamily`, or one of a third party. A
        form has a capability if it derives from the class, or returns an object of it here.
        """
        return self if isinstance(self, kind) else None

    def why_not(self, kind: type[Any]) -> str:
        """Return why the problem does not have a capability, in the words of its class; empty if it has it."""
        return "" if self.capability(kind) is not None else f"{article(type(self).__name__)} {kind.absent}"

    def observe(self, name: str, t: float, parts: Parts) -> Array | None:
        """Return the values of an observable, or None if a component that it needs is not among the parts.

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
        """Noise of the form in addition to Brownian motions."""
        return ()

    def drawn(self, rng: np.random.Generator, h: float, paths: int, far: Any = 1.0) -> Increment:
        """Draw random noise of one step of size h, with its normals scaled by `far`.

        Parameters
        ----------
        rng : numpy.random.Generator
        h : float
            Step size, in the problem's unit of time.
        paths : int
            Number P of paths.
        far : float or ndarray, shape (P,)
            Factor of the normals, larger than 1 to reach rare states.
        """
        dW, areas = far * np.sqrt(h) * rng.standard_normal((2, self.noise_dim, paths))
        records = {r.name: each(lambda data: data[0], r.begin(rng, h, paths)) for r in self.records}
        drawn = Increment(dW, areas / np.sqrt(12.0) if "H" in self.noise else None, records=records)
        return complete(drawn, far**2 * h, self.noise, rng)

    @classmethod
    def trivial_problems(cls) -> Trivials:
        """Return problems of the form that every scheme for it solves exactly; empty unless overridden."""
        return ()

    @classmethod
    def trivial_problems_in(cls, domain: Domain) -> Trivials:  # noqa: ARG003 - forms that know some use it
        """Return such problems with solutions in a domain; empty unless overridden."""
        return ()

    @classmethod
    def features(cls) -> tuple[Feature, ...]:
        """Return features that problems of the form may have, for the note on gaps of a run; empty by default."""
        return ()

    @classmethod
    def known_traits(cls) -> dict[str, Trait]:
        """Return the traits of the framework and those that the form declares, by name."""
        return known_traits(cls)

    @classmethod
    def tree_classes(cls) -> tuple[TreeClass, ...]:
        """Return the classes of equations of the form with order conditions; empty unless the form overrides this."""
        return ()

    @classmethod
    def generic_classes(cls) -> tuple[GenericClass, ...]:
        """Return the classes of equations of the form with random members; empty unless the form overrides this."""
        return ()

    def random_like(self) -> "Problem | None":
        """Return a random problem of the form with this kind of noise, or None unless the form overrides this.

        No two common mistakes of a step have the same effect on it, unlike on problems with few terms.
        """
        return None

    def ito(self) -> Equation | None:
        """Return the Ito equation of all comparable components, in the order of `parts`; None if there is none."""
        return None

    def own_diffusion(self, t: float, x: Array) -> Array | None:  # noqa: ARG002 - forms with a projection have one
        """Return the diffusion as given by the author at states of `ito`, or None if `ito` has the same."""
        return None

    def equation(self) -> Equation | None:
        """Return the equation of all comparable components with which one step of a scheme is compared.

        It is the Ito equation, unless the form has other noise that drives these components; then `ito` returns None.
        """
        return self.ito()

    def coefficients(self, t: float, x: Array) -> tuple[Array, ...]:
        """Return all coefficients of `equation` at states x, rows in the order of its names; empty if it is None."""
        equation = self.equation()
        return () if equation is None else (equation.drift(t, x), equation.diffusion(t, x))

    def recall(self, h: float, paths: int) -> Any:  # noqa: ARG002 - forms with a delay use it
        """Return the lagged values of a run with steps of size h on a number of paths; None without delay."""
        return None

    def add_past(self, h: float, noise: Increment) -> Increment:
        """Return the noise of a first step of size h from time 0, including the lagged values that it needs."""
        recall = self.recall(h, noise.dW.shape[-1])
        driven: Increment = noise if recall is None else recall.add_past(noise)
        return driven

    def state(self, x: Array, t: float = 0.0) -> Any:  # noqa: ARG002 - forms with a constraint in time use it
        """Return the state at time t whose components are the rows of x, in the order of `ito`'s names."""
        return x

    @property
    def has_constraints(self) -> bool:
        """Whether `residuals` returns any defects."""
        return False

    def admissible(self, x: Array) -> Array:
        """Return states that satisfy all constraints near the columns of x, rows in the order of `ito`'s names."""
        return x

    @property
    def moving_constraints(self) -> bool:
        """Whether constraints depend on time or on the past: `residuals` then needs ``t`` and ``lagged``, too."""
        return False

    def kick(self, t: float, parts: Parts, noise: Increment) -> Array | None:
        """Return the change of components by the noise of a short step, shape (d, P); None if it is unknown.

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
        """Rows of a state, in the order of `ito`'s names, that can be scaled up without violating constraints."""
        return slice(0, 0) if self.has_constraints else slice(None)

    @property
    def norm_parts(self) -> tuple[str, ...]:
        """Names of the components that `squared_norm` includes; empty means all of them."""
        return ()

    def squared_norm(self, parts: Parts) -> Array:
        """Return the squared norm of a state, shape (P,): the Euclidean one, unless the form overrides it."""
        return np.asarray(sum((part**2).sum(axis=0) for part in parts.values()))

    def index_lost(self, t: float, h: float, parts: Parts, noise: Increment) -> Mask:  # noqa: ARG002 - as above
        """Return the paths on which the constraint Jacobian becomes singular within the step, for any scheme.

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
        """Return the paths on which the constraint of index 1 has no regular root at x and lagged v.

        The root must continue the one at time 0.

        Parameters
        ----------
        t : float
        x, v : ndarray, shape (d, P)
            The solution at t, and one delay before t.
        """
        return np.zeros(x.shape[-1], dtype=bool)

    def residuals(self, parts: Parts) -> Mapping[str, Residual]:  # noqa: ARG002 - forms with constraints use it
        """Return the defect of each constraint by name; empty without constraints."""
        return {}


def briefly_signed(form: Form) -> Form:
    """Remove the types from a form's signature in `help`; its docstring gives them more briefly."""
    init = vars(form)["__init__"]
    init.__signature__ = Signature(
        [each.replace(annotation=each.empty) for each in signature(init).parameters.values()]
    )
    return form


def components(problem: Any) -> int:
    """Return the number of components of a problem's state."""
    return sum(len(part) for part in problem.parts(problem.initial(1)).values())
