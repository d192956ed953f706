"""Whatever is wrong with an argument of the Python interface, it is one error with a message for its user."""

from collections.abc import Callable

import pytest

from facade import load_plugins, load_registry
from sdaeverify import Claim, Scheme, SdaeverifyError, Settings, UsageError, api, load, sample, verify
from sdaeverify.testing import check_problem, check_scheme, parametrize_with_checks, parametrize_with_claims
from sdaeverify_hunt import hunt
from sdaeverify_orders import orders

ODD = [3, 1.5, object(), b"gbm", [None], [["gbm"]], {3: 1}, {3}, "no such", float("nan"), int, [int], [object()]]
SMALL = {"paths": 40, "levels": 3}
NUMBERS = (
    "paths",
    "coarsest",
    "levels",
    "first_levels",
    "seed",
    "confidence",
    "block",
    "max_looks",
    "tests_reserved",
    "jobs",
)
NO_NUMBERS = [None, "8", b"8", [8], {8}, 1.5j, object(), int, True, -1, float("nan"), "x" * 5000]
CALLS: dict[str, Callable[[object], object]] = {
    "schemes": lambda odd: verify(odd, "gbm", "strong", **SMALL),
    "problems": lambda odd: verify("milstein", odd, "strong", **SMALL),
    "measures": lambda odd: verify("milstein", "gbm", odd, **SMALL),
    "plugins": lambda odd: verify("milstein", "gbm", "strong", plugins=odd, **SMALL),
    "check_scheme": lambda odd: check_scheme(odd, "gbm"),
    "problems of check_scheme": lambda odd: check_scheme("milstein", odd),
    "level": lambda odd: check_scheme("milstein", "gbm", level=odd if odd != 1 else 0),
    "expected_failures": lambda odd: check_scheme("milstein", "gbm", expected_failures=odd),
    "check_problem": check_problem,
    "subjects": lambda odd: parametrize_with_checks(odd, problems=["gbm"]),
    "schemes of claims": lambda odd: parametrize_with_claims(odd, problems=["gbm"]),
    "problems of claims": lambda odd: parametrize_with_claims(["milstein"], problems=odd),
    "measures of claims": lambda odd: parametrize_with_claims(["milstein"], problems=["gbm"], measures=odd),
    "tier": lambda odd: parametrize_with_claims(["milstein"], problems=["gbm"], tier=odd),
    "expected failures of claims": lambda odd: parametrize_with_claims(
        ["milstein"], problems=["gbm"], expected_failures=odd
    ),
}


@pytest.fixture(autouse=True)
def loaded_once(monkeypatch):
    """Load the installed plugins once; files always anew."""
    monkeypatch.setattr(api, "load_registry", lambda paths: load_registry(paths) if paths else load_plugins())


def told(call: Callable[[object], object], odd: object) -> str:
    """Return what is wrong with the answer to a bad argument; empty if it is an error in one line."""
    try:
        call(odd)
    except (UsageError, ImportError) as error:
        return "" if "\n" not in str(error) else f"{odd!r:.60}: several lines"
    except BaseException as error:
        return f"{odd!r:.60} raises {type(error).__name__}: {error}"
    return f"{odd!r:.60} is taken"


@pytest.mark.parametrize("argument", CALLS)
def test_arguments(argument):
    """An argument that is not of its kind is refused, in one line, by what is called."""
    assert not [text for odd in ODD if (text := told(CALLS[argument], odd))]


@pytest.mark.parametrize("argument", NUMBERS)
def test_numbers(argument):
    """A number that is none, or out of its range, is refused before anything is run."""

    def call(odd):
        return verify("milstein", "gbm", "strong", **(SMALL | {argument: odd}))

    assert not [text for odd in NO_NUMBERS if (text := told(call, odd))]


def test_an_unknown_argument():
    """A keyword that is none is told with those that are."""
    with pytest.raises(UsageError, match="unknown setting path; known are paths, coarsest"):
        verify("milstein", "gbm", "strong", path=40)


def test_a_folder_that_cannot_be(tmp_path):
    """A result cannot be saved where no folder can be."""
    result = verify("milstein", "gbm", "strong", **SMALL)

    (tmp_path / "loop").symlink_to("loop")
    for folder in ("x" * 5000, "a\0b", tmp_path / "loop"):
        with pytest.raises(UsageError, match="cannot write into"):
            result.save(folder)


STRONG = {"measure": "strong", "source": "a test"}
MISTAKES: dict[str, tuple[Callable[[object], object], str]] = {
    "no such scheme": (lambda _: sample("no", "gbm"), "unknown scheme 'no'"),
    "a problem for a scheme": (lambda _: sample("gbm", "gbm"), "expected a scheme, 'gbm' is a problem"),
    "a scheme for a problem": (lambda _: sample("heun", "heun"), "expected a problem, 'heun' is a scheme"),
    "two schemes": (lambda _: sample("milstein,heun", "gbm"), "expected the label of one scheme"),
    "a class": (lambda _: sample(Scheme, "gbm"), "write Scheme\\(\\)"),
    "no problem": (lambda _: sample("milstein", None), "expected"),
    "steps": (lambda _: sample("milstein", "gbm", steps=10), "steps must be 8 times a power of 2, got 10"),
    "half a step": (lambda _: sample("milstein", "gbm", steps=8.5), "steps must be a whole number"),
    "no paths": (lambda _: sample("milstein", "gbm", paths=0), "paths must be from 1 to 256, got 0"),
    "seed": (lambda _: sample("milstein", "gbm", seed=-1), "seed must be between 0 and"),
    "form": (lambda _: sample("half-explicit-euler", "gbm"), "needs a HolonomicSDAE; this problem is an SDE"),
    "component": (lambda _: few()["y"], "no component 'y'; there are x"),
    "component number": (lambda _: few()[0], "no component 0; there are x"),
    "index": (lambda _: few().plot("x", 3), "index must be from 0 to 0 for x, got 3"),
    "index in words": (lambda _: few().plot("x", "first"), "index must be a whole number, got 'first'"),
    "axes of paths": (lambda _: few().plot("x", ax=3), "ax expects the axes of a matplotlib figure, got 3"),
    "cell": (lambda made: made.cell("heun", "gbm"), "no cell of 'heun' on 'gbm'"),
    "details": (lambda made: made.details("weak"), "no rows of measure 'weak'"),
    "details of many": (lambda made: made.details(["strong"]), "no rows of measure"),
    "command": (lambda made: made.command("heun", "gbm", "strong"), "no cell of 'heun' on 'gbm', 'strong'"),
    "save nowhere": (lambda made: made.save(None), "save expects a folder, got None"),
    "save here": (lambda made: made.save(""), "save expects a folder, got ''"),
    "load bytes": (lambda _: load(b"run"), "load expects a folder, got b'run'"),
    "load what is no name": (lambda _: load("a\0b"), "holds no run: cannot read verdicts.csv"),
    "choose a problem": (lambda made: made.choose("ou"), "no strong error is known on ou"),
    "choose a measure": (lambda made: made.choose("gbm", "drift"), "no drift error is known on gbm"),
    "choose in words": (lambda made: made.choose("gbm", accuracy="small"), "accuracy must be a number, got 'small'"),
    "choose nothing": (lambda made: made.choose("gbm", accuracy=0.0), "accuracy expects a positive error, got 0"),
    "picture of a scheme": (lambda made: made.plot.convergence("heun"), "the result has no scheme 'heun'"),
    "picture of a measure": (lambda made: made.plot.matrix("drift"), "the result has no measure 'drift'"),
    "picture of no density": (lambda made: made.plot.density(), "no density of coordinate 1 is known"),
    "axes of work": (
        lambda made: made.plot.work(ax="here"),
        "ax expects the axes of a matplotlib figure",
    ),
    "orders of none": (lambda _: orders("milstien"), "did you mean milstein"),
    "orders of all": (lambda _: orders(None), "orders expects one scheme, got None"),
    "class": (lambda _: orders("milstein", classes="zz"), "unknown class 'zz' \\(known: ode"),
    "motions": (lambda _: orders("milstein", motions=0), "motions must be from 1 to 4, got 0"),
    "motions in words": (lambda _: orders("milstein", motions="3"), "motions must be a whole number, got '3'"),
    "weight": (lambda _: orders("milstein", weight=-1), "weight must be from 1 to 8, got -1"),
    "hunt for nobody": (lambda _: hunt(None), "hunt expects the schemes that are hunted"),
    "hunt with a word": (
        lambda _: hunt("milstein", forms="SDE"),
        "forms expects a list of names, such as \\['SDE'\\]",
    ),
    "hunt with a seed": (lambda _: hunt("milstein", seed="a"), "seed must be a whole number, got 'a'"),
    "hunt for long": (lambda _: hunt("milstein", minutes=-1), "minutes must be positive, got -1"),
    "an empty list": (lambda _: verify([], "gbm", **SMALL), "an empty list of schemes; leave schemes out"),
    "out of nothing": (lambda _: verify("milstein", "gbm", out="", **SMALL), "out expects a folder, got ''"),
    "executor": (lambda _: verify("milstein", "gbm", executor="zz", **SMALL), "unknown executor 'zz'"),
    "order in words": (lambda _: Claim(value="0.5", **STRONG), "a claimed order is a number, not a text; got '0.5'"),
    "order of nothing": (lambda _: Claim(value=0, **STRONG), "must be finite and larger than its margin"),
    "one quantity": (lambda _: Claim(value=1.0, quantities="x", **STRONG), "expects a tuple of texts"),
    "margin": (lambda _: Claim(value=1.0, margin=2.0, **STRONG), "must be finite and larger than its margin"),
    "settings": (lambda _: Settings(paths=-1), "paths must be at least 40, got -1"),
}


def few():
    """Return a few paths."""
    return sample("milstein", "gbm", steps=8, paths=3)


@pytest.fixture(scope="module")
def made():
    """Return a small result."""
    return verify("milstein", "gbm", "strong", **SMALL)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes(mistake, made):
    """A wrong name, number, folder or shape is one line that says what was expected."""
    if "picture" in mistake or "ax" in mistake:
        pytest.importorskip("matplotlib", reason="needs the extra plot").use("agg")
    call, message = MISTAKES[mistake]

    with pytest.raises(SdaeverifyError, match=message) as raised:
        call(made)

    assert len(str(raised.value).splitlines()) == 1
