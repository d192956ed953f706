"""What the conformance tests are run over: the registry, crossed by the rule the program itself uses."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import NamedTuple

from facade import (
    CellSubject,
    Planted,
    ProblemSpec,
    ProblemSubject,
    Question,
    Registry,
    SchemeSubject,
    Trial,
    components,
    match,
    problem_questions,
)
from sdaeverify import Problem, Scheme
from sdaeverify.testing import checks

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
    "penalised-sphere": ({"pull": "0.0", "damping": "0.7", "spin": "1.3"},),
    "pendulum": ({"c_g": "0.0"}, {"c_g": "0.0", "omega_0": "-1.5", "theta_0": "2.0"}),
    "pendulum-velocity-noise": ({"gamma": "0.7", "sigma": "0.3"}, {"gamma": "0.5", "sigma": "1.0"}),
}
# Matrices take long where steps are so long that roots have to be followed: they still are on the orthogonal group.
# So do chains of many points, whose formulas are those of a few. On steps that are far too long for a clamped fibre,
# explicit positions leave the noise below rounding: it has the horizon of a default run.
SHORTER = {
    "fibre-clamped": {"N": "3", "horizon": "0.01"},
    "fibre-free": {"N": "3"},
    "orthogonal-group": {"horizon": "0.25"},
    "stiefel": {"horizon": "0.0625"},
}
# So many views of each form are tried, and each with its own schemes everywhere.
VIEWS = 1
# So many schemes are put to each problem by fast and long tests, and one if all had their turn: a default run tries
# the contract on every cell.
TURNS = 2
# Where a scheme of several steps takes a second, because its memory is followed for long.
FOLLOWED = ("driven-double-pendulum", "noisy-circuit")
# What takes seconds: controls everywhere, and these on long problems.
LONG = frozenset({"solution-simulated", "moments-simulated", "moments-settle"})
LATE = frozenset({"delay-ou"})


class Cell(NamedTuple):
    """A scheme and a problem of the form it solves."""

    scheme: Scheme
    problem: Problem
    label: str


class Shared(CellSubject):
    """A scheme on a problem whose checks share their trials, as those do that every run begins with."""

    @cached_property
    def trials(self) -> tuple[Trial, ...]:
        """The trials, of which the first check, that inputs are left alone, sees every first step."""
        return tuple(super().trials)

    @cached_property
    def coarse(self) -> Trial:
        """The coarse trial."""
        return super().coarse


def schemes(registry: Registry) -> list[Scheme]:
    """Return every default variant of every scheme."""
    return [scheme for entry in registry.schemes.values() for scheme in entry.variants]


def specs(registry: Registry) -> list[ProblemSpec]:
    """Return every problem with its defaults, as it is in the matrix, and with some other parameters."""
    own = [
        spec
        for entry in registry.problems.values()
        for spec in {entry.make(): None, **dict.fromkeys(entry.in_matrix)}
    ]
    entries = registry.problems.items()
    return own + [entry.make(texts) for name, entry in entries for texts in VARIANTS.get(name, ())]


def cells(registry: Registry) -> Iterator[Cell]:
    """Yield every scheme variant with every problem of its form that matches, and with some views of each other form.

    A view is the same code for all problems of a form: those of fewest components stand for them.
    """
    made = [entry.make(SHORTER.get(name)) for name, entry in registry.problems.items()]
    built = [(spec.label, spec.build()) for spec in made]
    for scheme in schemes(registry):
        seen: Counter[type[Problem]] = Counter()
        for label, problem in sorted(built, key=lambda pair: components(pair[1])):
            found = match(scheme, problem).problem
            if found is None:
                continue
            seen[type(problem)] += 1
            if found is problem or seen[type(problem)] <= VIEWS:
                yield Cell(scheme, found, f"{scheme.label} on {label}")


def in_turn(registry: Registry) -> tuple[list[Cell], list[Cell]]:
    """Return the cells of fast and long tests, variants on each problem that had the fewest turns, and all others."""
    turns: Counter[str] = Counter()
    on_problems: dict[str, list[Cell]] = defaultdict(list)
    chosen, others = list[Cell](), list[Cell]()
    for cell in cells(registry):
        on_problems[cell.label.partition(" on ")[2]].append(cell)
    for found in on_problems.values():
        found.sort(key=lambda cell: turns[cell.scheme.label])
        waiting = sum(not turns[cell.scheme.label] for cell in found)
        count = max(1, min(TURNS, waiting))
        turns.update(cell.scheme.label for cell in found[:count])
        chosen += found[:count]
        others += found[count:]
    return chosen, others


def is_late(label: str) -> bool:
    """Return whether a cell or problem is one of the long tests: it takes a second, or has other parameters."""
    subject = label.partition(" on ")[0]
    return "[" in subject or label.endswith(FOLLOWED)


def breaches(registry: Registry) -> list[Planted]:
    """Return the planted bugs that break a contract or are inexact."""
    modules = {"contracts"}
    entries = registry.entries["sdaeverify_planted"].values()
    return [entry.thing for entry in entries if entry.origin.module.split(".")[-1] in modules]


class Inquiry(NamedTuple):
    """All that is asked of one subject: states that take a run to find are found once."""

    label: str
    questions: list[Question]


def asked_of_schemes(registry: Registry, *, long: bool) -> Iterator[Inquiry]:
    """Yield what every scheme is asked once: whether its claims are tested, for which cells are run, or the rest."""
    every = [check for check in checks("scheme") if not check.each_problem]
    once = [check for check in every if (check.name == "claims-tested") is long]
    for scheme in schemes(registry):
        subject = SchemeSubject(scheme, registry)
        yield Inquiry(scheme.label, [Question(check, scheme.label, "scheme", "", subject) for check in once])


def asked_of_cells(found: Iterable[Cell]) -> Iterator[Inquiry]:
    """Yield what a scheme is asked on each of its problems."""
    each = [check for check in checks("scheme") if check.each_problem]
    for cell in found:
        subject = Shared(cell.scheme, cell.problem, cell.label)
        yield Inquiry(cell.label, [Question(check, cell.label, "scheme", "", subject) for check in each])


def asked_of_problems(registry: Registry) -> Iterator[tuple[Inquiry, Inquiry]]:
    """Yield what every problem is asked: what is answered soon, and what takes seconds."""
    for spec in specs(registry):
        entry = registry.problems[spec.name]
        long_by_default = entry.make() not in entry.in_matrix
        slow = {"controls"} | (LONG if long_by_default or spec.name in LATE else frozenset())
        asked = problem_questions(ProblemSubject(spec, registry), None)
        yield tuple(
            Inquiry(spec.label, [question for question in asked if (question.check.name in slow) is long])
            for long in (False, True)
        )
