"""The contract of a scheme: one time step and the claims of its author.

A scheme is a frozen dataclass; its fields are its parameters. It never draws numbers and never loops over
time; a step is a pure function that accepts any batch of paths.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import FrozenInstanceError, InitVar, dataclass
from math import nan
from numbers import Real
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from ..arrays import Array, Mask, Parts
from ..errors import SchemeError, UsageError, is_blank
from ..forms import Domain, Problem, why_not_within, why_unknown
from ..noise.brownian import Increment
from ..noise.laws import GAUSSIAN, Law
from .claimed import AT_H, IN_MEAN_SQUARE, SENSES, Bound, Exact, Order, Value, Word, as_value
from .labels import checked_values, dataclass_parameters, make_label

# One array (k, P), or a NamedTuple of arrays with the same P whose field names are component names.
State = Any


class Step(NamedTuple):
    """Return value of a step.

    Attributes
    ----------
    state : ndarray, shape (d, P), or NamedTuple of ndarray, shape (k, P) each
        The new state, of the same type as the old one. It holds all memory of the scheme, flags and counters
        included.
    failed : ndarray of bool, shape (P,), or None
        Paths without an admissible root; the docstring of the scheme says how it continues them.
    truncated : ndarray of bool, shape (P,), or None
        Paths on which the step was modified for stability, so that its order is not visible.
    outputs : mapping of str to ndarray
        Further results that are not memory, for example the multipliers of this step.
    costs : mapping of str to ndarray, shape (P,)
        Work of the step, for example iterations; reported as means over steps and paths. NaN marks a step that did
        no such work and is excluded from the mean.
    """

    state: State
    failed: Mask | None = None
    truncated: Mask | None = None
    outputs: Mapping[str, Array] = {}
    costs: Mapping[str, Array] = {}


# Suffix of a component name: the error at the final time only, instead of at all times.
AT_T = "@T"

Stepper = Callable[[State, float, Increment], Step]


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A property that a scheme's author claims.

    Attributes
    ----------
    measure : str
        Name of the measure that can verify it.
    value : Order or Exact or Bound or Word
        Given as a number, a minimum order; or as a text defined by the measure, such as ``round-off`` or
        ``unbiased``.
    source : str
        Theorem or equation, or ``measured`` for a conjecture.
    quantities : tuple of str
        Components or residuals to which the claim applies; at time T only if the name ends in ``@T``; empty for all.
    when : frozenset of str
        Traits that a problem must have; the claim is only tested on problems with all of them.
    sense : str
        ``in mean square``, or ``in probability``: along almost every path, and for means over the paths that stay in
        a large ball. An order in mean square is not verified if moments of the scheme grow without bound as h falls.
    margin : float, optional
        Amount by which an order may fall short of the value; becomes part of the value.
    bound : float, optional
        Bound on the named quantity: ``unbiased`` means a bias of at most this absolute value at every step size that
        is probed, in the unit of the quantity; becomes part of the value.
    share : float, optional
        Minimum fraction of the steps in which the bound holds, all if omitted; becomes part of the value.
    at : float, optional
        Step size at which a bound of an ``error`` holds, in the problem's unit of time; becomes part of the value.
    """

    measure: str
    value: float | str | Value
    source: str
    quantities: tuple[str, ...] = ()
    when: frozenset[str] = frozenset()
    sense: str = IN_MEAN_SQUARE
    margin: InitVar[float | None] = None
    bound: InitVar[float | None] = None
    share: InitVar[float | None] = None
    at: InitVar[float | None] = None

    def __post_init__(self, margin: float | None, bound: float | None, share: float | None, at: float | None) -> None:
        self._require_types({"margin": margin, "bound": bound, "share": share, "at": at})
        object.__setattr__(self, "value", as_value(self.value, margin, bound, share, at))
        if unknown := why_unknown(self.when):
            raise SchemeError(f"a claim holds for {unknown}")

    def _require_types(self, numbers: Mapping[str, object]) -> None:
        """Raise if a field has the wrong type.

        Raises
        ------
        UsageError
            If a field has the wrong type.
        """
        known = isinstance(self.value, str | Order | Exact | Bound | Word) or is_number(self.value)
        fits = {
            "measure": ("a text that is not blank", is_text(self.measure)),
            "value": ("an order, or words such as round-off", known),
            "source": ("a text that is not blank", is_text(self.source)),
            "quantities": ("a tuple of texts that are not blank", are_texts(self.quantities, tuple)),
            "when": ("a frozenset of texts", are_texts(self.when, frozenset)),
            "sense": (f"one of {', '.join(map(repr, SENSES))}", self.sense in SENSES),
            **{name: ("a number", each is None or is_number(each)) for name, each in numbers.items()},
        }
        for name, (expected, right) in fits.items():
            if not right:
                given = {**vars(self), **numbers}[name]
                raise UsageError(f"{name} of a claim expects {expected}, got {given!r:.200}")

    def covers(self, measure: str, quantity: str) -> bool:
        """Return whether the claim covers a quantity of a measure; a claim for all times includes the final time.

        A bound at a step size covers the quantity with this step size as its suffix, and no other claim does.
        """
        name, at, h = quantity.partition(AT_H)
        if at + h != (self.value.suffix if isinstance(self.value, Bound) else ""):
            return False
        named = any(is_about(name, each) for each in self.quantities)
        return measure == self.measure and (not self.quantities or named)

    def __str__(self) -> str:
        return str(self.value) if self.sense == IN_MEAN_SQUARE else f"{self.value} {self.sense}"


def is_text(value: object) -> bool:
    """Return whether an object is a text that is not blank."""
    return isinstance(value, str) and not is_blank(value)


def are_texts(value: object, kind: type) -> bool:
    """Return whether an object is a collection of type `kind` of non-blank texts; a single text is not."""
    return isinstance(value, kind) and all(map(is_text, value))  # type: ignore[call-overload]


def is_number(value: object) -> bool:
    """Return whether an object is a real number; booleans are excluded."""
    return isinstance(value, Real) and not isinstance(value, bool)


def is_about(quantity: str, name: str) -> bool:
    """Return whether a claim's name covers a quantity; a claim for all times includes the final time."""
    return name in {quantity, quantity.removesuffix(AT_T)}


class _Frozen:
    # The decorator freezes only the class it decorates; a subclass without parameters needs no decorator.
    def __setattr__(self, name: str, value: object) -> None:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")


@dataclass(frozen=True)
class Scheme(_Frozen):
    """Base of all schemes: a subclass sets the class variables and writes `step`.

    Attributes
    ----------
    name : str
        Registered name, in lower case with hyphens.
    form : type or tuple of type
        The form it solves, or several. A problem of one of the forms is passed unchanged, any other problem in its
        view of the first form for which it has one.
    noise : frozenset of str
        Fields of `Increment` it uses, out of ``dW``, ``H``, ``K`` and ``A``. Mean and covariance of a step are
        compared with the equation for any of them; a step with K has no local order and is judged by its paths.
    claims : tuple of Claim
    gives : tuple of str
        Names of the components of the solution that its state holds; empty for all of them. A scheme for mechanics
        without multiplier gives ``("r", "v")``: its steps are compared with the equation of these components alone.
    domain : Domain, optional
        Set of states that the scheme is made for and stays in, such as ``Domain.orthant()`` for nonnegative states.
        It is run on problems whose domain is contained in it. Order conditions and random members do not apply
        because their equations are on the whole space.
    local_order_is_global : bool
        Whether its global order, strong or weak, is visible in one step. It is not if later steps cancel the errors
        of single steps: effective order, processing, alternating steps of two kinds, a projection that resets the
        defect. A low local order is then not decisive.
    discontinuous_in_noise : bool
        Whether a step is a discontinuous function of its noise, as in accept-reject schemes. Cubature nodes cannot
        determine its order then, so paths and chains do; short steps must still follow the equation.
    on_request : bool
        Whether a run of all schemes omits it: it runs only if it is named, or matched by a pattern.
    build : str or None
        Hash of code that steps depend on outside Python, such as an executable. Evidence of another build is not
        reused; if it is None, the code is unknown and no evidence is reused.
    source : str
    """

    name: ClassVar[str]
    form: ClassVar[type[Problem] | tuple[type[Problem], ...]]
    noise: ClassVar[frozenset[str]] = frozenset({"dW"})
    claims: ClassVar[tuple[Claim, ...]] = ()
    gives: ClassVar[tuple[str, ...]] = ()
    domain: ClassVar[Domain | None] = None
    local_order_is_global: ClassVar[bool] = True
    discontinuous_in_noise: ClassVar[bool] = False
    on_request: ClassVar[bool] = False
    build: ClassVar[str | None] = ""
    source: ClassVar[str] = ""

    def __new__(cls, *given: object, **named: object) -> Self:
        """Check that parameters have the types of their defaults, before the scheme's own `__post_init__` runs."""
        parameters = dataclass_parameters(cls)
        values = dict(zip((p.name for p in parameters), given, strict=False)) | named
        checked_values(f"scheme {getattr(cls, 'name', cls.__name__)!r}", parameters, values)
        return super().__new__(cls)

    @property
    def claimant(self) -> str:
        """Distribution that makes the claims and gates them; empty for the distribution that registers the scheme."""
        return ""

    @property
    def label(self) -> str:
        """Canonical label: the name and the parameters that differ from their defaults."""
        parameters = dataclass_parameters(type(self))
        return make_label(self.name, parameters, {p.name: getattr(self, p.name) for p in parameters})

    @property
    def forms(self) -> tuple[type[Problem], ...]:
        """The forms that the scheme solves, as a tuple."""
        return self.form if isinstance(self.form, tuple) else (self.form,)

    def view_of(self, problem: Problem) -> Problem | None:
        """Return a problem in a form and with the components that the scheme solves, or None without such a view."""
        if isinstance(problem, self.forms):
            return problem.giving(self.gives)
        seen = next((seen for form in self.forms if (seen := problem.view(form)) is not None), None)
        return None if seen is None else seen.giving(self.gives)

    @property
    def law(self) -> Law:
        """Law of the ``dW`` it is given: Brownian increments, or variables coupled to them.

        A subclass sets it as a class variable, or as a property if it depends on the parameters.
        """
        return GAUSSIAN

    def refuses(self, problem: Any) -> str:  # noqa: ARG002 - most schemes refuse nothing
        """Return why the scheme cannot solve a problem of its form, or an empty string."""
        return ""

    def why_not(self, problem: Any) -> str:
        """Return why the scheme does not apply to a problem of its form: its domain, or the text of `refuses`."""
        return why_not_within(problem, self.domain) or self.refuses(problem)

    @property
    def promises(self) -> tuple[Claim, ...]:
        """The claims for these parameters: `claims`, unless a scheme's claims depend on its parameters."""
        return self.claims

    @property
    def choices(self) -> Mapping[str, Collection[str]]:
        """Admissible texts of parameters, by name; any text is admissible for other parameters."""
        return {}

    def stable_below(self, problem: Any) -> float:  # noqa: ARG002 - few schemes have such a theorem
        """Return the step size below which a theorem says that second moments tend to 0; NaN if none applies."""
        return nan

    def enter(self, problem: Any, state: State, t: float, h: float) -> State:  # noqa: ARG002 - most add no memory
        """Return the scheme's state, for steps of size h, that corresponds to the problem's `state` at time t.

        A scheme with further memory adds it here. The past is unknown: memory of earlier steps is replaced by the
        values that a step of lower order would have left. Orders above the order at which this replacement changes a
        run are judged by paths alone; so are all orders if the change does not vanish with h.

        Parameters
        ----------
        problem : Problem
            In the form that the scheme solves.
        state : ndarray or NamedTuple of ndarray
            The problem's state, paths last.
        t : float
        h : float
        """
        return state

    def start(self, problem: Any, paths: int, h: float) -> State:
        """Return the initial state on a number of paths, for steps of size h.

        Parameters
        ----------
        problem : Problem
            In the form that the scheme solves.
        paths : int
            Number P of paths.
        h : float
            Step size; the memory of a scheme may depend on it.
        """
        return self.enter(problem, problem.initial(paths), 0.0, h)

    def parts(self, problem: Any, state: State) -> Parts:
        """Return the components of a state that can be compared with other states, under the problem's names.

        A bare array is split by the problem; for a NamedTuple, the fields with rows are the components. A scheme
        with further memory overrides this method to leave it out.
        """
        if not isinstance(state, tuple):
            named: Parts = problem.parts(state)
            return named
        fields: Parts = state._asdict()  # type: ignore[attr-defined]
        return {name: part for name, part in fields.items() if len(part)}

    def prepare(self, problem: Any, h: float) -> Stepper:
        """Return the step for one problem and step size; override it to compute constants once."""

        def stepper(state: State, t: float, noise: Increment) -> Step:
            return self.step(problem, state, t, h, noise)

        return stepper

    def step(self, problem: Any, state: State, t: float, h: float, noise: Increment) -> Step:
        """Make one step of size h from time t.

        Parameters
        ----------
        problem : Problem
            Of the scheme's form.
        state : ndarray or NamedTuple of ndarray, P paths
            Must not be written into.
        t, h : float
            Time and step size, in the problem's unit of time.
        noise : Increment
            Must not be written into.

        Returns
        -------
        Step
        """
        raise NotImplementedError


def with_claims(scheme: Scheme, *claims: Claim) -> Scheme:
    """Return a copy of a scheme with other claims; the copy cannot be pickled."""
    other = type(type(scheme).__name__, (type(scheme),), {"promises": claims})
    copy: Scheme = object.__new__(other)
    copy.__dict__.update(scheme.__dict__)
    return copy


def form_names(scheme: Scheme) -> str:
    """Return the names of the forms a scheme solves, joined by ``or``."""
    return " or ".join(form.__name__ for form in scheme.forms)


def flatten(state: State) -> Array:
    """Return all memory of a scheme as one array, shape (k, P).

    Raises
    ------
    SchemeError
        If a field of the state is not an array (k, P) with the same number P of paths.
    """
    if not isinstance(state, tuple):
        whole: Array = state
        return whole
    paths = np.shape(state[0])[-1] if np.ndim(state[0]) else "P"
    for name, field in zip(getattr(state, "_fields", range(len(state))), state, strict=True):
        if np.ndim(field) != 2 or np.shape(field)[1] != paths:
            given = f"{type(field).__name__} of shape {np.shape(field)}"
            raise SchemeError(f"field {name} of the state is {given}, expected an array of shape (k, {paths})")
    return np.concatenate(state)


def require_step(result: object) -> Step:
    """Return the return value of a step unchanged, after checking its type.

    Raises
    ------
    SchemeError
        If it is not a `Step`.
    """
    if not isinstance(result, Step):
        raise SchemeError(f"step returned {type(result).__name__}, expected Step(state)")
    return result


def same_kind(before: State, result: object) -> None:
    """Check that a step returned a `Step` whose state has the structure of the given one.

    Raises
    ------
    SchemeError
        If it is not a `Step`, or if the type, the fields, the shapes or the data types of its state differ.
    """
    after = require_step(result).state
    if type(before) is not type(after) or _arrays(before) != _arrays(after):
        raise SchemeError(
            f"step returned {_describe(after)}, expected a state like the one it was given, {_describe(before)}"
        )


def _arrays(state: State) -> list[tuple[tuple[int, ...], str]]:
    arrays = state if isinstance(state, tuple) else (state,)
    return [(np.shape(x), np.asarray(x).dtype.name) for x in arrays]


def _describe(state: State) -> str:
    return f"{type(state).__name__} of {', '.join(f'{name} {shape}' for shape, name in _arrays(state))}"
