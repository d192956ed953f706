"""Programs as sealed solvers: one call a run, words on the command line, numbers on stdout."""

import pickle
import time

import numpy as np
import pytest

from sdaeverify import Claim, SchemeError, UsageError
from sdaeverify_sealed import program
from sdaeverify_sealed.sample import Budget
from sealed.programs_of import in_c, in_python, in_r
from sealed.solving import rows, spec, verdicts

CLAIMS = (
    Claim(measure="invariant", value=1.0, margin=0.45, quantities=("x^2",), source="Talay & Tubaro 1990"),
    Claim(measure="weak", value=1.0, margin=0.45, quantities=("x",), source="Kloeden & Platen 1992, section 14.1"),
)
# Of programs that are silent on purpose; others are given more, on a machine that is busy with other tests.
SHORT, PATIENCE = 1.0, 120.0


@pytest.mark.long
def test_a_program_in_c_is_verified(tmp_path):
    """Euler's scheme in C with its own random numbers keeps the claims of Euler's scheme."""
    made = program("c-euler", in_c(tmp_path), ["ou"], CLAIMS, steps=(2, 4, 8))
    found = verdicts([made], "ou", Budget(paths=2**18))

    assert found["c-euler", "weak", "x"] == "verified"
    assert found["c-euler", "invariant", "x^2"] == "verified"
    assert found["c-euler", "own seeds", ""] == found["c-euler", "same seed", ""] == "verified"
    assert "refuted" not in found.values()


@pytest.mark.slow
@pytest.mark.long
def test_a_program_in_r_is_verified(tmp_path):
    """The same in R, without packages, on fewer paths: no claim is refuted, and the larger errors are verified."""
    claims = (Claim(measure="weak", value="unbiased", bound=0.1, quantities=("x",), source="made up"),)
    found = verdicts([program("r-euler", in_r(tmp_path), ["ou"], claims)], "ou", Budget(paths=2**13, looks=1))

    assert found["r-euler", "weak", "x"] == "verified"
    assert found["r-euler", "own seeds", ""] == found["r-euler", "same seed", ""] == "verified"


def test_a_program_is_sent_to_a_worker(tmp_path):
    """It is made again from its name, command and claims."""
    made = program(
        "sent", in_python(tmp_path, "write(*[0.5] * paths)"), ["ou"], CLAIMS, patience=5.0, steps=(2, 4, 8)
    )
    again = pickle.loads(pickle.dumps(made))

    assert (again.name, again.command, again.promises, again.patience) == ("sent", made.command, CLAIMS, 5.0)
    assert again.steps == (2, 4, 8)
    assert np.array_equal(again.run(spec("ou").build(), 0.5, 1.0, 3, 1), [[0.5, 0.5, 0.5]])


def test_a_program_solves_the_problems_it_names(tmp_path):
    """On another problem it is left out, with a line."""
    made = program("one", in_python(tmp_path, "write(*[0.5] * paths)"), ["gbm"], CLAIMS)

    assert rows([made], "ou", Budget(paths=2**13, looks=1)) == ([], ["one on ou: one solves gbm alone"])


def test_what_cannot_be_started_is_refused():
    """A command that is none is refused when it is registered."""
    with pytest.raises(UsageError, match="no program 'nowhere-at-all'"):
        program("none", "nowhere-at-all", ["ou"])


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("write(*[0.5] * (paths - 1))", "wrote 16 bytes, expected 24: 1 x 3 numbers"),
        ("write(*[0.5] * (paths + 1))", "wrote 32 bytes, expected 24"),
        ("print('hello')", "wrote 6 bytes"),
        ("sys.exit('no such file')", "ended with exit code 1; its stderr ends: no such file"),
        ("os.kill(os.getpid(), 9)", "ended with signal 9"),
        ("time.sleep(600)", "has not ended after 1 s (patience)"),
        ("write(*[0.5] * paths); time.sleep(600)", "has not ended after 1 s (patience)"),
    ],
)
def test_what_is_no_answer_is_one_line(tmp_path, body, told):
    """A wrong size, an exit code, a signal and silence are told with the command, and nothing hangs."""
    patience = SHORT if "patience" in told else PATIENCE
    made = program("wrong", in_python(tmp_path, body), ["ou"], CLAIMS, patience=patience)
    begun = time.monotonic()

    with pytest.raises(SchemeError, match=r"h=0\.5 T=1\.0 paths=3 seed=7") as raised:
        made.run(spec("ou").build(), 0.5, 1.0, 3, 7)
    assert told in str(raised.value)
    assert len(str(raised.value).splitlines()) == 1
    assert time.monotonic() - begun < PATIENCE
