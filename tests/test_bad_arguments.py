"""Whatever is wrong with an argument of the Python interface, it is one error with a message for its user."""

from collections.abc import Callable

import pytest

from facade import load_plugins, load_registry
from sdaeverify import UsageError, api, verify
from sdaeverify.testing import check_problem, check_scheme, parametrize_with_checks, parametrize_with_claims

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
