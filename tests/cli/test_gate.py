"""The command ``gate``: policy, exit codes, lock file, reports."""

import json
from pathlib import Path

import pytest

from evidence import rows_of
from facade import ExitCode, PluginRow, Registry, Study, read_limits, seed_of
from sdaeverify import UsageError
from sdaeverify.cli.commands.gate import gate, policy_of

PLUGIN = """
class Right(Scheme):
    name: ClassVar[str] = "right"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="a book"),)

    def step(self, problem, state, t, h, noise):
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))

class Wrong(Right):
    name: ClassVar[str] = "wrong"
    claims: ClassVar[tuple] = (
        Claim(measure="strong", value=1.0, source="wishful thinking"),
    )

@hookimpl
def sdaeverify_schemes():
    return [Right(), Wrong()]
"""
POLICY = """
[tool.sdaeverify]
plugins = ["odd_plugin.py"]
problems = ["gbm"]
tier = "smoke"
orders = false
"""
EXPECTED = """
[[tool.sdaeverify.expected-failures]]
scheme = "{}"
reason = "issue 12"
"""


@pytest.fixture
def project(call, write, tmp_path, monkeypatch):
    """Run the gate of a project with one right and one wrong scheme."""
    for name in ("GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY", "GITHUB_WORKSPACE"):
        monkeypatch.delenv(name, raising=False)
    # What a gate says does not depend on where it runs; processes of its own take their time.
    monkeypatch.setattr("sdaeverify.cli.commands.gate.read_limits", lambda *a: (read_limits(*a) and 1, None))
    write(PLUGIN)
    (tmp_path / "pyproject.toml").write_text(POLICY)

    def run(*arguments, policy=""):
        if policy:
            (tmp_path / "pyproject.toml").write_text(POLICY + policy)
        return call("gate", "-j", "1", "--progress", "none", *arguments)

    return run


def test_one_right_one_wrong(project):
    """A wrong claim fails the gate with claim, interval and command; every report is written and says so."""
    outcome = project()

    assert outcome.code == ExitCode.REFUTED
    assert "refuted: wrong on gbm, strong x: claimed order >= 1.0 up to a margin of 0.2" in outcome.out
    assert "estimate: 0." in outcome.out
    assert "% interval)" in outcome.out
    assert "reproduce: python -m sdaeverify matrix -s wrong -p gbm -m strong" in outcome.out
    assert "right on gbm" not in outcome.out
    assert outcome.out.splitlines()[-1] == "exit code 1: a claim is refuted, or a check fails"

    folder = Path("reports", "gate")
    report = json.loads((folder / "gate.json").read_text())
    assert {(row["scheme"], row["status"]) for row in report["outcomes"]} == {
        ("right", "passed"),
        ("wrong", "failed"),
    }
    assert {"verdicts.csv", "levels.csv", "run.json"} <= {file.name for file in folder.iterdir()}


def test_right_alone(project):
    """Options come before the policy; what is right passes."""
    outcome = project("-s", "right", "--alpha", "0.05")
    report = json.loads(Path("reports", "gate", "gate.json").read_text())

    assert outcome.code == report["exit_code"] == 0
    assert report["alpha"] == 0.05
    assert report["counts"] == {"passed": 2}


@pytest.mark.long
@pytest.mark.parametrize(
    ("claim", "why"),
    [
        ('measure="strong", value=0.5, quantities=("X",)', "no result is about 'X'"),
        ('measure="strong", value=0.5, when=frozenset({"algebraic"})', "it applies to no selected problem"),
        ('measure="weak", value="half"', "measure weak has no test for the claim 'half'"),
    ],
    ids=["quantity", "traits", "word"],
)
def test_claim_that_nothing_tests(project, write, claim, why):
    """It is said, and the gate is not green; a run of a part of the problems need not test it."""
    text = PLUGIN.replace('source="wishful thinking"', f'source="x"), Claim({claim}, source="nowhere"')
    write(text.replace('measure="strong", value=1.0, source="x"', 'measure="strong", value=0.5, source="x"'))

    outcome, part = project("-s", "wrong"), project("-s", "wrong", "-p", "gbm")

    assert outcome.code == ExitCode.NOTHING
    assert f"not tested: wrong: {claim.split('=')[1].split(',')[0].strip(chr(34))}" in outcome.out
    assert why in outcome.out
    assert part.code == ExitCode.OK


@pytest.mark.long
def test_second_run(project):
    """What was measured before is reused, and said to be, only where that is asked for."""
    outcomes = [project("-s", "right", *further) for further in ((), (), ("--reuse",), ("--fresh",))]

    told = [("note: evidence of 2 of 2 blocks" in outcome.out) for outcome in outcomes]
    assert told == [False, False, True, False]
    assert not any("on request" in outcome.out for outcome in outcomes)
    assert {outcome.code for outcome in outcomes} == {ExitCode.OK}


def test_expected_failure(project):
    """What is expected to fail does not fail the gate, and is told with its reason in the reports."""
    outcome = project(policy=EXPECTED.format("wrong"))

    assert outcome.code == 0
    assert (
        "failing as expected: wrong on gbm, strong x: claimed order >= 1.0 up to a margin of 0.2: issue 12"
        in outcome.out
    )


def test_unexpected_pass(project):
    """What was expected to fail and is verified fails the gate."""
    outcome = project("-s", "right", policy=EXPECTED.format("right"))

    assert outcome.code == ExitCode.UNEXPECTED
    assert "unexpectedly verified: right on gbm" in outcome.out


def test_idle_expectation(project):
    """An expected failure that nothing matches is a warning, where all cells were run."""
    outcome = project("--tier", "ci", policy=EXPECTED.format("heun"))

    assert "warning: no finding matches the expected failure scheme=heun (issue 12); remove it" in outcome.out


@pytest.mark.parametrize("arguments", [("--tier", "smoke"), ("--tier", "ci", "-p", "gbm")])
def test_an_expectation_of_what_is_not_there(project, arguments):
    """One that names nothing there is can never match: it is refused before anything is run, whatever is selected."""
    outcome = project(*arguments, policy=EXPECTED.format("writhe"))

    told = "the expected failure scheme=writhe (issue 12) can never match: no scheme is named writhe"
    assert outcome.code == ExitCode.USAGE
    assert told in outcome.err


@pytest.mark.long
def test_lock(project, tmp_path):
    """What is locked must be there: a claim that is gone is code 5 and is named."""
    written = project("--write-lock")
    assert f"{tmp_path / 'sdaeverify.lock'} locks 4 claims of tier smoke" in written.out

    assert project().code == ExitCode.REFUTED
    plugin = tmp_path / "odd_plugin.py"
    plugin.write_text(plugin.read_text().replace("value=1.0", "value=0.9").replace("[Right(), ", "["))
    outcome = project()

    assert outcome.code == ExitCode.NOTHING
    assert "lock file: no longer tested: right on gbm, strong x: order >= 0.5" in outcome.out
    assert "lock file: claim weakened: wrong on gbm, strong x: was order >= 1.0, is order >= 0.9" in outcome.out
    again = project("--write-lock")
    assert "note: unlocked: no longer tested: right on gbm, strong x: order >= 0.5" in again.out
    assert "note: unlocked: claim weakened: wrong on gbm, strong x: was order >= 1.0, is order >= 0.9" in again.out
    assert "unlocked" not in project("--write-lock").out


def test_lock_of_a_part(project):
    """Where the command line selects, only what it selects must be there; nothing can be locked then."""
    project("--write-lock")

    assert project("-s", "right").code == 0
    assert "leave out -s, -p and -m" in project("-s", "right", "--write-lock").err


@pytest.mark.parametrize("name", ["sdaeverify.lock", "README.md"])
def test_what_is_no_lock_file_is_not_overwritten(project, tmp_path, name):
    """A file that is no lock file is wrong usage, for --write-lock as well, which leaves it alone."""
    file, text = tmp_path / name, "# Schemes\n"
    file.write_text(text)
    policy = f'lock = "{name}"\n'

    outcomes = [project("-s", "right", policy=policy), project("--write-lock", policy=policy)]

    assert [outcome.code for outcome in outcomes] == [ExitCode.USAGE, ExitCode.USAGE]
    for outcome in outcomes:
        assert f"{file} is not a lock file of version 2: " in outcome.err
        assert "remove it and write a new one with gate --write-lock" in outcome.err
        assert outcome.err.count("\n") == 1
    assert file.read_text() == text
    assert not (tmp_path / "reports").exists()


@pytest.mark.slow
@pytest.mark.long
def test_a_gate_of_everything_says_why(project, monkeypatch, tmp_path):
    """Schemes of the policy's plugin files are its own; without any, the file that names none is named."""
    few = ("-p", "ou", "-m", "strong")
    assert "schemes are gated" not in project(*few).out

    (tmp_path / "pyproject.toml").write_text("[tool.sdaeverify]\ntier = 'smoke'\n")
    names = f"note: {tmp_path}/pyproject.toml names no schemes, plugins or project"
    assert f"{names}: the claims of all" in project(*few).out


def test_a_gate_tells_what_changed(project):
    """Against the folder of an earlier gate; one that is missing stops the gate before anything runs."""
    project("--out", "base", "-s", "right")
    told = project("--against", "base").out

    assert "note: against base: " in told
    assert "not gated before, refuted now" in told
    assert "right on gbm" not in told.replace("random members", "")
    missing = project("--against", "nowhere")
    assert missing.code == ExitCode.USAGE
    assert "--against: cannot read nowhere" in missing.err


def test_a_gate_without_a_project_asks_for_one(call):
    """In an empty folder nothing runs: one line says that a project is missing, and how all schemes are gated."""
    outcome = call("gate", "-j", "1")

    assert outcome.code == ExitCode.USAGE
    assert "no pyproject.toml is here or above, so there is no project to gate" in outcome.err
    assert "-s '*' for all schemes" in outcome.err
    assert not Path("reports").exists()


def test_missing_lock(project):
    """A lock file that the policy names must be there; without one a note says how to write it."""
    assert "note: without a lock file" in project("-s", "right").out
    (Path("pyproject.toml")).write_text(f"{POLICY}lock = 'claims.lock'\n")

    outcome = project()
    assert outcome.code == ExitCode.USAGE
    assert "claims.lock, though the policy names it; write it with gate --write-lock" in outcome.err


def test_nothing_measured(project):
    """A gate that tests no claim fails."""
    outcome = project("-m", "moments")

    assert outcome.code == ExitCode.NOTHING
    assert "warning: no claim of the selected schemes is tested" in outcome.out


def test_github(project, tmp_path, monkeypatch):
    """Text is fenced, annotations at the class of the scheme come after it, the summary is appended to a file."""
    summary = tmp_path / "summary.md"
    summary.write_text("before\n")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(summary))
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    lines = project().out.splitlines()

    token = lines[0].removeprefix("::stop-commands::")
    end = lines.index(f"::{token}::")
    assert not any(line.startswith("::") for line in lines[1:end])
    assert [line.split(",title")[0] for line in lines[end + 1 :]] == 2 * ["::error file=odd_plugin.py,line=16"]
    assert summary.read_text().startswith("before\n## ")
    assert "\nrefuted: wrong on gbm, strong x: claimed" in summary.read_text()


def test_seed_of_the_day(project, monkeypatch):
    """The seed of a day is printed; it cannot be given along with another one."""
    options = dict.fromkeys(parameter.name for parameter in gate.params)
    empty = {"schemes": (), "problems": (), "measures": (), "plugins": (), "seed_from": "date"}
    monkeypatch.setattr("sdaeverify.cli.commands.gate.seed_of", lambda day: seed_of(day) * 0 + 7)

    assert policy_of({**options, **empty}).seed == 7
    with pytest.raises(UsageError, match="--seed and --seed-from"):
        policy_of({**options, **empty, "seed": 1})
    assert "seed 7," in project("--seed-from", "date", "-s", "right").out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--tier", "nightmare"), "tier must be one of smoke, ci, nightly, got 'nightmare'"),
        (("--alpha", "2"), "alpha must be at least 1e-12 and at most 0.5, got 2.0"),
        (("--config", "nowhere.toml"), "cannot read the policy nowhere.toml"),
        (("--config", "empty.toml"), "[tool.sdaeverify] or [project], and there is neither in empty.toml"),
        (("-s", "rigth"), "unknown scheme 'rigth'; did you mean right?"),
        (("--memory", "much"), "--memory expects an amount of memory"),
    ],
)
def test_wrong_options(project, arguments, message):
    """A wrong option is one line and code 2."""
    Path("empty.toml").write_text("[tool.other]\n")

    outcome = project(*arguments)

    assert outcome.code == ExitCode.USAGE
    assert message in outcome.err
    assert len(outcome.err.splitlines()) == 1


def test_own_plugin_is_broken(project, monkeypatch, tmp_path):
    """A broken plugin of the project itself fails its gate, whatever else is registered."""
    row = PluginRow("mine", "mypack", "1", "mine.schemes", "broken", "ImportError: no")
    monkeypatch.setattr("sdaeverify.cli.commands.gate.load_and_warn", lambda files, **_: Registry({}, (row,)))
    (tmp_path / "pyproject.toml").write_text(f"[project]\nname = 'mypack'\n{POLICY}")
    outcome = project()

    assert outcome.code == ExitCode.PLUGIN
    assert "plugin mine of mypack, which is gated, is broken: ImportError: no" in outcome.err


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("ending", "why", "code"),
    [
        (KeyboardInterrupt, "interrupted", ExitCode.INTERRUPTED),
        (MemoryError, "out of memory", ExitCode.NOT_MEASURED),
    ],
)
def test_a_gate_that_is_ended(project, monkeypatch, ending, why, code):
    """What was finished is saved, the rest says why it was not run, and nothing is gated."""
    whole = Study.run

    def ended(*arguments):
        for event in whole(*arguments):
            yield event
            if event.results:
                raise ending

    monkeypatch.setattr(Study, "run", ended)
    outcome = project("-s", "right", "-p", "gbm,gbm[a=1]", "--tier", "ci")

    assert (outcome.code, outcome.out) == (code, "")
    saved = f"{why}; 1 of 2 problems are finished and saved in {Path('reports', 'gate')}; nothing is gated"
    advice = "" if ending is KeyboardInterrupt else "; try fewer --jobs or a smaller --block"
    assert outcome.err == f"sdaeverify: error: {saved}{advice}\n"
    rows = rows_of("reports/gate/verdicts.csv")
    assert {row["problem"]: row["reason"] == why for row in rows} == {"gbm": False, "gbm[a=1]": True}
    assert not Path("reports", "gate", "gate.json").exists()


@pytest.mark.long
def test_one_job_is_isolated_too(call, odd_scheme, tmp_path):
    """A step that ends its process costs its own cells, and not the gate, with one job as with many."""
    (tmp_path / "pyproject.toml").write_text("[tool.sdaeverify]\nproblems = ['gbm']\ntier = 'smoke'\n")

    outcome = call("gate", "-j", "1", "--progress", "none", "--plugin", odd_scheme("os._exit(0)"), "-s", "odd")

    assert outcome.code == 3
    assert "its worker process died" in outcome.out


@pytest.mark.long
def test_claims_for_classes_are_gated_where_no_problems_are_named(project, tmp_path):
    """A claim that an order condition refutes fails the gate, with tree and command; a policy may leave it out."""
    everything = POLICY.replace('problems = ["gbm"]\n', "").replace("orders = false\n", "")
    (tmp_path / "pyproject.toml").write_text(everything)
    outcome = project("-s", "wrong", "-m", "strong")
    found = json.loads(Path("reports/gate/gate.json").read_text())["outcomes"]
    by_class = {row["problem"]: row for row in found if row["problem"].startswith("every-equation")}

    assert outcome.code == ExitCode.REFUTED
    wrong = by_class["every-equation[of=scalar]"]
    assert (wrong["status"], wrong["decided_by"]) == ("failed", "TA")
    named = "Milstein's correction, the sum of DB_k B_j I_jk, is left out"
    assert wrong["reason"] == f"{named}; order 0.5: the condition b1(b1) fails, found 0, wanted I."
    assert wrong["reproduce"].startswith("python -m sdaeverify orders wrong --class scalar --plugin")
    assert by_class["every-equation[of=additive]"]["status"] == "passed"

    (tmp_path / "pyproject.toml").write_text(everything + "orders = false\n")
    project("-s", "wrong", "-m", "strong")
    found = json.loads(Path("reports/gate/gate.json").read_text())["outcomes"]
    assert not any(row["problem"].startswith("every-equation") for row in found)


@pytest.mark.long
def test_a_gate_without_tests_of_classes_says_so(project, tmp_path, monkeypatch):
    """Locked claims about classes are then no longer tested, which fails the gate; other claims pass as before."""
    policy = POLICY.replace("orders = false", 'schemes = ["right"]')
    (tmp_path / "pyproject.toml").write_text(policy)
    assert project("--write-lock").code == ExitCode.OK
    monkeypatch.setenv("SDAEVERIFY_DISABLED_PLUGINS", "orders")
    outcome = project()

    assert outcome.code == ExitCode.NOTHING
    assert "note: orders: this installation has no tests of claims about classes of equations" in outcome.out
    gated = json.loads(Path("reports/gate/gate.json").read_text())
    assert {(row["problem"], row["status"]) for row in gated["outcomes"]} == {("gbm", "passed")}
    told = "no longer tested: right on every-equation"
    assert gated["lock_violations"]
    assert all(line.startswith(told) for line in gated["lock_violations"])
