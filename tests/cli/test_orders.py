"""The command ``orders``."""

import json

import pytest

pytestmark = pytest.mark.long

PLUGIN = """
from typing import ClassVar
from sdaeverify import SDE, Claim, Scheme, Step, hookimpl
class Odd(Scheme):
    name: ClassVar[str] = "odd"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="weak", value=2.0, source="nowhere"),)

    def step(self, problem, state, t, h, noise):
        return Step(problem.euler(t, state, h, noise))

class Bold(Odd):
    name: ClassVar[str] = "bold"
    claims: ClassVar[tuple] = (Claim(measure="strong", value=1.0, source="nowhere"),)

@hookimpl
def sdaeverify_schemes():
    return [Odd(), Bold()]
"""

MASSLESS = """
from typing import ClassVar
from sdaeverify import HolonomicState, Step, hookimpl
from sdaeverify_schemes.projections.half_explicit_euler import HalfExplicitEuler

class Massless(HalfExplicitEuler):
    name: ClassVar[str] = "massless-half-explicit"

    def step(self, problem, state, t, h, noise):
        right = HalfExplicitEuler(truncation="none").step(problem, state, t, h, noise)
        r, v, mu = state
        old, new = problem.linearised(r), problem.linearised(right.state.r)
        x = v + h * problem.force(t, r, v) + problem.diffused(t, r, v, noise.dW)
        lam = -new.gram(old).solve(new.times(x))
        return Step(HolonomicState(right.state.r, x + problem.push(old, lam), mu + lam), right.failed)

@hookimpl
def sdaeverify_schemes():
    return [Massless(truncation="none")]
"""


def test_a_verified_claim_is_a_row(call):
    """A row a claim and class; below the premises, and why a class does not apply; exit code 0."""
    outcome = call("orders", "milstein", "--class", "scalar,general")

    assert outcome.code == 0
    rows = [line.split() for line in outcome.out.splitlines()]
    assert rows[0] == ["milstein"]
    assert ["scalar", "1", "strong", "1", "1", "11/11", "verified"] in rows
    assert not any(row[:1] == ["general"] for row in rows)
    assert any(row[-1:] == ["(general)"] for row in rows)
    assert "weights independent of h" in outcome.out


def test_a_refuted_claim_has_its_tree(call, tmp_path):
    """The first failing condition as formula and picture, the problem file, and exit code 1."""
    plugin, problem = tmp_path / "odd.py", tmp_path / "problem.py"
    plugin.write_text(PLUGIN)
    outcome = call("orders", "odd", "--class", "scalar", "--plugin", str(plugin), "--problem", str(problem))

    assert outcome.code == 1
    assert "odd, scalar, weak: f(t): found 0, wanted 1/2\n    f\n    └─ t\n" in outcome.out
    assert "def counterexample(" in problem.read_text()


def test_a_refuted_weak_order_is_told_what_is_solved_instead(call, tmp_path):
    """The modified equation stands below the trees; a refuted strong order has none."""
    (tmp_path / "odd.py").write_text(PLUGIN)
    weak, strong = (call("orders", name, "--class", "scalar", "--plugin", "odd.py").out for name in ("odd", "bold"))

    assert (
        "odd, scalar: weak order 1; no modified SDE at h: its generator would have\n    -1/2 D^3 u[b, b, b' b]"
        in weak
    )
    assert "modified" not in strong


def test_a_record_that_cannot_give_an_order_is_told_before_the_tree(call, tmp_path):
    """Strong order 1 for general noise needs areas: a reader learns that no scheme could have it, then what fails."""
    plugin = tmp_path / "odd.py"
    plugin.write_text(PLUGIN)
    outcome = call("orders", "bold", "--class", "general", "--motions", "2", "--plugin", str(plugin))
    words = " ".join(outcome.out.split())

    assert outcome.code == 1
    sentence = "no scheme that uses only dW can have strong order 1 (b1(b2) requires more noise)"
    assert words.index(sentence) < words.index("bold, general, strong: b1(b1): found 0, wanted I")


REMEMBERING = """
from typing import ClassVar, NamedTuple
from sdaeverify import SDE, Array, Claim, Scheme, Step, hookimpl
class State(NamedTuple):
    x: Array
    before: Array

class Lazy(Scheme):
    name: ClassVar[str] = "half-explicit-two-step-scheme-with-a-long-name"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

    def enter(self, problem, state, t, h):
        return State(state, state)

    def parts(self, problem, state):
        return problem.parts(state.x)

    def step(self, problem, state, t, h, noise):
        x, before = state
        slope = (x - before) / 3.0 + 2.0 / 3.0 * h * problem.drift(t, x)
        return Step(State(x + slope + problem.diffused(t, x, noise.dW), x))

@hookimpl
def sdaeverify_schemes():
    return [Lazy()]
"""


@pytest.mark.slow
def test_what_is_not_decided_is_counted_below_an_unbroken_name(call, tmp_path, monkeypatch):
    """Where all premises fail nothing is refuted, and nothing verified either; 80 columns hold a long name."""
    monkeypatch.setenv("COLUMNS", "80")
    plugin = tmp_path / "lazy.py"
    plugin.write_text(REMEMBERING)
    outcome = call("orders", "half-*-long-name", "--plugin", str(plugin))
    name, headings, *rest = outcome.out.splitlines()

    assert name == "half-explicit-two-step-scheme-with-a-long-name"
    assert headings.split() == ["class", "motions", "claim", "order", "held", "verdict"]
    assert rest[-1] == "exit code 0: no claim is refuted, and no check fails"
    assert rest[-2].endswith("classes of equations: 7 without a verdict")
    # A row without a claim has no verdict that is missing.
    assert [line.split()[1:4] for line in rest if line.startswith("overdamped")] == [
        ["3", "invariant", "out_of_scope"]
    ]


@pytest.mark.slow
def test_a_premise_that_cannot_be_tested_is_told(call):
    """A step that fails on the problems of a premise leaves the claim open, with the step size; it is no crash."""
    outcome = call("orders", "stochastic-theta", "--class", "index-1-additive", "--motions", "4")

    assert outcome.code == 0
    assert "stochastic-theta: a step of size 0.0625 fails (index-1-additive)" in outcome.out


def test_rows_for_programs(call):
    """A list of objects with the columns of the table and the picture of the first tree."""
    outcome = call("orders", "milstein", "--class", "scalar,general", "--json")
    first, *_, last = json.loads(outcome.out)

    assert (first["measure"], first["order"], first["claim"]) == ("strong", 1.0, 1.0)
    assert (first["held"], first["of"], first["trees"]) == (11, 11, [["f", "└─ t"]])
    assert (last["verdict"], last["order"]) == ("not_applicable", None)


def test_what_cannot_be_asked_has_codes_of_its_own(call, tmp_path):
    """Nothing applies, or words are wrong."""
    assert call("orders", "mala", "--class", "general").code == 5
    assert call("orders", "milstein", "--class", "odd").code == 2
    assert call("orders", "milstein", "--problem", str(tmp_path / "p.py")).code == 2


def test_the_problem_of_a_refuted_class_is_refuted_and_right_schemes_pass(call, tmp_path):
    """`orders --problem` writes a member as a problem that `matrix` refutes; the right scheme is verified there."""
    plugin, out = tmp_path / "massless.py", tmp_path / "counterexample.py"
    plugin.write_text(MASSLESS, encoding="utf-8")
    asked = ("--plugin", str(plugin), "--class", "HolonomicSDAE", "--problem", str(out))
    assert call("orders", "massless-half-explicit", *asked).code == 1
    words = ("-p", "counterexample", "-m", "weak", "--plugin", str(out), "--plugin", str(plugin), "--paths", "512")
    assert call("matrix", "-s", "massless-half-explicit", *words, "--out", str(tmp_path / "wrong")).code == 1
    ended = call("matrix", "-s", "half-explicit-euler[truncation=none]", *words, "--out", str(tmp_path / "right"))
    assert ended.code == 0
    assert "verified" in ended.out


def test_modified_equations_are_shown(call):
    """With --modified the equation that is solved to one order more, its obstruction, and pictures of trees."""
    outcome = call("orders", "euler-maruyama", "--modified", "--class", "additive,scalar")

    assert outcome.code == 0
    lines = [line.strip() for line in outcome.out.splitlines()]
    assert "covariance  B B^T + h (-1/2 sum_j sym(f' b_j, b_j))" in lines
    assert "-1/2 D^3 u[b, b, b' b]" in lines
    assert "└─ b1" in lines


def test_modified_equations_of_langevin_dynamics(call):
    """Of Langevin dynamics the kinetic temperature and the variances in a harmonic potential are told, too."""
    outcome = call("orders", "baoab", "--modified", "--class", "langevin")

    assert "kinetic temperature  kT (1 + h^2 (-1/4 <lap U>/d))" in outcome.out
    assert "k <q^2> = kT, to h^2" in outcome.out


def test_modified_equations_for_programs(call):
    """With --json a record a class: order, formulas as text and LaTeX, terms with trees and values."""
    (record,) = json.loads(call("orders", "milstein", "--modified", "--class", "scalar", "--json").out)

    assert record["order"] == 1.0
    assert {key: record["terms"][-1][key] for key in ("trees", "value")} == {"trees": ["f(f)"], "value": -0.5}
    assert "\\tfrac{1}{2}" in record["latex"]["drift"]


def test_modified_equations_put_no_claim_to_the_test(call):
    """A file for a refuting problem is refused with --modified, and a class that does not apply is code 5 or so."""
    assert "--problem" in call("orders", "milstein", "--modified", "--problem", "out.py").err
    assert (
        call("orders", "baoab", "--modified", "--class", "scalar").code
        == call("orders", "baoab", "--class", "scalar").code
    )
