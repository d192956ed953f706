"""The Python interface: tables of a study, and what they say of schemes nobody has registered."""

import re
from dataclasses import fields
from typing import ClassVar

import pytest

from facade import SettingsOptions, load_registry
from sdaeverify import SDE, Claim, Scheme, Settings, Step, UsageError, verify
from sdaeverify.errors import PluginError
from sdaeverify.numerics import apply

SMALL = {"paths": 200, "levels": 4}


class Mine(Scheme):
    """Euler-Maruyama with claims about things that are not there, and a count of its work."""

    name: ClassVar[str] = "mine"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, quantities=("y",), source="test"),
        Claim(measure="strong", value="converges", source="test"),
    )

    def step(self, problem, state, t, h, noise):
        new = state + h * problem.drift(t, state) + apply(problem.diffusion(t, state), noise.dW)
        return Step(new, costs={"work": 3.0 + 0.0 * new[0]})


@pytest.fixture(scope="module")
def result():
    """Return a small study of an unregistered scheme beside a registered one."""
    return verify([Mine(), "milstein"], "gbm", "strong", **SMALL)


def test_rows_nobody_can_name_have_no_command(result):
    """A row is reproduced by names; a scheme that is not registered has none."""
    assert result.command("mine", "gbm", "strong") == ""
    assert "-s milstein -p gbm -m strong" in result.command("milstein", "gbm", "strong")


def test_a_claimed_quantity_that_is_not_there_is_a_row(result):
    """A claim about a component that the problem does not have is shown as out of scope."""
    rows = result.verdicts.set_index(["scheme", "quantity"])

    assert rows.loc[("mine", "y"), "verdict"] == "out_of_scope"
    assert "The scheme has a claim about y; measured here: x" in rows.loc[("mine", "y"), "reason"]


class AtTheEnd(Mine):
    """Euler-Maruyama with a claim about the end alone."""

    name: ClassVar[str] = "at-the-end"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=0.5, quantities=("x@T",), source="test"),)


def test_a_claim_about_the_end_is_judged_there_and_listed_once():
    """The component at the end is there: it is judged, at no other time, and not told to be missing."""
    rows = verify(AtTheEnd(), "gbm", "strong", **SMALL).verdicts

    assert dict(zip(rows["quantity"], rows["claim"], strict=True)) == {"x": "", "x@T": "order >= 0.5"}
    assert len(rows) == 2


def test_a_claim_in_words_unknown_to_the_measure_is_inconclusive(result):
    """Words that a measure does not understand are neither verified nor refuted."""
    rows = result.verdicts.set_index(["scheme", "quantity"])

    assert rows.loc[("mine", "x"), "verdict"] == "inconclusive"
    assert "no test for the claimed value 'converges'" in rows.loc[("mine", "x"), "reason"]


def test_costs_are_columns_of_the_levels(result):
    """What a step takes is reported as its mean over steps and paths."""
    levels = result.levels.set_index("scheme")

    assert set(levels.loc["mine", "mean_work"]) == {3.0}


def test_run_says_what_was_selected(result):
    """The record of a run holds the labels of everything that took part, and when it was made, of which commit."""
    assert {"date", "commit", "schema_version"} <= {*result.run}
    assert result.run["selection"] == {"schemes": ["milstein", "mine"], "problems": ["gbm"], "measures": ["strong"]}


def test_what_cannot_be_sent_to_workers_is_said_in_one_line():
    """A scheme that other processes cannot find is refused before anything runs, with a way out."""

    class Local(Mine):
        name: ClassVar[str] = "local"

    with pytest.raises(UsageError, match="use one job") as error:
        verify([Local()], "gbm", "strong", jobs=2, **SMALL)

    assert "\n" not in str(error.value)


def test_claims_about_unknown_measures_break_a_plugin_file(tmp_path):
    """A misspelt measure in a claim is not silently never tested: the file is refused, the right name is none."""
    plugin = tmp_path / "typo.py"
    text = (
        "from typing import ClassVar\n"
        "from sdaeverify import SDE, Claim, Scheme, Step, hookimpl\n"
        "class Typo(Scheme):\n"
        "    name: ClassVar[str] = 'typo'\n"
        "    form: ClassVar[type] = SDE\n"
        "    claims: ClassVar = (Claim(measure='stronk', value=0.5, source='test'),)\n"
        "    def step(self, problem, state, t, h, noise): return Step(state)\n"
        "@hookimpl\n"
        "def sdaeverify_schemes(): return [Typo()]\n"
    )
    plugin.write_text(text)

    with pytest.raises(PluginError, match="'stronk', which is not registered; did you mean strong"):
        load_registry([plugin], environ={})

    plugin.write_text(text.replace("stronk", "strong"))
    assert load_registry([plugin], environ={}).warnings == ()


def test_every_setting_is_a_keyword():
    """What a run can be set to on the command line can be set from Python, too."""
    assert set(SettingsOptions.__annotations__) == {field.name for field in fields(Settings)}


def test_a_scheme_itself_and_steps_as_on_the_command_line():
    """One scheme needs no list, and step sizes may be written as a range."""
    result = verify(Mine(), "gbm", "strong", levels="16..64", paths=40)
    assert result.settings.steps == (16, 32, 64)
    assert set(result.verdicts.scheme) == {"mine"}


def test_a_result_is_short_at_a_prompt(result):
    """Its representation is the end of a run, and a cell tells all that was found."""
    assert repr(result).startswith("5 quantities: ")
    assert len(repr(result)) < 2000
    assert repr(result.cell("milstein", "gbm")).startswith("milstein on gbm\n")
    assert result._repr_html_().startswith("<p><b>5 quantities: ")


@pytest.mark.long
def test_a_folder_holds_evidence_tables_and_page(tmp_path, capsys):
    """What is in the folder is used again; progress is told if asked for."""
    for _ in range(2):
        verify("milstein", "gbm", "strong", out=tmp_path, progress="plain", **SMALL)
    assert {"evidence", "report.html", "verdicts.csv"} <= {path.name for path in tmp_path.iterdir()}
    assert "milstein  gbm  strong" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"levels": "16..48"}, "levels expects a number of levels or COARSEST..FINEST steps such as 8..256"),
        ({"levels": "16..64", "coarsest": 8}, "levels begin with 16 steps, but coarsest is 8"),
        ({"progress": "loud"}, "progress must be one of auto, plain, none, got 'loud'"),
        ({"out": 3}, "out expects a folder, got 3"),
        ({"timeout": "long"}, "timeout must be a number, got 'long'"),
        ({"timeout": -1.0}, "timeout expects a number of seconds, or 0 for no limit, got -1"),
        ({"memory": 3}, "memory must be a size such as '2G', got 3"),
        ({"memory": "much"}, "memory"),
    ],
)
def test_a_wrong_option_is_named_with_what_was_expected(options, message):
    """Argument, value, and what it should have been."""
    with pytest.raises(UsageError, match=re.escape(message)):
        verify("milstein", "gbm", "strong", **options)
