"""What the conformance tests are run over: the registry, crossed by the rule the program itself uses."""

from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from sdaeverify.forms import Problem
from sdaeverify.matching import match
from sdaeverify.planted import Planted
from sdaeverify.registry import Registry
from sdaeverify.scheme import Scheme
from sdaeverify.specs import ProblemSpec
from sdaeverify.testing.problem_subject import ProblemSubject
from sdaeverify.testing.questions import Question, problem_questions
from sdaeverify.testing.subjects import CellSubject, SchemeSubject, components
from sdaeverify.testing.table import checks

# Parameters that switch truths or terms on which the defaults leave off.
VARIANTS = {
    "damped-pendulum": ({"c_g": "0.0"}, {"c_g": "0.0", "gamma": "0.3", "kT": "1.5"}),
    "delay-linear": ({"c": "0.0"},),
    "delay-test": ({"set": "II"}, {"set": "V", "l": "0.0"}, {"horizon": "1.0"}),
    "double-well": ({"sigma": "0.5"},),
    "ellipse": ({"measure": "delta"},),
    "fibre-clamped": ({"d": "3", "N": "3"},),
    "fibre-free": ({"d": "3", "N": "3"},),
    "gbm-algebraic": ({"tau": "0.3"},),
    "nonlinear-constraint": ({"tau": "0.0"},),
    "ou": ({"a": "-0.8"},),
    "pendulum": ({"c_g": "0.0"}, {"c_g": "0.0", "omega_0": "-1.5", "theta_0": "2.0"}),
    "pendulum-velocity-noise": ({"gamma": "0.7", "sigma": "0.3"}, {"gamma": "0.5", "sigma": "1.0"}),
}
# So many views of each form are tried, and each with its own schemes everywhere.
VIEWS = 1
# What takes seconds: controls everywhere, and these on long problems.
LONG = frozenset({"solution-simulated", "moments-simulated", "moments-settle"})
LATE = frozenset({"delay-ou"})


class Cell(NamedTuple):
    """A scheme and a problem of the form it solves."""

    scheme: Scheme
    problem: Problem
    label: str


def schemes(registry: Registry) -> list[Scheme]:
    """Return every default variant of every scheme."""
    return [scheme for entry in registry.schemes.values() for scheme in entry.variants]


def specs(registry: Registry) -> list[ProblemSpec]:
    """Return every problem with its defaults, and some with other parameters."""
    defaults = [entry.make() for entry in registry.problems.values()]
    entries = registry.problems.items()
    return defaults + [entry.make(texts) for name, entry in entries for texts in VARIANTS.get(name, ())]


def cells(registry: Registry) -> Iterator[Cell]:
    """Yield every scheme variant with every problem of its form that matches, and with some views of each other form.

    A view is the same code for all problems of a form: those of fewest components stand for them.
    """
    built = [(entry.make().label, entry.make().build()) for entry in registry.problems.values()]
    for scheme in schemes(registry):
        seen: Counter[type[Problem]] = Counter()
        for label, problem in sorted(built, key=lambda pair: components(pair[1])):
            found = match(scheme, problem).problem
            if found is None:
                continue
            seen[type(problem)] += 1
            if found is problem or seen[type(problem)] <= VIEWS:
                yield Cell(scheme, found, f"{scheme.label} on {label}")


def breaches(registry: Registry) -> list[Planted]:
    """Return the planted bugs that break a contract or are inexact."""
    modules = {"contract", "exactness"}
    return [entry.planted for entry in registry.planted.values() if entry.origin.module.split(".")[-1] in modules]


def questions_of_schemes(registry: Registry) -> Iterator[Question]:
    """Yield what every scheme is asked once."""
    for scheme in schemes(registry):
        for check in (check for check in checks("scheme") if not check.each_problem):
            yield Question(check, scheme.label, "scheme", "", SchemeSubject(scheme, registry))


def questions_of_cells(registry: Registry) -> Iterator[Question]:
    """Yield what every scheme is asked on each of its problems."""
    for cell in cells(registry):
        subject = CellSubject(cell.scheme, cell.problem, cell.label)
        for check in (check for check in checks("scheme") if check.each_problem):
            yield Question(check, cell.label, "scheme", "", subject)


def questions_of_problems(registry: Registry, *, long: bool) -> Iterator[Question]:
    """Yield what every problem is asked: what takes seconds, or the rest."""
    for spec in specs(registry):
        slow = {"controls"} | (LONG if registry.problems[spec.name].on_request or spec.name in LATE else frozenset())
        for question in problem_questions(ProblemSubject(spec, registry), None):
            if (question.check.name in slow) is long:
                yield question


def name_of(question: Question) -> str:
    """Return what a question is about, for the id of a test."""
    return f"{question.check.name}: {question.label}"
