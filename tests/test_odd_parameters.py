"""Whatever a problem or a scheme is asked for with, it is taken, or refused in one line: of all that is installed."""

import resource

import numpy as np
import pytest

from facade import ProblemSpec, dataclass_parameters, function_parameters, load_plugins, parse_label
from sdaeverify import UsageError

NUMBERS = [float("nan"), float("inf"), -float("inf"), 0, -1, 1.5, 1e300, -1e300, 1e-300, 10**9, 10**30, 10**400]
ODD = [*NUMBERS, True, "x", "", None, [1.0], 1j, object()]
INSTALLED = load_plugins().schemes.items()
PARAMETRISED = {name: entry for name, entry in INSTALLED if entry.parameters}
GIGABYTES = 3 << 30
# What takes seconds to build where a parameter is large.
SECONDS = {"sphere-langevin"}


@pytest.fixture
def little_memory():
    """Let arrays of many gigabytes fail at once, wherever the tests are run."""
    limits = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (GIGABYTES, limits[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, limits)


def start(problem):
    """Return all numbers of a problem at its initial state."""
    parts, equation = problem.parts(problem.initial(2)), problem.equation()
    values = [*parts.values(), *(observable(0.0, parts) for observable in problem.observables.values())]
    if equation is not None:
        values += [f(0.0, equation.initial(2)) for f in (equation.drift, equation.diffusion)]
    return np.concatenate([np.ravel(value) for value in values])


def refused(names, odd, make):
    """Return which odd values of which parameters are refused in one line; what else is raised passes through."""
    said = {}
    for name in names:
        for place, value in enumerate(odd):
            try:
                make(name, value)
            except UsageError as error:
                said[name, place] = str(error)
    assert all(text and "\n" not in text for text in said.values())
    return said


@pytest.mark.sweep
@pytest.mark.usefixtures("little_memory")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long) if name in SECONDS else name
        for name in sorted(load_plugins().problems)
    ],
)
def test_parameters_of_problems(name):
    """A problem is finite at its start whatever its parameters are, or they are refused in one line."""
    family = load_plugins().problems[name].thing
    kinds = {p.name: p.default for p in function_parameters(family)}

    def make(parameter, value):
        problem = ProblemSpec(name, family, ((parameter, value),)).build()
        with np.errstate(all="ignore"):
            assert np.isfinite(start(problem)).all(), (parameter, value)

    said = refused(kinds, ODD, make)

    for parameter, default in kinds.items():
        words = {ODD.index(word) for word in ("x", "")} if isinstance(default, str) else set()
        never = set(range(len(NUMBERS), len(ODD))) - words
        assert never <= {place for other, place in said if other == parameter}


@pytest.mark.parametrize("name", sorted(PARAMETRISED))
def test_parameters_of_schemes(name):
    """A scheme that takes a value has a label that gives it back, or the value is refused in one line."""
    entry = PARAMETRISED[name]
    kind = entry.subject

    def make(parameter, value):
        scheme = kind(**{parameter: value})
        assert entry.make(parse_label(scheme.label).parameters).label == scheme.label

    assert refused((p.name for p in dataclass_parameters(kind)), ODD, make)


def test_what_is_wrong_is_named():
    """The parameter and what was given stand in the line, the same from Python and in a label."""
    problems = load_plugins().problems
    for label, message in (
        ("damped-pendulum[gamma=inf]", "parameter gamma of problem 'damped-pendulum' must be finite, got 'inf'"),
        ("affine-constraint[sigma=1e300]", "cannot be built with these numbers: OverflowError"),
        ("gbm[x_0=1e300]", r"observable 'x\^2' is inf at the initial state"),
        ("sphere-product[mixing=1e300]", r"drift\(t, x\) is not finite at the initial state"),
    ):
        name, texts = parse_label(label)
        with pytest.raises(UsageError, match=message):
            problems[name].make(texts).build()
