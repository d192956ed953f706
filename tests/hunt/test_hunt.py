"""A hunt finds what is wrong, shrinks it, and finds nothing where nothing is wrong."""

from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import sdaeverify
from facade import EulerMaruyama, execute, linear_test, load_registry, select_measures
from hunt.wrong_schemes import WRONG, LaterSecondStage, MalaOfAnotherProposal, OwnSigns
from sdaeverify import UsageError
from sdaeverify_hunt import hunt, observation
from sdaeverify_hunt.pilot import place
from sdaeverify_hunt.strategies import SDEExample, Term

pytestmark = pytest.mark.long

FAST = {"measures": "strong", "forms": ["SDE"], "shrinking": 5.0}
# Right schemes, each with the measure and the form of its examples.
RIGHT = (
    ("sri1w1", "strong", "SDE"),
    ("milstein", "strong", "SDE"),
    ("heun-additive", "weak", "SDE"),
    ("platen-weak-2-general", "weak", "SDE"),
)


@pytest.mark.slow
def test_a_wrong_time_of_a_stage_is_found():
    """A stage of SRI1W1 that is late is found, shrunk to few terms, and confirmed by a run."""
    (attack,) = hunt(LaterSecondStage(), examples=40, **FAST).found

    assert attack.example.dimension <= 2
    assert attack.example.terms <= 3
    assert attack.found_after <= 40
    assert attack.confirmed
    assert not attack.outcome.endswith("..")


def test_nothing_is_found_of_a_right_scheme():
    """A right scheme is not refuted, and it is said what was tried and what would have been seen."""
    report = hunt("milstein", examples=8, **FAST)
    (attack,) = report.attacks

    assert report.found == ()
    assert attack.looked_at == 8
    assert "nothing found in 8 examples" in attack.outcome
    assert "below the claim by 0.1" in attack.outcome
    assert "SDE" in repr(report)


def test_a_wrong_acceptance_is_found():
    """One of the first examples with a known invariant law refutes it."""
    (attack,) = hunt(MalaOfAnotherProposal(), measures="invariant", examples=5, shrinking=1.0).found

    assert attack.form == "gradient"
    assert attack.confirmed
    # On dx = -x dt + dW, a first example, several mistakes have the same acceptances, and none is named.
    assert "detailed balance fails for 320 of 320 pairs of states" in attack.reason


@pytest.mark.slow
def test_a_right_acceptance_is_verified():
    """Detailed balance verifies each example without a chain; orders of other schemes have no such examples."""
    (attack,) = hunt("mala", measures="invariant", examples=4).attacks
    (other,) = hunt("euler-maruyama", measures="invariant", examples=1).attacks

    assert (attack.form, attack.looked_at, attack.verified) == ("gradient", 4, 4)
    assert (other.form, other.looked_at) == ("SDE", 0)


def test_claims_without_an_example_are_named():
    """One example is of one class of noise: the claim about another one had none, and the report says so."""
    (attack,) = hunt("euler-maruyama", examples=1, **FAST).attacks

    assert sorted(attack.claims.values()) == [0, 0, 0, 1]
    assert {*attack.claims} == {f"order >= {p}{sense}" for p in (0.5, 1.0) for sense in ("", " in probability")}
    assert "0 of order >= " in attack.claimed


def test_a_hunt_is_determined_by_its_seed():
    """The same seed looks at the same examples, another one at others."""
    same = [hunt("euler-maruyama", examples=8, seed=seed, **FAST).attacks[0].tried for seed in (3, 3, 4)]

    assert same[0] == same[1] != same[2]


class Interrupted(BaseException):
    """What ends a hunt before its time."""


def interrupting():
    """Return what is told of shares, and ends the hunt after the first one."""

    def tell(line):
        raise Interrupted(line)

    return tell


def told_by(report):
    """Return what a report says, and how many examples it is from."""
    return [(attack.tried, attack.example, attack.found_after, attack.doubtful) for attack in report.attacks]


def test_a_hunt_that_is_interrupted_goes_on_to_the_same_end(tmp_path, monkeypatch):
    """What was looked at before an interruption is not looked at again, and the report is that of one hunt."""
    asked = {"examples": 4, "seed": 2} | FAST
    monkeypatch.setattr("sdaeverify_hunt.campaign.SIZE", 2)
    whole = hunt("euler-maruyama", **asked)
    with pytest.raises(Interrupted, match="2 examples"):
        hunt("euler-maruyama", **asked, database=tmp_path, tell=interrupting())
    lines = []
    resumed = hunt("euler-maruyama", **asked, database=tmp_path, tell=lines.append)

    assert len(lines) == 1
    assert told_by(resumed) == told_by(whole)


def test_a_hunt_is_the_same_on_any_workers(monkeypatch):
    """Shares that two threads look at side by side count as those of one process do."""
    asked = {"examples": 4, "seed": 2} | FAST
    monkeypatch.setattr("sdaeverify_hunt.campaign.SIZE", 2)
    with ThreadPoolExecutor(2) as threads:
        shared = hunt("euler-maruyama", **asked, executor=threads, jobs=2)

    assert told_by(shared) == told_by(hunt("euler-maruyama", **asked))


@pytest.mark.slow
def test_what_was_found_is_looked_at_first(tmp_path):
    """A hunt with another seed begins with what the one before has found."""
    first = hunt(LaterSecondStage(), examples=40, database=tmp_path, **FAST).attacks[0]
    again = hunt(LaterSecondStage(), examples=40, seed=5, database=tmp_path, **FAST).attacks[0]

    assert again.found_after == 1
    assert again.example == first.example


def test_an_example_can_begin_where_a_scheme_is_later():
    """An example that is begun later has the state of a run, and the coefficients of that time."""
    field = (Term(0.5, (1.0,), 2.0, 0.25),)
    example = SDEExample("additive", "globally Lipschitz", 1.0, (0.5,), (field,), (((Term(1.0),),),))
    scheme = EulerMaruyama()
    later = place(scheme, example, 0.5)

    assert place(scheme, example, 0.0) == example
    assert later.start != example.start
    old, new = example.build(), later.build()
    x = np.array([[0.3, -1.0]])
    np.testing.assert_allclose(new.drift(0.2, x), old.drift(0.7, x), rtol=1e-12)


@pytest.mark.parametrize(("verdict", "counts"), [("error", False), ("not_run", False), ("inconclusive", True)])
def test_an_example_on_which_a_scheme_raises_is_not_looked_at(monkeypatch, verdict, counts):
    """Where a measure of paths is in error, an example does not count as one that left the claim open."""
    scheme, registry = EulerMaruyama(), load_registry([])
    (measure,) = select_measures(registry, "stability")
    row = {"scheme": scheme.label, "claim": "conditional", "verdict": verdict, "reason": ""}
    table = pd.DataFrame([row | {"claimed_order": np.nan, "path_order": np.nan}])
    monkeypatch.setattr(observation, "verify", lambda *_, **__: SimpleNamespace(verdicts=table))

    assert (
        observation.observe(observation.Target(scheme, measure, "SDE", registry.followed), linear_test) is not None
    ) is counts


def test_examples_have_the_traits_that_are_asked_for():
    """With traits, all examples are of a kind that has them."""
    (attack,) = hunt("milstein", examples=5, when=["diagonal-noise"], **FAST).attacks

    assert {kind for kind, _ in attack.tried} == {"diagonal"}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"forms": ["Ode"]}, "registered: unknown form 'Ode'; did you mean SDE"),
        ({"examples": 0}, "examples must be at least 1"),
        ({"minutes": -1.0}, "minutes must be positive"),
        ({"nonsense": 1}, "unknown option nonsense"),
        ({"measures": "uniform"}, "nothing to search"),
    ],
)
def test_wrong_options_are_told(options, message):
    """A wrong option costs one line."""
    with pytest.raises(UsageError, match=message):
        hunt("milstein", **options)


@pytest.mark.slow
def test_the_command_writes_a_plugin_and_a_test(tmp_path, capsys):
    """What is found is written as a plugin file that the scheme is refuted on, with a test beside it."""
    scheme = tmp_path / "scheme.py"
    scheme.write_text(
        "from sdaeverify import hookimpl\n"
        "from hunt.wrong_schemes import LaterSecondStage\n"
        "@hookimpl\n"
        "def sdaeverify_schemes():\n"
        "    return [LaterSecondStage()]\n"
    )
    found = tmp_path / "found.py"
    chosen = [
        "later-second-stage",
        "-m",
        "strong",
        "--examples",
        "40",
        "--when",
        "scalar-noise",
        "--shrinking",
        "3",
        "-j",
        "1",
    ]

    assert execute(["hunt", *chosen, "--plugin", str(scheme), "--out", str(found), "--progress", "none"]) == 1
    assert "is refuted by example" in capsys.readouterr().out
    assert "test_counterexample_is_not_refuted" in (tmp_path / "test_found.py").read_text()
    rows = sdaeverify.verify(LaterSecondStage.name, "counterexample", "strong", plugins=[scheme, found]).verdicts
    assert (rows.verdict == "refuted").any()
    rows = sdaeverify.verify("sri1w1", "counterexample", "strong", plugins=[found]).verdicts
    assert not (rows.verdict == "refuted").any()

    kept = tmp_path / "kept"
    assert execute(["hunt", *chosen, "--plugin", str(scheme), "--out", str(kept), "--progress", "none"]) == 1
    rows = sdaeverify.load(kept).verdicts
    refuted = rows[rows.verdict == "refuted"]
    assert [*refuted.problem] == ["random-problem"]
    assert refuted.reason.str.contains("confirmed by a run").all()
    assert (kept / "counterexample.py").read_text() == found.read_text()


def test_the_command_says_that_nothing_was_found(capsys):
    """A right scheme ends with code 0, one of which nothing is claimed with another; each claim has its examples."""
    assert execute(["hunt", "milstein", "-m", "strong", "--examples", "3", "-j", "1", "--progress", "none"]) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[-1] == "3 examples, 1 attack, 0 counterexamples."
    assert [line for line in told if line.startswith("  claims:")] == [
        "  claims: 3 of order >= 1.0; 0 of order >= 1.0 in probability"
    ]
    assert execute(["hunt", "milstein", "-m", "strong", "--form", "Langevin", "--examples", "3", "-j", "1"]) in {0, 5}


@pytest.mark.slow
@pytest.mark.parametrize("scheme", WRONG, ids=lambda scheme: scheme.label)
def test_errors_that_shipped_problems_pass_are_found(scheme):
    """Four errors, by which no claim on a shipped problem is refuted, are found in 300 examples and confirmed."""
    (attack,) = hunt(scheme, measures=scheme.claims[0].measure, examples=300).found

    assert attack.example.dimension <= 3
    assert attack.confirmed


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "measure", "form"), [*RIGHT, (OwnSigns(), "weak", "SDE")])
def test_right_schemes_are_not_refuted(scheme, measure, form):
    """Of 60 examples drawn for each of five right schemes, none is confirmed to refute a claim, some verify it."""
    report = hunt(scheme, measures=measure, forms=[form], examples=60)

    assert report.found == ()
    assert report.attacks[0].verified > 0
