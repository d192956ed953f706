"""Names and reasons of plugins that are meant to do harm: shown in every output, in letters."""

import csv
import io
import json
from pathlib import Path

import pytest

NASTY = "=HYPERLINK('http://example')\\x1b[2J\\n::error::x|<b>\\u202e\\x9b"
PLUGIN = f'''
def zz_odd(label: str = "{NASTY}") -> SDE:
    """A problem {NASTY}."""
    return SDE(
        drift=lambda t, x: -x,
        diffusion=lambda t, x: 0.1 + 0 * x[:, None],
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        observables={{"{NASTY}": lambda t, parts: parts["x"][0]}},
        source="{NASTY}",
    )


@dataclass(frozen=True)
class Odd(Scheme):
    """A scheme {NASTY}."""

    name: ClassVar[str] = "odd"
    form: ClassVar[type] = SDE
    source: ClassVar[str] = "{NASTY}"
    claims: ClassVar[tuple] = (
        Claim(measure="weak", value=1.0, source="{NASTY}", quantities=("{NASTY}",)),
        Claim(measure="strong", value="{NASTY}", source="{NASTY}"),
    )
    mode: str = "{NASTY}"

    def step(self, problem, state, t, h, noise):
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


class Raising(Odd):
    """One that raises."""

    name: ClassVar[str] = "raising"

    def step(self, problem, state, t, h, noise):
        raise RuntimeError("{NASTY}")


@hookimpl
def sdaeverify_problems():
    return [zz_odd]


@hookimpl
def sdaeverify_schemes():
    variants = [Odd(), Odd("{NASTY} of another kind"), Raising()]
    return variants
'''


@pytest.fixture
def plugin(write):
    """Write the plugin."""
    return write(PLUGIN)


def assert_printable(text):
    """Check that every line of a text is made of letters that can be seen."""
    assert text
    assert all(line.isprintable() for line in text.split("\n"))


def test_a_run(call, plugin):
    """Neither the terminal, nor the tables, nor the records are steered; the texts are all there, escaped."""
    budget = ("--paths", "40", "--levels", "8..32", "-j", "1", "--progress", "plain")
    outcome = call("matrix", "-s", "odd,raising", "-p", "zz-odd", "-m", "weak,strong", "--plugin", plugin, *budget)

    assert outcome.code == 3
    assert_printable(outcome.out)
    assert_printable(outcome.err)
    # What a log of GitHub would take for a command.
    assert not any(line.startswith("::") for line in (outcome.out + outcome.err).split("\n"))
    folder = Path("reports", "latest")
    for table in ("verdicts.csv", "levels.csv", "details/strong.csv"):
        rows = list(csv.reader(io.StringIO((folder / table).read_text(encoding="utf-8"), newline="")))
        assert len(rows) > 3
        for cell in (cell for row in rows for cell in row):
            assert cell.isprintable()
            assert not cell.startswith(("=", "@"))
    text = (folder / "run.json").read_text(encoding="utf-8")
    assert text.isascii()
    assert json.loads(text)
    assert "HYPERLINK" in outcome.out


@pytest.mark.parametrize(
    "words",
    [
        ("list",),
        ("list", "schemes", "--json"),
        ("info", "odd"),
        ("info", "zz-odd"),
        ("matrix", "-s", "odd", "-p", "zz-odd", "--dry-run", "-j", "1"),
        ("reproduce", "--list"),
    ],
    ids=" ".join,
)
def test_what_is_shown(call, plugin, words):
    """Listings and descriptions are lines of printable letters."""
    outcome = call(*words, "--plugin", plugin)

    assert outcome.code == 0
    assert_printable(outcome.out)
    assert outcome.err == ""
