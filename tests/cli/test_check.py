"""The command ``check``."""

import json

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
    assert outcome.out.strip() == "19 answers: 19 passed, none failed, none skipped"


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


def test_one_fault_is_told_once(call, write):
    """A step that raises fails many checks: one line with their number, and a row for each for programs."""
    plugin = write(HOSTILE)
    outcome = call("check", "hostile", "-p", "ou,gbm", "--plugin", plugin)
    rows = json.loads(call("check", "hostile", "-p", "ou,gbm", "--plugin", plugin, "--json").out)

    raised = sum(row["reason"].startswith("raises ValueError") for row in rows)
    assert raised > 10
    assert outcome.out.count("  raises ValueError") == 1
    assert f"inputs-untouched and {raised - 1} more" in outcome.out


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
