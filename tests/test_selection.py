"""Selections: what a request for schemes, problems and measures means."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, ClassVar

import pytest

from facade import (
    MEASURES,
    PROBLEMS,
    SCHEMES,
    Origin,
    ProblemSpec,
    Registered,
    Registry,
    check_problem_function,
    select_measures,
    select_problems,
    select_schemes,
)
from sdaeverify import SDE, ParameterError, Problem, Scheme, UsageError, in_matrix

MINE = SimpleNamespace(name="mine")
ORIGIN = Origin("test", "test", "1", "test")


@dataclass(frozen=True)
class HalfExplicit(Scheme):
    truncation: str | float = "theory"
    name: ClassVar[str] = "half-explicit"
    form: ClassVar[type[Problem]] = SDE

    def step(self, problem, state, t, h, noise):
        raise NotImplementedError


@dataclass(frozen=True)
class HalfOther(Scheme):
    truncation: str | float = "none"
    name: ClassVar[str] = "half-other"
    form: ClassVar[type[Problem]] = SDE

    def step(self, problem, state, t, h, noise):
        raise NotImplementedError


class Euler(Scheme):
    name: ClassVar[str] = "euler"
    form: ClassVar[type[Problem]] = SDE

    def step(self, problem, state, t, h, noise):
        raise NotImplementedError


class AnotherEuler(Scheme):
    name: ClassVar[str] = "euler"
    form: ClassVar[type[Problem]] = SDE

    def step(self, problem, state, t, h, noise):
        raise NotImplementedError


class Asked(Scheme):
    name: ClassVar[str] = "asked"
    form: ClassVar[type[Problem]] = SDE
    on_request: ClassVar[bool] = True

    def step(self, problem, state, t, h, noise):
        raise NotImplementedError


class Disguised(Scheme):
    name: ClassVar[str] = "disguised"
    form: ClassVar[type[Problem]] = SDE

    @property
    def label(self) -> str:
        return "euler"


def pendulum(c_g: float = 1.0) -> SDE:
    return SDE(
        drift=lambda t, x: -x,
        diffusion=lambda t, x: x[:, None],
        start=[c_g],
        noise_dim=1,
        horizon=1.0,
        source="made up",
    )


def pendulum_long(c_g: float = 2.0) -> SDE:
    return pendulum(c_g)


@pytest.fixture
def registry() -> Registry:
    """Three schemes, two problems and two measures."""
    schemes: dict[str, tuple[Scheme, ...]] = {
        "euler": (Euler(),),
        "half-explicit": (HalfExplicit(), HalfExplicit("none")),
        "half-other": (HalfOther("theory"),),
    }
    families = {"pendulum": pendulum, "pendulum-long": pendulum_long}
    measures = {name: SimpleNamespace(name=name) for name in ("drift", "strong")}
    return Registry(
        {
            SCHEMES: {name: Registered(name, variants, ORIGIN) for name, variants in schemes.items()},
            PROBLEMS: {name: Registered(name, (family,), ORIGIN) for name, family in families.items()},
            MEASURES: {name: Registered(name, (measure,), ORIGIN) for name, measure in measures.items()},
        }
    )


@pytest.mark.parametrize(
    ("patterns", "labels"),
    [
        ([], ["euler", "half-explicit", "half-explicit[truncation=none]", "half-other[truncation=theory]"]),
        (["euler,"], ["euler"]),
        ("half-explicit,euler", ["euler", "half-explicit"]),
        (["half-explicit", "euler"], ["euler", "half-explicit"]),
        (["half-explicit[truncation=none]"], ["half-explicit[truncation=none]"]),
        (["half-explicit[truncation=0.5],euler"], ["euler", "half-explicit[truncation=0.5]"]),
        (["half-explicit[truncation=theory]", "half-explicit"], ["half-explicit"]),
        (["half-other"], ["half-other"]),
        (["half-*"], ["half-explicit", "half-explicit[truncation=none]", "half-other[truncation=theory]"]),
        (["half-*[]"], ["half-explicit", "half-other"]),
        (["half-*[truncation=2]"], ["half-explicit[truncation=2]", "half-other[truncation=2]"]),
        (["?uler"], ["euler"]),
        ([HalfExplicit(0.25), "euler", Euler()], ["euler", "half-explicit[truncation=0.25]"]),
    ],
)
def test_schemes(registry: Registry, patterns: Any, labels: list[str]) -> None:
    """A name is the default scheme, a glob all variants, brackets set parameters; the registry orders."""
    assert [scheme.label for scheme in select_schemes(registry, patterns)] == labels


def test_a_run_of_everything_leaves_out_what_is_run_on_request(registry: Registry) -> None:
    """Without patterns no scheme on request is taken, be its library installed or not; a glob or a name takes it."""
    asked = Registry({SCHEMES: {**registry.schemes, "asked": Registered("asked", (Asked(),), ORIGIN)}})

    assert "asked" not in {scheme.label for scheme in select_schemes(asked)}
    for pattern in ("asked", "a*", "*"):
        assert "asked" in {scheme.label for scheme in select_schemes(asked, [pattern])}


@pytest.mark.parametrize(
    ("patterns", "message"),
    [
        (["half-explict"], "unknown scheme 'half-explict'; did you mean half-explicit?"),
        (["half"], "unknown scheme 'half'; did you mean half-explicit or half-other?"),
        (["xyz-*"], "unknown scheme 'xyz-*'; sdaeverify list schemes shows all"),
        ("", "empty selection of schemes: ''"),
        ([","], "empty selection of schemes: ','"),
        (["euler[a=1"], "cannot read 'euler[a=1': expected name[key=value,...]"),
        ([Euler], "expected a scheme, got the class Euler; write Euler()"),
        ([3], "expected a scheme, got an object of type int"),
        (
            [AnotherEuler()],
            "the given scheme is named 'euler', like one registered by plugin test (test 1); give it another name",
        ),
        (
            [Disguised()],
            "scheme 'disguised': its label is computed from its name and parameters; do not override label",
        ),
    ],
)
def test_refused_schemes(registry: Registry, patterns: Any, message: str) -> None:
    """A selection that means nothing is one line with the kind, the name and what is close."""
    with pytest.raises(UsageError) as caught:
        select_schemes(registry, patterns)

    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("wanted", "labels"),
    [
        ([], ["pendulum", "pendulum-long"]),
        (["pendulum"], ["pendulum"]),
        ("pendulum*[c_g=2]", ["pendulum[c_g=2]", "pendulum-long"]),
        (["pendulum[c_g=3]", "pendulum", "pendulum[c_g=1]"], ["pendulum", "pendulum[c_g=3]"]),
        ([pendulum_long, "pendulum", pendulum], ["pendulum", "pendulum-long"]),
        ([ProblemSpec("pendulum", pendulum, (("c_g", 5.0),))], ["pendulum[c_g=5]"]),
    ],
)
def test_problems(registry: Registry, wanted: Any, labels: list[str]) -> None:
    """Patterns, functions and recipes may be mixed."""
    assert [spec.label for spec in select_problems(registry, wanted)] == labels


def marked(*rows: Any) -> Any:
    """Return the long pendulum with these rows in the matrix."""

    def pendulum_long(c_g: float = 2.0) -> SDE:
        return pendulum(c_g)

    return in_matrix(*rows)(pendulum_long)


@pytest.mark.parametrize(
    ("wanted", "labels"),
    [
        ([], ["pendulum", "pendulum-long[c_g=1]", "pendulum-long[c_g=3]"]),
        ("pendulum-*", ["pendulum-long[c_g=1]", "pendulum-long[c_g=3]"]),
        ("pendulum-*[c_g=5]", ["pendulum-long[c_g=5]"]),
        ("pendulum-long", ["pendulum-long"]),
    ],
)
def test_rows_of_the_matrix(registry: Registry, wanted: Any, labels: list[str]) -> None:
    """Everything and globs mean the parameters a problem has in the matrix, its name the defaults."""
    entry = Registered("pendulum-long", (marked({"c_g": 1.0}, {"c_g": 3.0}),), ORIGIN)
    changed = Registry({PROBLEMS: {**registry.problems, "pendulum-long": entry}})

    assert [spec.label for spec in select_problems(changed, wanted)] == labels


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"c_h": 1.0}, "no parameter 'c_h'; did you mean c_g?"),
        ({"c_g": "heavy"}, "parameter c_g of problem 'pendulum-long' expects a number, got 'heavy'"),
        ("c_g=1", "in_matrix expects a mapping of parameters for each problem, got an object of type str"),
        (pendulum, "in_matrix expects a mapping of parameters for each problem, got an object of type function"),
    ],
)
def test_refused_rows(row: Any, message: str) -> None:
    """What a problem function is marked with is checked where it is registered."""
    with pytest.raises((ParameterError, UsageError)) as caught:
        check_problem_function(marked(row))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        (["pendulun"], "unknown problem 'pendulun'; did you mean pendulum?"),
        ([""], "empty selection of problems: ''"),
        (
            [pendulum()],
            "expected a function that returns a problem, got an object of type SDE: pass it uncalled",
        ),
        ([3], "expected a function that returns a problem, got an object of type int"),
        (
            ["pendulum", ProblemSpec("pendulum", pendulum_long)],
            "two different problems are labelled 'pendulum'; select one of them",
        ),
    ],
)
def test_refused_problems(registry: Registry, wanted: Any, message: str) -> None:
    """A selection that means nothing is one line."""
    with pytest.raises(UsageError) as caught:
        select_problems(registry, wanted)

    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("wanted", "names"),
    [([], ["drift", "strong"]), (["s*"], ["strong"]), ([MINE, "drift"], ["drift", "mine"])],
)
def test_measures(registry: Registry, wanted: Any, names: list[str]) -> None:
    """Measures are selected by name and by glob, or given as they are."""
    assert [measure.name for measure in select_measures(registry, wanted)] == names


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        (["strang"], "unknown measure 'strang'; did you mean strong?"),
        (["strong[a=1]"], "measure 'strong' takes no parameters"),
        (
            ["strong", SimpleNamespace(name="strong", a=1)],
            "two different measures are labelled 'strong'; select one of them",
        ),
    ],
)
def test_refused_measures(registry: Registry, wanted: Any, message: str) -> None:
    """A selection that means nothing is one line."""
    with pytest.raises(UsageError) as caught:
        select_measures(registry, wanted)

    assert str(caught.value) == message


def test_everything_of_an_empty_registry_is_nothing() -> None:
    """Asking for everything is no mistake where there is nothing."""
    assert select_schemes(Registry({})) == []


@pytest.mark.parametrize(
    ("author", "crossed"),
    [
        (Origin("shipped", "sdaeverify", "1", "shipped"), False),
        (ORIGIN, False),
        (Origin("others", "others", "1", "others"), True),
        (Origin("mine", "", "", "/mine.py"), True),
    ],
)
def test_a_list_of_schemes_binds_those_that_its_author_could_name(
    registry: Registry, author: Origin, crossed: bool
) -> None:
    """Schemes of the framework and of the problem's distribution are bound by the list, those of others are not."""

    def limited(c_g: float = 1.0) -> SDE:
        return pendulum(c_g)

    problem = in_matrix({"c_g": 2.0}, schemes=("half-other",))(limited)
    problems = {"limited": Registered("limited", (problem,), ORIGIN)}
    schemes = {"euler": Registered("euler", (Euler(),), author)}

    (spec,) = select_problems(Registry({PROBLEMS: problems, SCHEMES: schemes}))

    assert spec.select([Euler(), HalfOther()], [])[0] == ((Euler(),) if crossed else ()) + (HalfOther(),)
