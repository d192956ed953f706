"""What a program says of itself, and what the lines of messages say."""

import pickle
import sys

import numpy as np
import pytest

from facade import gbm, pendulum
from sdaeverify import GAUSSIAN, SDE, THREE_POINT, Claim, SchemeError
from sdaeverify_wire.calling import Calling
from sdaeverify_wire.coefficients import FORMS, Coefficients
from sdaeverify_wire.hello import Hello, read_hello
from sdaeverify_wire.messages import Line, encode, read_line
from sdaeverify_wire.scheme import restored

LINES = [
    "name my-scheme",
    "form SDE Langevin",
    "noise dW H",
    "asks drift force",
    "needs scalar-noise diagonal-noise",
    "needs unconstrained",
    "gives x",
    "claim strong 1.0 when additive-noise,no-delay source a paper, section 2",
    "claim drift round-off of g source measured",
    "source a paper",
    "about A scheme.",
]


def test_lines_of_a_hello():
    """Each line is read, and what may stand twice is collected."""
    found = read_hello(LINES)

    assert found[:3] == ("my-scheme", ("SDE", "Langevin"), frozenset({"dW", "H"}))
    assert found.needs == (frozenset({"scalar-noise", "diagonal-noise"}), frozenset({"unconstrained"}))
    assert found.claims == (
        Claim(
            measure="strong",
            value=1.0,
            when=frozenset({"additive-noise", "no-delay"}),
            source="a paper, section 2",
        ),
        Claim(measure="drift", value="round-off", quantities=("g",), source="measured"),
    )


def test_scheme_is_what_the_hello_says():
    """Name, forms, noise and claims are the program's; a worker makes the same class of it without starting it."""
    scheme = restored(Calling(("/no/such/program",), 1.0, ""), read_hello(LINES))

    assert scheme.label == "my-scheme"
    assert scheme.forms[0] is SDE
    assert len(scheme.promises) == 2
    assert type(pickle.loads(pickle.dumps(scheme))) is type(scheme)


def test_law_and_flags_are_those_of_the_scheme():
    """What the hello says of the noise and of single steps is what the framework asks of the class."""
    lines = ["name a", "form SDE", "law three-point", "is discontinuous-in-noise corrected-later"]
    said, plain = (restored(Calling(("p",), 1.0, ""), read_hello(each)) for each in (lines, lines[:2]))

    assert (said.law, said.discontinuous_in_noise, said.local_order_is_global) == (THREE_POINT, True, False)
    assert (plain.law, plain.discontinuous_in_noise, plain.local_order_is_global) == (GAUSSIAN, False, True)


def test_problems_it_cannot_have_are_refused():
    """A problem needs a trait of each line, and all that the program asks for."""
    lines = {
        "needs algebraic additive-noise": "it needs a problem with additive-noise or algebraic",
        "needs scalar-noise diagonal-noise": "",
    }
    for line, why in lines.items():
        assert restored(Calling(("p",), 1.0, ""), read_hello(["name a", "form SDE", line])).refuses(gbm()) == why
    scheme = restored(Calling(("p",), 1.0, ""), read_hello(["name a", "form HolonomicSDAE", "most n=1 m=3"]))
    assert scheme.refuses(pendulum()) == "it is for n = 1 at most, and the problem has n = 2"
    scheme = restored(Calling(("p",), 1.0, ""), read_hello(["name a", "form SDE", "asks constraint"]))
    assert scheme.refuses(gbm()) == "it asks constraint, which the problem does not have"


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("most m", "expected letters of shapes with numbers such as m=1"),
        ("most z=1", "said the length 'z', expected one of d, l, m"),
        ("memory 2z", "said the length 'z', expected one of d, l, m"),
        ("memory d+1", "expected a number of rows such as 3, d or 2d"),
        ("noise dW Z", "said 'noise Z' in its hello, expected some of dW, H, K, A"),
        ("law uniform", "said 'law uniform' in its hello, expected one of gaussian, three-point, two-point"),
        ("is exact", "said 'is exact' in its hello, expected one of discontinuous-in-noise, corrected-later"),
    ],
)
def test_wrong_lines_of_a_hello(line, told):
    """A size that is none, or a word that is not known, is one line with those that are."""
    with pytest.raises(SchemeError, match=told):
        read_hello(["name a", "form SDE", line])


def test_line_of_a_message():
    """A line is read as it was written."""
    arrays = {"t": np.zeros(1), "x": np.zeros((2, 3)), "B": np.zeros((2, 1, 3)), "y": np.zeros((0, 3))}
    text = encode("ask diffusion", arrays).partition(b"\n")[0].decode()

    shapes = {"t": (1,), "x": (2, 3), "B": (2, 1, 3), "y": (0, 3)}
    assert text == "ask diffusion t=1 x=2x3 B=2x1x3 y=0x3"
    assert read_line(text) == Line("ask", "diffusion", shapes)


@pytest.mark.parametrize("form", FORMS)
def test_what_may_be_asked_is_there(form):
    """Each coefficient of a form is a method of it, or a field of its problems."""
    kind, fields = FORMS[form].kind, {name for base in FORMS[form].kind.__mro__ for name in vars(base)}
    fields |= {*kind.__dataclass_fields__}
    assert {*FORMS[form].answers, *FORMS[form].constants} <= fields


def test_answers_have_all_paths():
    """What a problem gives once for all paths is sent for each of them, at any number of states."""
    known = Coefficients(pendulum(), ("HolonomicSDAE",), frozenset({"dg", "diffusion"}))
    r, v, _ = pendulum().initial(7)

    found = known.answer("diffusion", {"t": np.zeros(1), "r": r, "v": v})
    assert found.shape == (2, pendulum().noise_dim, 7)
    np.testing.assert_array_equal(known.answer("dg", {"r": r}), np.broadcast_to(pendulum().dg(r), (1, 2, 7)))


def test_kit_names_a_program_that_is_gone():
    """A program that was removed after it was registered is one line of the kit, as any fault."""
    scheme = restored(Calling((f"{sys.executable}-gone",), 1.0, ""), Hello("gone", ("SDE",)))

    with pytest.raises(SchemeError, match="cannot be started: No such file or directory"):
        scheme.step(gbm(), gbm().initial(2), 0.0, 0.5, gbm().drawn(np.random.default_rng(1), 0.5, 2))
