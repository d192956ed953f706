"""Labels: canonical text, parsing, and conversion of values."""

from dataclasses import dataclass, field

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from facade import (
    REQUIRED,
    Label,
    Parameter,
    dataclass_parameters,
    did_you_mean,
    make_label,
    matches,
    parse_label,
    read_values,
    split_list,
)
from sdaeverify import ParameterError, UsageError

PARAMETERS = (
    Parameter("count", 3),
    Parameter("size", 0.5),
    Parameter("implicit", False),
    Parameter("truncation", "theory"),
    Parameter("root", "hold", text_only=True),
)
VALUES = st.fixed_dictionaries(
    {},
    optional={
        "count": st.integers(),
        "size": st.floats(allow_nan=False, allow_infinity=False),
        "implicit": st.booleans(),
        "truncation": st.text() | st.floats(allow_nan=False),
        "root": st.text(),
    },
)


def read(**texts: str) -> dict[str, object]:
    return dict(read_values("scheme 'x'", PARAMETERS, texts))


@given(VALUES)
@example({"truncation": "1.5", "root": "1.5"})
@example({"truncation": "nan", "root": 'a "quoted, [text]\\'})
@example({"truncation": "", "root": "true", "size": 1e308})
def test_round_trip(values: dict[str, object]) -> None:
    """A label gives back every value that differs from its default."""
    label = make_label("x", PARAMETERS, values)

    parsed = parse_label(label)

    assert parsed.name == "x"
    defaults = {p.name: p.default for p in PARAMETERS}
    assert defaults | read(**(parsed.parameters or {})) == defaults | values


@given(st.lists(VALUES, min_size=1))
def test_list_of_labels_splits_into_its_labels(lists: list[dict[str, object]]) -> None:
    """Commas inside brackets and quotes separate no labels."""
    labels = [make_label("x", PARAMETERS, values) for values in lists]

    assert split_list(",".join(labels)) == labels


@pytest.mark.parametrize(
    ("values", "label"),
    [
        ({}, "x"),
        ({"count": 3, "size": 0.5, "implicit": False, "truncation": "theory"}, "x"),
        ({"truncation": "none", "count": 4}, "x[count=4,truncation=none]"),
        ({"size": 2}, "x[size=2]"),
        ({"size": 2.0, "truncation": 2}, "x[size=2,truncation=2]"),
        ({"size": 1e-7}, "x[size=1e-07]"),
        ({"implicit": True}, "x[implicit=true]"),
        ({"root": "2"}, 'x[root="2"]'),
        ({"root": "a b"}, 'x[root="a b"]'),
    ],
)
def test_canonical_label(values: dict[str, object], label: str) -> None:
    """Defaults are dropped, the order is that of declaration, whole floats lose their fraction."""
    assert make_label("x", PARAMETERS, values) == label


def test_value_that_cannot_be_written() -> None:
    """A value of another type has no label."""
    with pytest.raises(ParameterError, match="parameter count has a value of type tuple, expected bool"):
        make_label("x", PARAMETERS, {"count": (1, 2)})


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("x", Label("x", None)),
        ("half-*", Label("half-*", None)),
        ("x[]", Label("x", {})),
        (" x [ a = 1 , b=none ] ", Label("x", {"a": "1", "b": "none"})),
        ('x[a="b,[c]=\\"d"]', Label("x", {"a": '"b,[c]=\\"d"'})),
    ],
)
def test_parse(text: str, label: Label) -> None:
    """Brackets hold parameters, spaces around the parts do not matter, quotes protect."""
    assert parse_label(text) == label


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "[a=1]",
        "x[a=1",
        "x]",
        "x[a]",
        "x[a=]",
        "x[=1]",
        "x[a=1]y",
        "x[a=1][b=2]",
        "x[a=b=c]",
        "x y",
        'x[a="b]',
    ],
)
def test_bad_syntax(text: str) -> None:
    """What is no label is refused in one line that shows the syntax."""
    with pytest.raises(UsageError, match=r"^cannot read .*: expected name\[key=value,\.\.\.\]$"):
        parse_label(text)


def test_parameter_given_twice() -> None:
    """A parameter has one value."""
    with pytest.raises(UsageError, match="parameter 'a' is given twice"):
        parse_label("x[a=1,a=2]")


def test_split_list_drops_empty_items() -> None:
    """Superfluous commas and spaces do not matter."""
    assert split_list(" a,, b[c=1,d=2] ,e,") == ["a", "b[c=1,d=2]", "e"]


@pytest.mark.parametrize(
    ("parameter", "text", "value"),
    [
        ("count", "-2", -2),
        ("size", "2", 2.0),
        ("size", "1e-3", 1e-3),
        ("implicit", "TRUE", True),
        ("truncation", "none", "none"),
        ("truncation", "1", 1.0),
        ("truncation", '"1"', "1"),
        ("root", "1", "1"),
    ],
)
def test_conversion(parameter: str, text: str, value: object) -> None:
    """The type of the default says how text is read; text may also be a number unless annotated str."""
    result = read(**{parameter: text})[parameter]

    assert result == value
    assert type(result) is type(value)


@pytest.mark.parametrize(
    ("parameter", "text", "expected"),
    [
        ("count", "2.5", "a whole number"),
        ("count", "1_0", "a whole number"),
        ("size", "large", "a number"),
        ("size", '"1"', "a number"),
        ("implicit", "1", "true or false"),
        ("root", r'"\x"', "a word or a number"),
    ],
)
def test_text_of_the_wrong_type(parameter: str, text: str, expected: str) -> None:
    """The message names the parameter, whose it is, what is expected and what was given."""
    with pytest.raises(ParameterError) as caught:
        read(**{parameter: text})

    assert str(caught.value) == f"parameter {parameter} of scheme 'x' expects {expected}, got {text!r}"


def test_unknown_parameter() -> None:
    """The message lists what is close and what there is."""
    with pytest.raises(ParameterError) as caught:
        read(truncaton="none")

    assert str(caught.value) == (
        "scheme 'x' has no parameter 'truncaton'; did you mean truncation? "
        "(known: count, size, implicit, truncation, root)"
    )


def test_parameters_of_a_dataclass() -> None:
    """Fields of the constructor are parameters, with their defaults and whether they are plain text."""

    @dataclass(frozen=True)
    class Example:
        a: float
        b: str = "x"
        c: str | float = "y"
        d: int = field(default_factory=lambda: 2)
        e: int = field(default=1, init=False)

    assert dataclass_parameters(Example) == (
        Parameter("a", REQUIRED),
        Parameter("b", "x", text_only=True),
        Parameter("c", "y"),
        Parameter("d", 2),
    )


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("half-explict-euler", "; did you mean half-explicit-euler?"),
        ("half", "; did you mean half-explicit-euler?"),
        ("MILSTEIN", "; did you mean milstein?"),
        ("xyz", ""),
        ("", ""),
    ],
)
def test_did_you_mean(word: str, hint: str) -> None:
    """Close words are found by spelling, or else by being contained."""
    assert did_you_mean(word, ["milstein", "half-explicit-euler"]) == hint


def means(glob: str, label: str) -> bool:
    """Match letter by letter: what `matches` is to do."""
    if not glob:
        return not label
    if glob[0] == "*":
        return any(means(glob[1:], label[skipped:]) for skipped in range(len(label) + 1))
    return label != "" and glob[0] in ("?", label[0]) and means(glob[1:], label[1:])


@given(st.text("aA[]!*?.\n", max_size=5), st.text("aA[]!.\n", max_size=5))
@example("x[a=?]", "x[a=1]")
@example("x[a=1]", "xa")
@example("[!a]", "A")
@example("a", "A")
@example("a*", "[a]")
@example("*a", "a\n")
def test_globs_of_labels(glob: str, label: str) -> None:
    """Wildcards mean any letters or one letter; all else stands for itself, and whole labels are meant."""
    assert matches(glob, label) is means(glob, label)
