"""The golden transcript: its bytes, and the clients that answer as it does."""

import numpy as np
import pytest

from facade import gbm
from sdaeverify import SchemeError
from sdaeverify_wire.calling import Calling
from sdaeverify_wire.check import checked
from sdaeverify_wire.command import CLIENTS as FILES
from sdaeverify_wire.program import Program
from sdaeverify_wire.scheme import scheme_of, session_of
from sdaeverify_wire.transcript import GOLDEN, golden_conversation, read, replay, written
from wire.compiling import CLIENTS, LANGUAGES, built_c, with_octave, with_python, with_r

ONE = b"\x00\x00\x00\x00\x00\x00\xf0\x3f"
# Hello, and the step of one path: t = 1/2, h = 1/4, x = dW = -3/4; f = 3/8, B = -5/8, x + h f + B dW = -3/16.
HALF, QUARTER, X = b"\x00" * 6 + b"\xe0\x3f", b"\x00" * 6 + b"\xd0\x3f", b"\x00" * 6 + b"\xe8\xbf"
FIRST = [
    b"hello version=1\n" + ONE,
    b"name golden-euler\nform SDE\nnoise dW\nasks drift diffusion\nhello version=1\n" + ONE,
    b"step t=1 h=1 x=1x1 dW=1x1\n" + HALF + QUARTER + X + X,
    b"ask drift t=1 x=1x1\n" + HALF + X,
    b"give drift=1x1\n" + b"\x00" * 6 + b"\xd8\x3f",
    b"ask diffusion t=1 x=1x1\n" + HALF + X,
    b"give diffusion=1x1x1\n" + b"\x00" * 6 + b"\xe4\xbf",
    b"done x=1x1\n" + b"\x00" * 6 + b"\xc8\xbf",
]


def test_first_messages_of_the_transcript():
    """Its bytes are those of the protocol, whatever makes messages today."""
    messages = read(GOLDEN.read_bytes())

    assert [message.content for message in messages[: len(FIRST)]] == FIRST
    assert [message.sent for message in messages[: len(FIRST)]] == [True, False] * 4


def test_transcript_is_what_this_version_says():
    """The messages that are made today are the bytes of the file: another protocol needs another version."""
    assert GOLDEN.read_bytes() == written(golden_conversation())


@pytest.mark.parametrize("language", LANGUAGES)
def test_client_answers_as_the_transcript(language, tmp_path):
    """A client of each language passes all that is checked, the golden transcript first."""
    lines = list(checked(Calling.of(LANGUAGES[language](tmp_path), 20.0), golden=True))

    assert lines[0] == "transcript: 10 answers are those of the golden transcript"
    assert lines[-1] == "steps: equal with 1, 3, 5000 paths"


def test_other_answers_are_told_by_their_place(tmp_path):
    """A scheme whose drift counts twice differs in the first state."""
    program = Program(built_c(tmp_path, "golden_euler", "-DWRONG"), 10.0)

    with pytest.raises(SchemeError, match=r"differs from message 8 of the transcript at byte 17: "):
        replay(program, read(GOLDEN.read_bytes()))


def test_each_client_is_a_file():
    """The command gives each client that is there; that of Julia says that nobody has run it."""
    assert {path.name for path in CLIENTS.iterdir() if path.is_file()} == set(FILES.values())
    assert "UNTESTED" in (CLIENTS / FILES["julia"]).read_text()


@pytest.mark.parametrize("language", [with_python, with_octave, with_r], ids=["Python", "Octave", "R"])
def test_client_keeps_a_memory(language, tmp_path):
    """The memory that a state is entered with comes back with each step, and is no component of the solution."""
    scheme, problem, h = scheme_of(language(tmp_path, "remembers"), 20.0), gbm(), 0.25
    state = scheme.start(problem, 5, h)
    for step in range(3):
        np.testing.assert_array_equal(state.memory, np.full((1, 5), step * h))
        noise = problem.drawn(np.random.default_rng(1), h, 5)
        state = scheme.step(problem, state, step * h, h, noise).state
    session_of(scheme.calling).drop()

    assert list(scheme.parts(problem, state)) == ["x"]
    np.testing.assert_array_equal(state.x, problem.initial(5))
