"""Checks of schemes and problem functions at registration, and the specification of a problem.

Plans use, compare and send the specification to worker processes; the problem is built where it is run.
"""

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cached_property, lru_cache
from itertools import takewhile
from pathlib import Path

import numpy as np

from ..errors import FAULTS, ParameterError, ProblemError, SdaeverifyError, UsageError, one_line
from ..forms import Domain, Problem
from ..noise.laws import Law, why_unusable
from .labels import (
    REQUIRED,
    Parameter,
    checked_values,
    dataclass_parameters,
    describe_kind,
    function_parameters,
    make_label,
    parse_label,
    read_values,
)
from .measure import Measure
from .scheme import Claim, Scheme, are_texts
from .spelling import did_you_mean

CLASS_VARIABLES = ("name", "form", "noise", "law", "claims", "gives", "domain", "local_order_is_global", "source")
# Exceptions raised by arithmetic, by NumPy or by allocation for parameters far out of range.
OUT_OF_RANGE = (ArithmeticError, ValueError, MemoryError)
# Kinds of objects that the command ``list`` shows.
LISTED = ("scheme", "problem", "measure")
NAME = re.compile(r"[a-z0-9][a-z0-9.-]*")


@dataclass(frozen=True)
class ProblemSpec:
    """A problem function with parameters, not yet called.

    Attributes
    ----------
    name : str
        Registered name.
    function : callable, keyword parameters -> Problem
        A function at the top level of a module: it pickles by reference.
    parameters : tuple of (str, object)
        The parameters that were given.
    schemes, measures : tuple of str
        Labels of the schemes and names of the measures that the problem is crossed with; empty means all of a run.
    bound : frozenset of str, or None
        Names of the schemes that `schemes` selects from; schemes with other names are always crossed with the
        problem. None means that it selects from all schemes.
    """

    name: str
    function: Callable[..., Problem]
    parameters: tuple[tuple[str, object], ...] = ()
    schemes: tuple[str, ...] = field(default=(), compare=False)
    measures: tuple[str, ...] = field(default=(), compare=False)
    bound: frozenset[str] | None = field(default=None, compare=False)

    @cached_property
    def label(self) -> str:
        """Canonical label, ``name[key=value,...]``."""
        return make_label(self.name, function_parameters(self.function), dict(self.parameters))

    def select(
        self, schemes: Sequence[Scheme], measures: Sequence[Measure]
    ) -> tuple[tuple[Scheme, ...], tuple[Measure, ...]]:
        """Return the schemes and measures of a run that the problem is crossed with."""
        return (
            tuple(scheme for scheme in schemes if self._is_crossed(scheme)),
            tuple(measure for measure in measures if not self.measures or measure.name in self.measures),
        )

    def _is_crossed(self, scheme: Scheme) -> bool:
        free = not self.schemes or (self.bound is not None and scheme.name not in self.bound)
        return free or scheme.label in self.schemes

    def build(self) -> Problem:
        """Call the problem function.

        Raises
        ------
        ParameterError
            If a given parameter has another type than its default, if the problem cannot be built with it,
            or if it is not finite at its initial state. Without parameters, the function's own errors pass through.
        ProblemError
            If the function does not return a problem.
        """
        values = checked_values(f"problem {self.name!r}", function_parameters(self.function), dict(self.parameters))
        try:
            # The problem, or the form that it is compared in, reports values that are not finite by an exception.
            with np.errstate(all="ignore"):
                problem = self._call(values)
                if values:
                    problem.equation()
        except OUT_OF_RANGE as error:
            if not values:
                raise
            how = "" if isinstance(error, SdaeverifyError) else " cannot be built with these numbers"
            raise ParameterError(f"problem {self.label}{how}: {one_line(error)}") from error
        return problem

    def _call(self, values: Mapping[str, object]) -> Problem:
        problem: object = self.function(**values)
        if not isinstance(problem, Problem):
            where = f"{self.function.__qualname__} in {Path(inspect.getfile(self.function)).name}"
            raise ProblemError(f"{where} returned {describe(problem)}, expected a problem of one of the forms")
        return problem


# A problem computes its equation, views and references once and stores them. The cache holds the 64 problems used
# last.
@lru_cache(maxsize=64)
def built(spec: ProblemSpec) -> Problem:
    """Return the problem of a specification, built once per process until the next plan is made.

    Parameters
    ----------
    spec : ProblemSpec

    Raises
    ------
    ParameterError, ProblemError
        As `ProblemSpec.build`.
    """
    return spec.build()


def problem_spec(function: Callable[..., Problem], texts: Mapping[str, str] | None = None) -> ProblemSpec:
    """Return the specification of a problem function, with parameters given as the texts of a label.

    Raises
    ------
    UsageError
        If it is not a usable problem function.
    ParameterError
        If a parameter is unknown or its text cannot be converted to its type.
    """
    check_problem_function(function)
    name, parameters = problem_name(function), function_parameters(function)
    values = read_values(f"problem {name!r}", parameters, texts or {})
    # Store only the parameters that the canonical label shows, so that equal labels are equal specifications.
    shown = parse_label(make_label(name, parameters, values)).parameters or {}
    return ProblemSpec(name, function, tuple((p.name, values[p.name]) for p in parameters if p.name in shown))


def on_request(function: Callable[..., Problem]) -> Callable[..., Problem]:
    """Mark a problem function with long cells: a run of all problems omits it unless it is named or matched."""
    return in_matrix()(function)


def in_matrix(
    *rows: Mapping[str, object], schemes: Sequence[str] = (), measures: Sequence[str] = ()
) -> Callable[[Callable[..., Problem]], Callable[..., Problem]]:
    """Mark a problem function with the parameters that a run of all problems uses in place of the defaults.

    Globs select these problems, too; the bare name still selects the defaults.

    Parameters
    ----------
    *rows : mapping of str to object
        The parameters of each problem in the matrix.
    schemes, measures : sequence of str
        Labels of the schemes and names of the measures that these problems are crossed with in the matrix, if others
        would take long; all of them if omitted. The list selects among the schemes that come with the framework or
        with the plugin's own distribution. Schemes of other authors, which it could not name, are always crossed.

    Raises
    ------
    UsageError
        If a row is not a mapping.
    """
    for row in rows:
        if not isinstance(row, Mapping):
            raise UsageError(f"in_matrix expects a mapping of parameters for each problem, got {describe(row)}")

    def mark(function: Callable[..., Problem]) -> Callable[..., Problem]:
        function.in_matrix, function.crossed_with = rows, (tuple(schemes), tuple(measures))  # type: ignore[attr-defined]
        return function

    return mark


def matrix_specs(function: Callable[..., Problem]) -> tuple[ProblemSpec, ...]:
    """Return the specifications that a run of all problems uses; the one with the defaults if unmarked."""
    schemes, measures = getattr(function, "crossed_with", ((), ()))
    specs = (problem_spec(function, texts) for texts in _matrix_texts(function))
    return tuple(replace(spec, schemes=schemes, measures=measures) for spec in specs)


def problem_name(function: Callable[..., Problem]) -> str:
    """Return the registered name of a problem function: its own name with hyphens for underscores."""
    return function.__name__.replace("_", "-")


def check_scheme(scheme: object) -> None:
    """Raise if an object cannot serve as a scheme; no step is made.

    Raises
    ------
    UsageError
        If it is not an instance of a frozen dataclass, or of a subclass without further parameters, that sets the
        class variables and has a step.
    """
    if isinstance(scheme, type) and issubclass(scheme, Scheme):
        raise UsageError(f"expected a scheme, got {describe(scheme)}; write {scheme.__name__}()")
    if not isinstance(scheme, Scheme):
        raise UsageError(f"expected a scheme, got {describe(scheme)}")
    kind = type(scheme)
    check_name(f"scheme (class {kind.__name__})", getattr(kind, "name", None))
    owner = f"scheme {kind.name!r}"
    if lost := sorted(_lost_parameters(kind)):
        raise UsageError(
            f"{owner}: put @dataclass(frozen=True) above the class {kind.__name__}, for {', '.join(lost)}"
        )
    if mistaken := {field.name for field in fields(kind)} & set(CLASS_VARIABLES):
        raise UsageError(f"{owner}: annotate {', '.join(sorted(mistaken))} as ClassVar: they are not parameters")
    check_parameters(owner, dataclass_parameters(kind))
    # Tables, controls and stored evidence identify schemes by their labels, so a label must not be overridden.
    if kind.label is not Scheme.label:
        raise UsageError(f"{owner}: its label is computed from its name and parameters; do not override label")
    _check_declarations(owner, kind)
    if kind.step is Scheme.step and kind.prepare is Scheme.prepare:
        raise UsageError(f"{owner}: the class {kind.__name__} has no step; write its method step, or prepare")
    _check_law(owner, scheme.law)


def _check_law(owner: str, law: object) -> None:
    if not isinstance(law, Law):
        raise UsageError(f"{owner}: law expects a Law, such as THREE_POINT, got {describe(law)}")
    try:
        why = why_unusable(law)
    except FAULTS as error:
        why = one_line(error)
    if why:
        raise UsageError(f"{owner}: the law {law.name!r:.200} cannot be used: {why}")


def _lost_parameters(kind: type[Scheme]) -> set[str]:
    """Return the parameters lost by a missing decorator: declared by an undecorated class, or by its other bases."""
    plain = takewhile(lambda base: "__dataclass_params__" not in vars(base), kind.__mro__)
    hints = {name: hint for base in plain for name, hint in inspect.get_annotations(base).items()}
    inherited = {field.name for base in kind.__mro__ if is_dataclass(base) for field in fields(base)}
    return {name for name in hints if "ClassVar" not in str(hints[name])} | inherited - {f.name for f in fields(kind)}


def check_problem_function(function: object) -> None:
    """Raise if an object cannot serve as a problem function.

    Raises
    ------
    UsageError
        If it is not a function, or a parameter has no default that a label can show.
    ParameterError
        If a mark by `in_matrix` names an unknown parameter or has an invalid value.
    """
    if not inspect.isfunction(function):
        raise UsageError(f"expected a function that returns a problem, got {describe(function)}")
    check_name("problem function", problem_name(function))
    owner, parameters = f"problem {problem_name(function)!r}", function_parameters(function)
    check_parameters(owner, parameters)
    for texts in _matrix_texts(function):
        read_values(owner, parameters, texts)


def check_name(kind: str, name: object) -> None:
    """Raise if a name cannot be registered.

    Raises
    ------
    UsageError
        If it is not a text of lower-case letters, digits, hyphens and dots.
    """
    if not (isinstance(name, str) and NAME.fullmatch(name)):
        raise UsageError(f"name of a {kind} must be lower-case letters, digits, hyphens and dots, got {name!r}")


def check_parameters(owner: str, parameters: tuple[Parameter, ...]) -> None:
    """Raise unless all parameters have defaults of a type that a label can show.

    Raises
    ------
    UsageError
        If a parameter has no such default.
    """
    for parameter in parameters:
        if parameter.default is REQUIRED:
            raise UsageError(f"parameter {parameter.name} of {owner} has no default; give it one")
        if not describe_kind(parameter.default):
            kind = type(parameter.default).__name__
            raise UsageError(
                f"parameter {parameter.name} of {owner} has a default of type {kind}, "
                "expected bool, int, float or str"
            )


def describe(thing: object) -> str:
    """Return what an object is, in words for a message: ``the class X`` or ``an object of type Y``."""
    return f"the class {thing.__name__}" if isinstance(thing, type) else f"an object of type {type(thing).__name__}"


def unknown(kind: str, name: str, known: Mapping[str, object]) -> UsageError:
    """Return the error for an unregistered name, with close registered names or the command that lists them.

    Parameters
    ----------
    kind : str
        "scheme", "problem" or "measure".
    name : str
        The requested name.
    known : mapping by name
        The registered objects.
    """
    listed = f"; sdaeverify list {kind}s shows all" if kind in LISTED else ""
    return UsageError(f"unknown {kind} {name!r}{did_you_mean(name, known) or listed}")


def _matrix_texts(function: Callable[..., Problem]) -> list[dict[str, str]]:
    rows: tuple[Mapping[str, object], ...] = getattr(function, "in_matrix", ({},))
    return [{name: str(value) for name, value in row.items()} for row in rows]


def _check_declarations(owner: str, kind: type[Scheme]) -> None:
    form: object = getattr(kind, "form", None)
    forms = form if isinstance(form, tuple) and form else (form,)
    if not all(isinstance(each, type) and issubclass(each, Problem) for each in forms):
        raise UsageError(f"{owner}: form must be the form of problem it solves, for example SDE, got {form!r}")
    claims: object = kind.claims
    if not (isinstance(claims, tuple) and all(isinstance(claim, Claim) for claim in claims)):
        raise UsageError(f"{owner}: claims must be a tuple of Claim, got {describe(claims)}")
    gives: object = kind.gives
    if not are_texts(gives, tuple):
        raise UsageError(f"{owner}: gives must be a tuple of names of components, such as ('r', 'v'), got {gives!r}")
    if not isinstance(kind.domain, Domain | None):
        raise UsageError(f"{owner}: domain must be a Domain, such as Domain.orthant(), got {describe(kind.domain)}")
