"""The policy: what a file may say, and what is said where it says something else."""

import pytest

from facade import FailingClaim, Policy, read_policy
from sdaeverify import UsageError

FULL = """
[project]
name = "my-schemes"

[tool.sdaeverify]
schemes = ["half-*", "milstein"]
problems = ["gbm[sigma=2]"]
measures = ["strong"]
plugins = ["extra/mine.py"]
alpha = 0.001
tier = "nightly"
seed = 7
inconclusive = "pass"
lock = "claims.lock"
timeout = 60
memory = "2G"
level = 1

[[tool.sdaeverify.expected-failures]]
scheme = "milstein"
quantity = "x@T"
reason = "issue 12"

[[tool.sdaeverify.expected-failures]]
reason = "no time"
strict = false
"""


@pytest.fixture
def read(tmp_path):
    """Read a pyproject.toml with this text."""

    def reader(text):
        (tmp_path / "pyproject.toml").write_text(text)
        return read_policy(tmp_path)

    return reader


def test_every_key(read, tmp_path):
    """All keys are read; plugin files and the lock file are relative to the file."""
    policy = read(FULL)

    assert policy.schemes == ("half-*", "milstein")
    assert policy.plugins == (str(tmp_path / "extra" / "mine.py"),)
    assert (policy.alpha, policy.tier, policy.seed, policy.timeout, policy.memory) == (0.001, "nightly", 7, 60, "2G")
    assert policy.lock_file == tmp_path / "claims.lock"
    assert policy.distribution == "my-schemes"
    assert policy.expected_failures == (
        FailingClaim(scheme="milstein", quantity="x@T", reason="issue 12"),
        FailingClaim(reason="no time", strict=False),
    )


def test_nearest_file_counts(read, tmp_path):
    """A file in a folder above is found, and one that is nearer hides it."""
    read(FULL)
    inner = tmp_path / "a" / "b"
    inner.mkdir(parents=True)

    assert read_policy(inner).seed == 7

    (tmp_path / "a" / "pyproject.toml").write_text("[project]\nname = 'other'\n")
    assert read_policy(inner).distribution == "other"
    assert read_policy(inner).seed == Policy().seed


def test_named_file(tmp_path):
    """A file that is named is read instead, and must be there."""
    (tmp_path / "strict.toml").write_text("[tool.sdaeverify]\nalpha = 0.1\n")

    assert read_policy(tmp_path, tmp_path / "strict.toml").alpha == 0.1
    with pytest.raises(UsageError, match=r"cannot read the policy .*absent.toml: No such file"):
        read_policy(tmp_path, tmp_path / "absent.toml")


@pytest.mark.parametrize(
    ("tier", "text", "fails"),
    [
        ("smoke", "", False),
        ("ci", "", False),
        ("nightly", "", True),
        ("ci", "fail", True),
        ("nightly", "pass", False),
    ],
)
def test_undecided(tier, text, fails):
    """What is undecided fails a scheduled run only, unless the policy says otherwise."""
    assert Policy(tier=tier, inconclusive=text).fails_undecided is fails


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[tool]\nsdaeverify = 'x'", r"expected a table \[sdaeverify\], got 'x'"),
        ("[tool.sdaeverify]\nscheme = ['x']", r"sdaeverify\]: unknown field `scheme`; did you mean schemes"),
        ("[tool.sdaeverify]\nschemes = 'x'", "schemes: Expected `array`, got `str`"),
        ("[tool.sdaeverify]\nmeasures = ['']", r"measures\[0\]: Expected `str` of length >= 1"),
        ("[tool.sdaeverify]\nalpha = '1%'", "alpha: Expected `float`, got `str`"),
        ("[tool.sdaeverify]\nalpha = nan", "alpha must be at least 1e-12 and at most 0.5, got nan"),
        ("[tool.sdaeverify]\nalpha = 9e-13", r"alpha must be at least 1e-12 and at most 0.5, got 9e-13"),
        ("[tool.sdaeverify]\ntier = 'night'", r"tier must be one of smoke, ci, nightly, got 'night'; did you mean"),
        ("[tool.sdaeverify]\nseed = -1", r"seed must be between 0 and 2\^63 - 1, got -1"),
        ("[tool.sdaeverify]\ninconclusive = 'warn'", r"inconclusive must be pass or fail, got 'warn'"),
        ("[tool.sdaeverify]\nlock = 'pyproject.toml'", r"lock must be a separate file, such as sdaeverify.lock"),
        ("[tool.sdaeverify]\nlevel = 0", r"level must be a level of the conformance kit, from 1 on, got 0"),
        ("[tool.sdaeverify]\ntimeout = -1", r"timeout must be a number of seconds, or 0 for no limit, got -1.0"),
        ("[tool.sdaeverify]\nmemory = '2 apples'", r"memory expects an amount of memory such as 500M or 2G"),
        ("[tool.sdaeverify]\nexpected-failures = ['x']", r"expected-failures\[0\]: Expected `object`"),
        (
            "[[tool.sdaeverify.expected-failures]]\nscheme = 'x'",
            r"expected-failures\[0\]: .*missing required field `reason`",
        ),
        ("[[tool.sdaeverify.expected-failures]]\nreason = ' '", r"expected-failures\[0\]: .* has no reason; say why"),
        (
            "[[tool.sdaeverify.expected-failures]]\nreason = 'x'\nproblems = 'y'",
            r"expected-failures\[0\]: .*unknown field `problems`; did you mean problem",
        ),
        (
            "[[tool.sdaeverify.expected-failures]]\nreason = 'x'\nstrict = 'yes'",
            r"expected-failures\[0\].strict: Expected `bool`, got `str`",
        ),
        ("[tool.sdaeverify\n", r"is not a TOML file"),
    ],
)
def test_wrong_files(read, text, message):
    """Each mistake is one line that names the file, the key, what was expected and what was given."""
    with pytest.raises(UsageError, match=message) as caught:
        read(text)

    assert "pyproject.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_least_alpha():
    """The smallest error probability that a policy may have leaves a confidence below 1."""
    assert Policy(alpha=1e-12).settings.confidence < 1.0


def test_no_file(tmp_path, monkeypatch):
    """Without any file the defaults hold, and the lock file is in the current folder."""
    monkeypatch.setattr("sdaeverify.gate.policy.FILE", "nowhere.toml")

    assert read_policy(tmp_path) == Policy()
    assert str(Policy().lock_file) == "sdaeverify.lock"


def test_how_long_a_hunt_takes():
    """A time with its unit is read in seconds, and anything else is told in one line."""
    assert [Policy(hunt=text).hunt_seconds for text in ("", "30 s", "1.5 min", "2h")] == [0.0, 30.0, 90.0, 7200.0]
    for text in ("soon", "0 s", "30"):
        with pytest.raises(UsageError, match="hunt must be a time such as '30 s'"):
            Policy(hunt=text)
