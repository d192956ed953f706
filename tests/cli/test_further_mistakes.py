"""Further mistakes of users, over all commands: one line each, the documented code, and a hint that helps."""

import shlex
from pathlib import Path

import pytest

from facade import ExitCode

from .conftest import HEADER, SCHEME

REFERENCE = Path(__file__).parents[2] / "reports" / "reference"
ODD = HEADER + SCHEME.format(step="return Step(state)")
EMPTY = "@hookimpl\ndef sdaeverify_{}:\n    {}\n"
PROBLEM = HEADER + "def zz({}) -> SDE:\n    return 1\n" + EMPTY.format("problems()", "return [{}]")
# Files by name: plugins, policies, and what is neither. A command line finds those that it names.
FILES = {
    "raises.py": "1 / 0",
    "syntax.py": "def f(:\n",
    "nothing.py": "x = 1",
    "unmarked.py": "def sdaeverify_schemes():\n    return []",
    "none.py": HEADER + EMPTY.format("schemes()", "return None"),
    "single.py": ODD.replace("[Odd()]", "Odd()"),
    "class.py": ODD.replace("[Odd()]", "[Odd]"),
    "name.py": HEADER + EMPTY.format("schemes()", "return ['milstein']"),
    "twice.py": ODD.replace("[Odd()]", "[Odd(), Odd()]"),
    "taken.py": ODD.replace('"odd"', '"milstein"'),
    "hook.py": HEADER + EMPTY.format("scheme()", "return []"),
    "spaces.py": ODD.replace('"odd"', '"Odd One"'),
    "order.py": ODD.replace("value=1.0", 'value="1.0"'),
    "comma.py": ODD.replace('source="nowhere"),)', 'source="nowhere"))'),
    "source.py": ODD.replace(', source="nowhere"', ""),
    "default.py": PROBLEM.format("a", "zz"),
    "import.py": "import numpyy",
    "exits.py": "raise SystemExit('stop')",
    "text.txt": "a text",
    "folder.py/file": "",
    "full/file": "",
    "run/run.json": "{}",
    "cut/run.json": '{"settings": {"pat',
    "cut/verdicts.csv": "scheme,problem\nmilstein,gbm\n",
    "text.toml": '[tool.sdaeverify]\nseed = "7"',
    "unknown.toml": "[tool.sdaeverify]\npaths = 100",
    "near.toml": "[tool.sdaeverify]\nexpected_failures = []",
    "tier.toml": '[tool.sdaeverify]\ntier = "Nightly"',
    "memory.toml": '[tool.sdaeverify]\nmemory = "2X"',
    "hunt.toml": '[tool.sdaeverify]\nhunt = "soon"',
    "quotes.toml": "[tool.sdaeverify]\nschemes = [milstein]",
    "empty.toml": "[tool.sdaeverify]\nschemes = []",
    "scheme.toml": '[tool.sdaeverify]\nschemes = ["milstien"]',
    "plugin.toml": '[tool.sdaeverify]\nplugins = ["missing.py"]',
    "lock.toml": '[tool.sdaeverify]\nlock = "/proc/odd.lock"',
    "package.json": '{"name": "mine"}',
    "cutlock/sdaeverify.lock": '{"schema_version": 2, "tiers": {"ci',
    "cutlock/pyproject.toml": '[tool.sdaeverify]\nschemes = ["milstein"]',
    "oldlock/sdaeverify.lock": '{"schema_version": 1, "tiers": {}}',
    "oldlock/pyproject.toml": '[tool.sdaeverify]\nschemes = ["milstein"]',
    "merged/sdaeverify.lock": "<<<<<<< HEAD\n{}\n=======\n",
    "merged/pyproject.toml": '[tool.sdaeverify]\nschemes = ["milstein"]',
}
# Nothing of these is run, but what is selected is looked at, in this process.
ONE = "-s milstein -p gbm -m strong -j 1 --dry-run"
GATE = "-j 1 --timeout 0 --memory 0 --progress none --tier smoke"
LEVELS = "COARSEST..FINEST steps such as 8..256"
WRITTEN = "name[key=value,...]"
MISTAKES = {
    "names": {
        "matrix -p 'gbm[q=1]' -j 1 --dry-run": "known: a, b, x_0, horizon",
        "matrix -p 'gbm[A=1]' -j 1 --dry-run": "did you mean a?",
        "matrix -p 'gbm a=1]' -j 1 --dry-run": WRITTEN,
        "matrix -p 'gbm[a:1]' -j 1 --dry-run": WRITTEN,
        "matrix -p 'gbm(a=1)' -j 1 --dry-run": WRITTEN,
        "matrix -p 'gbm[a=0,1]' -j 1 --dry-run": "cannot read '1'",
        "matrix -p 'gbm[a=1,a=2]' -j 1 --dry-run": "'a' is given twice",
        "matrix -p 'gbm[a=1e999]' -j 1 --dry-run": "must be finite",
        "matrix -p 'gbm;ou' -j 1 --dry-run": "did you mean gbm?",
        "matrix -p gbm,oo -j 1 --dry-run": "unknown problem 'oo'; sdaeverify list problems shows all",
        "matrix -p problems/gbm.py -j 1 --dry-run": "sdaeverify list problems shows all",
        "matrix -p 'gbm[horizon=0]' -s milstein -j 1 --dry-run": "horizon must be a positive time, got 0.0",
        "matrix -s gbm -j 1 --dry-run": "expected a scheme, 'gbm' is a problem; sdaeverify list schemes shows all",
        "matrix -s euler_maruyama -j 1 --dry-run": "did you mean euler-maruyama?",
        "matrix -s 'milstein[order=2]' -j 1 --dry-run": "no parameter 'order' (known: none)",
        "matrix -s all -j 1 --dry-run": "sdaeverify list schemes shows all",
        "matrix -m Strong -j 1 --dry-run": "did you mean strong?",
        "matrix -m order -j 1 --dry-run": "sdaeverify list measures shows all",
        "matrix -s --dry-run": "unknown scheme '--dry-run'",
    },
    "numbers": {
        f"matrix --levels 64..8 {ONE}": LEVELS,
        f"matrix --levels 8-64 {ONE}": LEVELS,
        f"matrix --levels 8,16,32 {ONE}": LEVELS,
        f"matrix --levels 0.1..0.01 {ONE}": LEVELS,
        f"matrix --levels 8..8 {ONE}": "at least 3, which a slope needs, got 1",
        f"matrix --paths -5 {ONE}": "paths must be at least 40, got -5",
        f"matrix --paths 1e4 {ONE}": "'1e4' is not a valid integer; sdaeverify matrix --help",
        f"matrix --paths 10,000 {ONE}": "'10,000' is not a valid integer",
        f"matrix --seed random {ONE}": "'random' is not a valid integer",
        f"matrix --confidence 99 {ONE}": "between 0.5 and 1, got 99.0",
        f"matrix --confidence 99% {ONE}": "'99%' is not a valid float",
        f"matrix --block 0 {ONE}": "between 40 and 2^20, got 0",
        f"matrix --max-looks 0 {ONE}": "between 1 and 20, got 0",
        "matrix --memory 2X --dry-run": "such as 500M or 2G, got '2X'",
        "matrix --memory 50% --dry-run": "such as 500M or 2G, got '50%'",
        "matrix --memory 100 --dry-run": "at least 256M",
        "matrix --timeout 10min --dry-run": "'10min' is not a valid float; sdaeverify matrix --help",
        "matrix -j all --dry-run": "'all' is not a valid integer; sdaeverify matrix --help",
        f"matrix --shard 0/4 {ONE}": "such as 3/16, got '0/4'",
        f"matrix --shard '1 of 4' {ONE}": "such as 3/16",
    },
    "options": {
        "matrix --alpha 0.01": "no such option --alpha; it is an option of compare, gate",
        "matrix --tier ci": "no such option --tier; it is an option of gate",
        "matrix --accuracy 1": "it is an option of choose",
        "matrix --verbose": "no such option --verbose; sdaeverify matrix --help shows what it takes",
        "matrix --scheme milstein": "did you mean --schemes?",
        "matrix -o here": "did you mean --out?",
        "matrix --no-html=1": "does not take a value",
        "matrix milstein gbm": "unexpected extra arguments (milstein gbm); sdaeverify matrix --help",
        "matrix --out --dry-run": "expected a path, got the option --dry-run; write ./--dry-run",
        f"matrix --executor threads {ONE}": "known: processes, dask, serial",
        f"matrix --executor '' {ONE}": "known: processes, dask, serial",
        "gate --paths 100": "choose, matrix",
        "gate smoke": "unexpected extra argument (smoke); sdaeverify gate --help",
        "gate --config --tier": "got the option --tier",
        "gate --write-lock -s milstein": "leave out -s, -p and -m",
        "gate --seed-from time": "'fixed', 'date'",
        "--plugin here.py list": "it is an option of adaptive, calibrate, check",
        "help": "known: adaptive, calibrate",
        "new_plugin": "did you mean new-plugin?",
        "list scheme": "'schemes', 'problems', 'measures', 'plugins'",
        "list schemes milstein": "sdaeverify list --help",
        "info milstein heun": "sdaeverify info --help",
        "info zzz": "sdaeverify list shows all",
        "info sde": "did you mean SDE?",
        "demo --paths 10": "choose, matrix",
    },
    "folders": {
        "matrix --out text.txt/below -s milstein -p gbm -m strong -j 1": "choose another --out",
        "selftest --only planted-em-variance* --out text.txt": "choose another --out",
        "calibrate --out text.txt": "choose another --out",
        "hunt milstein --out text.txt": "a file that ends in .py",
        "hunt milstein --out text.txt/found.py": "choose another --out",
        "new-plugin text.txt": "expects a folder that is new or empty",
        "new-plugin full": "expects a folder that is new or empty",
        "new-plugin here --name 'my plugin'": "letters a to z, digits and hyphens",
        "new-plugin here --name numpy": "numpy is a name of Python's or ours",
        "new-plugin /": "choose another with --name",
        "new-plugin": "missing argument 'DIR'; sdaeverify new-plugin --help",
        "matrix -s milstein -p gbm -m strong -j 1 --lf": "sdaeverify matrix --out FOLDER makes one",
        "show": "sdaeverify matrix --out FOLDER makes one",
        "show full": "full holds no run",
        f"show {REFERENCE} milstein gbm strong more": "a folder, a scheme and a problem",
        f"show {REFERENCE} milstein gbn": "did you mean gbm?",
        f"show {REFERENCE} milstein -m stong": "did you mean strong?",
        f"show {REFERENCE} zzz": "shows what there is",
        "compare": "missing argument 'RUNS...'",
        "compare run": "folders that matrix --out wrote, the oldest first",
        "compare full text.txt": "full holds no run",
        "compare cut cut": "cut/run.json is not valid JSON",
        "merge full": "sdaeverify matrix --out FOLDER makes one",
        "merge cut": "cut/run.json is not valid JSON",
        f"compare {REFERENCE} {REFERENCE} --factor 10%": "'10%' is not a valid float",
    },
    "plugins": {
        "list --plugin raises.py": "ZeroDivisionError: division by zero (raises.py:1)",
        "list --plugin syntax.py": "(syntax.py, line 1)",
        "list --plugin nothing.py": "expected one of sdaeverify_adaptive",
        "list --plugin unmarked.py": "put @hookimpl above it",
        "list --plugin none.py": "returned None, expected an iterable",
        "list --plugin single.py": "expected an iterable",
        "list --plugin class.py": "write Odd()",
        "list --plugin name.py": "expected a scheme, got an object of type str",
        "list --plugin twice.py": "registered twice by this plugin: Odd and Odd",
        "list --plugin taken.py": "already registered by plugin sdaeverify-schemes.milstein",
        "list --plugin hook.py": "did you mean sdaeverify_schemes?",
        "list --plugin spaces.py": "lower-case letters, digits, hyphens and dots, got 'Odd One'",
        "list --plugin order.py": "a number, not a text; got '1.0'",
        "list --plugin comma.py": "claims must be a tuple",
        "list --plugin source.py": "argument: 'source'",
        "list --plugin default.py": "has no default; give it one",
        "list --plugin import.py": "No module named 'numpyy' (import.py:1)",
        "list --plugin exits.py": "SystemExit: stop (exits.py:1)",
        "list --plugin text.txt": "ends in .py",
        "list --plugin folder.py": "install it as a package instead",
        "list --plugin a.py,b.py": "expected an existing file that ends in .py",
        f"gate --config plugin.toml {GATE}": "missing.py: expected an existing file",
        "hunt milstein --plugin none.py": "expected an iterable",
        "reproduce --list --plugin none.py": "expected an iterable",
        "selftest --plugin none.py": "expected an iterable",
    },
    "policies": {
        f"gate --config text.toml {GATE}": "seed: Expected `int`, got `str`",
        f"gate --config unknown.toml {GATE}": "unknown field `paths`; known are schemes, problems",
        f"gate --config near.toml {GATE}": "did you mean expected-failures?",
        "gate --config tier.toml -j 1": "did you mean nightly?",
        f"gate --config memory.toml {GATE}": "such as 500M or 2G",
        f"gate --config hunt.toml {GATE}": "such as '30 s' or '5 min'",
        f"gate --config quotes.toml {GATE}": "(at line 2, column 12)",
        f"gate --config empty.toml {GATE}": "length >= 1",
        f"gate --config scheme.toml {GATE}": "scheme.toml: [tool.sdaeverify]: unknown scheme 'milstien'; did",
        f"gate --config lock.toml {GATE} --write-lock": "cannot write into /proc",
        f"gate --config package.json {GATE}": "package.json is not a TOML file",
        f"gate --config cutlock/pyproject.toml {GATE}": "write a new one with gate --write-lock",
        f"gate --config oldlock/pyproject.toml {GATE}": "not a lock file of version 2",
        f"gate --config merged/pyproject.toml {GATE} --write-lock": "write a new one with gate --write-lock",
    },
    "other commands": {
        "orders": "missing argument 'SCHEME...'; sdaeverify orders --help",
        "orders gbm": "sdaeverify list schemes shows all",
        "orders milstein --class scaler": "did you mean scalar?",
        "orders milstein --motions 9": "1<=x<=4",
        "orders milstein --weight 99": "from 1 to 8, got 99",
        "orders milstein -p gbm": "did you mean --plugin or --problem?",
        "hunt milstein --form Sde": "did you mean SDE?",
        "hunt baoab --form DelaySDAE": "for problems of the forms",
        "hunt milstein --when diagonal-noice": "did you mean diagonal-noise?",
        "hunt milstein --when zzz": "sdaeverify info traits shows all",
        "hunt milstein --seed -1": "seed must be between 0 and 2^63 - 1, got -1",
        "hunt milstein --minutes 0": "must be positive, got 0.0",
        "choose gbm ou": "unexpected extra argument (ou); sdaeverify choose --help",
        "choose milstein": "sdaeverify list problems shows all",
        "choose gbm --levels 64..8": LEVELS,
        f"choose gbm --run {REFERENCE} --paths 100": "leave out --run, or --paths",
        f"choose gbm --run {REFERENCE} -s heun --seed 1": "leave out --run, or --schemes, --seed",
        "selftest --only nothere": "'*euler*' matches parts of names",
        "selftest --levels 8..64": "choose, matrix",
        "calibrate --only ''": "leave it out for all",
        "calibrate --only nothere": "known are slope",
        "calibrate --repetitions 0": "repetitions must be at least",
        "reproduce --list nosuch": "unknown experiment 'nosuch'; --list shows all",
        "reproduce all --format jpg": "'svg', 'pdf', 'png'",
        "adaptive gbm": "(known: ",
        "adaptive heun-pi --tolerances 1e-3": "three decreasing positive tolerances, got 0.001",
        "adaptive heun-pi --tolerances ''": "such as 1e-2,1e-3,1e-4",
        "adaptive heun-pi --paths 0": "a multiple of 20, at least 40, got 0",
        "adaptive heun-pi --seed -1": "between 0 and 2^63 - 1, got -1",
        "sealed gbm": "(known: ",
        "sealed own-euler --steps 4,8": "an order needs at least three increasing numbers of steps, got 4,8",
        "sealed own-euler --paths 100": "at least 3200 for 3 looks, got 100",
        "check zzz": "sdaeverify list shows all",
        "check milstein --level 99": "the newest of this kit, got 99",
        "check milstein -p ''": "empty selection of problems",
    },
}
CASES = [(kind, line, hint) for kind, lines in MISTAKES.items() for line, hint in lines.items()]


def test_there_are_sixty():
    """More are tried than were promised."""
    assert len(CASES) >= 60


@pytest.mark.sweep
@pytest.mark.parametrize(("kind", "line", "hint"), CASES, ids=[line for _, line, _ in CASES])
def test_a_mistake_is_one_line_with_a_hint(call, tmp_path, kind, line, hint):
    """It says what is wrong and what helps, on one line of stderr; nothing is on stdout, and no file is written."""
    words = shlex.split(line)
    for name in (name for name in FILES if {*words} & {name, name.split("/")[0]} or f"{name.split('/')[0]}/" in line):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(FILES[name])
    before = files(tmp_path)

    outcome = call(*words)

    (told,) = outcome.err.splitlines()
    assert told.startswith("sdaeverify: error: ")
    assert hint in told
    assert (outcome.code, outcome.out) == (code_of(kind, line), "")
    assert files(tmp_path) == before


def files(folder: Path) -> list[Path]:
    """Return all files there, but for compiled plugins."""
    return sorted(path for path in folder.rglob("*") if path.is_file() and "__pycache__" not in path.parts)


def code_of(kind: str, line: str) -> ExitCode:
    """Return the documented code: that of plugins where a file cannot be used as one."""
    return ExitCode.PLUGIN if kind == "plugins" else ExitCode.USAGE


@pytest.mark.parametrize("command", ["selftest", "calibrate", "reproduce", "check", "hunt", "gate"])
def test_the_codes_of_mistakes_are_documented(call, command):
    """The help of a command tells the codes of wrong usage and of plugins, and that of the program those of all."""
    for words in ((command,), ()):
        told = " ".join(call(*words, "--help").out.split())
        assert "Exit codes: 0 " in told
        assert "; 2 " in told
        assert "; 6 " in told
