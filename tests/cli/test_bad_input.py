"""Whatever a user gets wrong: one line on stderr, the documented exit code, no traceback."""

from pathlib import Path

import pytest

from evidence import rows_of

UNREADABLE = "cannot read"
# Without one job asked for, problems are built in a worker of their own, which takes a second: two cases do.
WRONG_WORDS = [
    (["-s", "milstien"], "unknown scheme 'milstien'; did you mean milstein?"),
    (["-p", "pendlum"], "unknown problem 'pendlum'; did you mean pendulum"),
    (["-m", "stong"], "unknown measure 'stong'; did you mean strong?"),
    (["-m", "strong[h=1]"], "measure 'strong' takes no parameters"),
    (["-s", "half-explicit-euler[truncation=maybe]"], "truncation must be theory, none or a positive C_eta"),
    (["-p", "pendulum[c_g=abc]"], "parameter c_g of problem 'pendulum' expects a number, got 'abc'"),
    (["-p", "ou[a=0]", "-j", "1"], "a must not be zero"),
    (["-p", "pendulum[horizon=-1]", "-j", "1"], "horizon must be a positive time, got -1.0"),
    (["-p", "pendulum[c_g=1"], UNREADABLE),
    (["-s", "mil\x1b[31mstein"], UNREADABLE),
    (["--levels", "2"], "levels must be at least 3"),
    (["--levels", "8..100"], "--levels expects"),
    (["--out", ""], "invalid value for '--out': expected a path, got an empty text"),
    (["--paths", "0"], "paths must be at least"),
    (["--paths", "abc"], "'abc' is not a valid integer"),
    (["--paths"], "option '--paths' requires an argument"),
    (["-j", "0"], "0 is not in the range"),
    (["--progress", "loud"], "'loud' is not one of"),
    (["--pahts", "50"], "no such option --pahts; did you mean --paths?"),
    (["-y"], "no such option -y"),
    (["pendulum"], "unexpected extra argument"),
    (["--paths", "50", "--paths", "60"], "contradictory options: --paths is given as 50 and 60"),
    (["-j", "1", "--jobs", "2"], "contradictory options: --jobs is given as 1 and 2"),
    (["-p", "exponential-strip[alpha=1e200]", "-j", "1"], "cannot be built with these numbers"),
]


def in_one_line(out: str) -> str:
    """Return what is said, wherever its lines end."""
    return " ".join(out.split())


def one_line(err: str) -> str:
    """Return the only line there is."""
    (line,) = err.splitlines()
    assert err.endswith("\n")
    assert "Traceback" not in err
    assert line.isprintable()
    return line


@pytest.mark.parametrize(("arguments", "words"), WRONG_WORDS, ids=repr)
def test_wrong_words(call, tmp_path, arguments, words):
    """A wrong name, value or option is one line that says what was expected, with exit code 2; nothing is written."""
    outcome = call("matrix", *arguments)

    assert one_line(outcome.err).startswith("sdaeverify: error: ")
    assert words in outcome.err
    assert (outcome.code, outcome.out) == (2, "")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["matrx"], "unknown command 'matrx'; did you mean matrix?"),
        (["--jsn"], "no such option --jsn"),
        (["list", "scheme"], "'scheme' is not one of"),
        (["list", "--jsno"], "no such option --jsno; did you mean --json?"),
        (["new-plugin", ""], "invalid value for 'DIR': expected a path, got an empty text"),
        (["merge", ""], "invalid value for 'RUNS...': expected a path, got an empty text"),
        (["gate", "--out", ""], "invalid value for '--out': expected a path, got an empty text"),
        (["info"], "missing argument"),
        (["info", "milstien"], "no scheme, problem, measure or plugin is named 'milstien'; did you mean milstein?"),
        (["info", "pendulum[x=1]"], "problem 'pendulum' has no parameter 'x'"),
        (["info", "pendulum[horizon=-1]"], "horizon must be a positive time"),
        (["info", "strong[x=1]"], "measure 'strong' takes no parameters"),
    ],
    ids=repr,
)
def test_wrong_words_elsewhere(call, arguments, words):
    """The other commands and the program itself answer in the same way."""
    outcome = call(*arguments)

    assert words in one_line(outcome.err)
    assert outcome.code == 2


@pytest.mark.parametrize("folder", ["in-the-way", "in-the-way/below"])
def test_folder_that_cannot_be_written_into(quick, tmp_path, folder):
    """It is found out before anything runs."""
    (tmp_path / "in-the-way").write_text("a file")

    outcome = quick("-p", "gbm", "--out", folder)

    assert outcome.code == 2
    assert f"cannot write into {folder}" in one_line(outcome.err)


@pytest.mark.long
def test_file_that_cannot_be_replaced(quick, tmp_path):
    """A folder where a table is to be written is no traceback either."""
    (tmp_path / "out" / "verdicts.csv").mkdir(parents=True)

    outcome = quick("-p", "gbm", "-s", "milstein", "--out", "out")

    assert outcome.code == 2
    assert "cannot write out/verdicts.csv" in one_line(outcome.err)


@pytest.mark.parametrize("where", [pytest.param("as it is loaded", marks=pytest.mark.long), "in a step"])
def test_a_plugin_that_changes_the_folder(quick, odd_scheme, tmp_path, where):
    """The report is where the command line says, seen from where it was given."""
    plugin = odd_scheme(f"os.chdir({str(tmp_path / 'elsewhere')!r}); return Step(problem.euler(t, state, h, noise))")
    (tmp_path / "elsewhere").mkdir()
    if where == "as it is loaded":
        (tmp_path / "odd_plugin.py").write_text(
            (tmp_path / "odd_plugin.py").read_text() + f"os.chdir({str(tmp_path / 'elsewhere')!r})\n"
        )

    limits = ("--timeout", "0", "--memory", "0")
    outcome = quick("--plugin", plugin, "-p", "gbm", "-s", "odd", "-m", "strong", "--out", "out", *limits)

    assert outcome.err == ""
    assert (tmp_path / "out" / "verdicts.csv").is_file()
    assert not list((tmp_path / "elsewhere").iterdir())


def test_missing_plugin_file(quick):
    """A requested plugin that does not exist has the exit code of plugins."""
    outcome = quick("--plugin", "missing.py")

    assert outcome.code == 6
    assert "missing.py: expected an existing file" in one_line(outcome.err)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("raise RuntimeError('two\\nlines \\x1b[31m')", "RuntimeError: two lines"),
        ("sys.exit(0)", "SystemExit"),
        ("x = 1", "implements no hook"),
        ("def gbm(): pass\n@hookimpl\ndef sdaeverify_problems(): return [gbm]", "already registered by plugin"),
    ],
)
def test_broken_plugin_file(quick, write, text, words):
    """A requested plugin that fails in any way is one line that names the file."""
    outcome = quick("--plugin", write(text))

    assert outcome.code == 6
    assert words in one_line(outcome.err)
    assert "odd_plugin.py" in outcome.err


def test_a_step_that_raises_is_an_error_of_its_claim(quick, call, odd_scheme, tmp_path):
    """Wherever it raises, the claim is left open, the row names file and line, and show has the traceback."""
    narrow = "assert state.shape[-1] > 1; return Step(problem.euler(t, state, h, noise))"

    outcome = quick("--plugin", odd_scheme(narrow), "-p", "gbm", "-s", "odd", "-m", "strong")

    line = (tmp_path / "odd_plugin.py").read_text().splitlines().index(f"        {narrow}") + 1
    raised = f"a step of few paths raises AssertionError: no message (odd_plugin.py:{line})"
    told = f"order ≥ 1.0 (sampled: ≥ 0.8) not tested: {raised}"
    assert (outcome.code, outcome.err) == (3, "")
    assert f"! in error: odd on gbm, strong: {told}" in in_one_line(outcome.out)
    (details,) = rows_of("reports/latest/details/strong.csv")
    assert f'odd_plugin.py", line {line}, in step' in details["traceback"]
    shown = call("show", "reports/latest", "odd", "gbm").out
    assert f'odd_plugin.py", line {line}, in step' in shown


def test_problem_that_cannot_be_built(quick, odd_problem):
    """A problem whose initial state violates its constraint loses its cells, with the reason in the verdicts."""
    problem = """HolonomicSDAE(
        force=lambda t, r, v: 0 * r, diffusion=lambda t, r, v: np.eye(2)[..., None], noise_dim=2, horizon=1.0,
        constraint=lambda r: 1.0 - (r**2).sum(axis=0, keepdims=True), position=[2.0, 0.0], velocity=[0.0, 1.0],
        source="nowhere")"""

    outcome = quick("--plugin", odd_problem(problem), "-p", "zz-odd,gbm", "-s", "milstein", "-m", "strong")

    assert (outcome.code, outcome.err) == (3, "")
    told = "order ≥ 1.0 (sampled: ≥ 0.8) not tested: problem zz-odd cannot be built: initial data violate"
    assert f"! in error: milstein on zz-odd, strong: {told}" in in_one_line(outcome.out)
    assert "exit code 3: something could not be measured" in outcome.out


MUTE = "class Mute(Exception):", "    def __str__(self):", "        raise GeneratorExit", "raise Mute"
MISBEHAVING = {
    "return Step(state * np.nan)": ("refuted", "the state is not finite after 8 steps"),
    "raise ValueError('two\\nlines \\x1b[31m')": ("error", "ValueError: two lines \\x1b[31m"),
    "state += 1.0; return Step(state)": ("refuted", "writes into its state"),
    "noise.dW[:] = 0.0; return Step(state)": ("refuted", "writes into its state or its noise"),
    "return Step(state[:, :1])": ("refuted", "expected a state like the one it was given"),
    "return None": ("refuted", "expected Step(state)"),
    # Its status never passes for the outcome of the run.
    "sys.exit(0)": ("error", "SystemExit"),
    "raise GeneratorExit": ("error", "GeneratorExit: no message"),
    "raise StopIteration": ("error", "StopIteration: no message"),
    f"\n{' ' * 8}".join(MUTE): ("error", "Mute: its message cannot be read, which raises GeneratorExit"),
}


@pytest.mark.long
def test_schemes_that_misbehave(quick, odd_scheme):
    """Each loses its own cells, with the reason in words; another scheme on the same noise does not notice."""
    chosen, plugins = ("-p", "gbm", "-m", "strong"), []
    quick("-s", "milstein", *chosen, "--out", "alone")
    for number, step in enumerate(MISBEHAVING):
        text = Path(odd_scheme(step)).read_text().replace('"odd"', f'"odd-{number}"')
        plugins += ["--plugin", f"odd_{number}.py"]
        Path(plugins[-1]).write_text(text)

    outcome = quick(*plugins, "-s", "odd-*,milstein", *chosen, "--out", "both")

    assert (outcome.code, outcome.err) == (1, "")
    assert "\x1b" not in outcome.out
    cells = [row for row in rows_of("both/verdicts.csv") if row["problem"] == "gbm"]
    told = {row["scheme"]: (row["verdict"], row["reason"]) for row in cells}
    for number, (verdict, reason) in enumerate(MISBEHAVING.values()):
        assert told[f"odd-{number}"][0] == verdict
        assert reason in told[f"odd-{number}"][1]
    assert milstein_estimates("both") == milstein_estimates("alone")


def milstein_estimates(folder: str) -> list[list[str]]:
    """Return scheme, problem, measure, quantity, verdict, claim and orders of the rows of one scheme."""
    lines = (Path(folder) / "verdicts.csv").read_text().splitlines()
    return [line.split(",")[:12] for line in lines if line.startswith("milstein,gbm,strong")]


@pytest.mark.long
def test_wrong_scheme(call, odd_scheme):
    """A scheme that leaves out the noise is refuted, and the exit code says so."""
    plugin = odd_scheme("return Step(state + h * problem.drift(t, state))")

    outcome = call(
        "matrix", "--plugin", plugin, "-s", "odd", "-p", "gbm", "-m", "strong", "--paths", "400", "-j", "1"
    )

    assert outcome.code == 1
    told = "✗ refuted: odd on gbm, strong: order ≥ 1.0 (sampled: ≥ 0.8). Not exact on dx = S dW"
    assert told in in_one_line(outcome.out)
    assert outcome.out.endswith("exit code 1: a claim is refuted, or a check fails\n")


def test_nothing_that_can_be_run(quick):
    """A selection without any cell that applies is an exit code of its own, with the first reason."""
    outcome = quick("-s", "half-explicit-euler", "-p", "gbm")

    assert outcome.code == 5
    assert "no cell can be run (half-explicit-euler on gbm, drift: needs a HolonomicSDAE" in one_line(outcome.err)


def test_no_plugin_at_all(call, monkeypatch):
    """Where nothing is installed the way out is told."""
    monkeypatch.setattr("sdaeverify.registry.load.entry_points", lambda *_: [])

    outcome = call("matrix")

    assert outcome.code == 5
    assert "is sdaeverify installed?" in one_line(outcome.err)


def test_everything_disabled(call, monkeypatch):
    """Where all plugins are disabled, nothing is to be measured."""
    monkeypatch.setenv("SDAEVERIFY_DISABLED_PLUGINS", "sdaeverify")

    outcome = call("matrix")

    assert outcome.code == 5
    assert "no scheme and no problem and no measure is registered" in one_line(outcome.err)
