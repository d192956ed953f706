"""The command ``check``."""

import json

import pytest

CLAIMING = """
@dataclass(frozen=True)
class Claiming(Scheme):
    '''A scheme with a claim.'''
    name: ClassVar[str] = "claiming"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (
        Claim(measure="strong", value=0.5, source="a book"),
        Claim(source="a book", {claim}),
    )

    def step(self, problem, state, t, h, noise):
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))

@hookimpl
def sdaeverify_schemes():
    return [Claiming()]
"""

HOSTILE = """
@dataclass(frozen=True)
class Hostile(Scheme):
    '''A scheme whose source is bad, and whose step raises with control characters.'''
    name: ClassVar[str] = "hostile"
    form: ClassVar[type] = SDE

    def step(self, problem, state, t, h, noise):
        raise ValueError("\\x1b[31mred\\x1b[0m")

@hookimpl
def sdaeverify_schemes():
    return [Hostile()]
"""


def test_a_sound_scheme(call):
    """Nothing is told but how many checks passed."""
    outcome = call("check", "milstein", "-p", "gbm")

    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.strip() == "22 checks: 22 passed, none failed, none skipped"


@pytest.mark.long
def test_rows_for_programs(call):
    """With --json there is a row for each answer, of schemes and problems alike."""
    outcome = call("check", "euler-maruyama,tamed-*", "gbm-algebraic", "--problems", "ou", "--json")
    rows = json.loads(outcome.out)

    assert outcome.code == 0
    assert {row["subject"] for row in rows} == {"euler-maruyama", "tamed-euler", "gbm-algebraic"}
    assert {row["kind"] for row in rows} == {"scheme", "problem"}


def test_a_broken_scheme_from_a_file(call, write):
    """What fails is a row with its reason, control characters as escapes, and the exit code is 1."""
    outcome = call("check", "hostile", "-p", "ou", "--plugin", write(HOSTILE))

    assert outcome.code == 1
    assert "failed" in outcome.out
    assert "\\x1b[31mred" in outcome.out.replace("\n", "").replace(" ", "")
    assert "\x1b" not in outcome.out


def test_a_forgotten_step_is_told_first(call, write, monkeypatch):
    """A step that returns its state in place of Step(state) is told as that, before what it leads to."""
    monkeypatch.delenv("COLUMNS")
    plugin = write(HOSTILE.replace("raise ValueError(", "return state if h else str("))
    lines = call("check", "hostile", "-p", "ou", "--plugin", plugin).out.splitlines()

    of_steps = [line for line in lines if line.startswith("failed") and "  source  " not in line]
    assert "step returned ndarray, expected Step(state)" in of_steps[0]


def test_one_fault_is_told_once(call, write, monkeypatch):
    """A step that raises fails many checks: one line with their number, and a row for each for programs."""
    monkeypatch.delenv("COLUMNS")
    plugin = write(HOSTILE)
    outcome = call("check", "hostile", "-p", "ou,gbm", "--plugin", plugin)
    rows = json.loads(call("check", "hostile", "-p", "ou,gbm", "--plugin", plugin, "--json").out)

    raised = sum(row["reason"].startswith("raises ValueError") for row in rows)
    assert raised > 10
    assert outcome.out.count("  raises ValueError") == 1
    assert f"inputs-untouched and {raised - 1} more" in outcome.out


def test_a_narrow_terminal_breaks_no_word(call, write):
    """Rows that do not fit a table of 80 columns are sentences: subject, problem, checks and reason."""
    lines = call("check", "hostile", "-p", "ou", "--plugin", write(HOSTILE)).out.splitlines()

    assert max(map(len, lines)) <= 80
    assert any(line.startswith("failed hostile on ou, inputs-untouched and ") for line in lines)
    assert call("check", "ou").out.splitlines()[0].startswith("skipped ou, consistent-start: it has no constraint")


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("claim", "reason"),
    [
        (
            'value=0.5, measure="strong", quantities=("X",)',
            "its claim of strong order >= 0.5 is not tested: no result is about 'X'",
        ),
        (
            'value=0.5, measure="strong", when=frozenset({"delayed-noise", "no-delay"})',
            "its claim of strong order >= 0.5 applies to no registered problem with delayed-noise, no-delay",
        ),
        (
            'measure="weak", value="half"',
            "its claim of weak half is not tested: measure weak has no test for the claim 'half'",
        ),
    ],
)
def test_claims_that_nothing_tests(call, write, claim, reason):
    """A value that a measure cannot test, an unknown quantity, and traits that no problem has, are told."""
    plugin = write(CLAIMING.format(claim=claim))

    outcome = call("check", "claiming", "-p", "gbm", "--plugin", plugin, "--json")

    assert outcome.code == 1
    (failed,) = [row["reason"] for row in json.loads(outcome.out) if row["status"] == "failed"]
    assert failed.startswith(reason)


def test_an_empty_selection(call):
    """Names that are none are wrong usage, and not a check of nothing that passes."""
    outcome = call("check", "", ",")

    assert outcome.code == 2
    assert outcome.err == "sdaeverify: error: empty selection of schemes and problems: ' ,'\n"


def test_an_unknown_name(call):
    """A name that nothing has is an error of usage with what is close."""
    outcome = call("check", "milstien")

    assert outcome.code == 2
    assert outcome.err == "sdaeverify: error: no scheme or problem is named 'milstien'; did you mean milstein?\n"


def test_an_unknown_level(call):
    """A level that the kit has not is an error of usage."""
    outcome = call("check", "milstein", "--level", "9")

    assert outcome.code == 2
    assert "level must be a whole number from 1 to" in outcome.err
