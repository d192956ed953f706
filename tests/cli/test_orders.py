"""The command ``orders``."""

import json

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


def test_a_verified_claim_is_a_row(call):
    """A row a claim and class; below the premises, and why a class does not apply; exit code 0."""
    outcome = call("orders", "milstein", "--class", "scalar,general")

    assert outcome.code == 0
    rows = [line.split() for line in outcome.out.splitlines()]
    assert ["milstein", "scalar", "1", "strong", "1", "1", "11", "of", "11", "verified"] in rows
    assert not any(row[:2] == ["milstein", "general"] for row in rows)
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


def test_a_record_that_cannot_give_an_order_is_told_before_the_tree(call, tmp_path):
    """Strong order 1 for general noise needs areas: a reader learns that no scheme could have it, then what fails."""
    plugin = tmp_path / "odd.py"
    plugin.write_text(PLUGIN)
    outcome = call("orders", "bold", "--class", "general", "--motions", "2", "--plugin", str(plugin))
    words = " ".join(outcome.out.split())

    assert outcome.code == 1
    sentence = "no scheme that is given dW alone can have strong order 1 (b1(b2) is beyond it)"
    assert words.index(sentence) < words.index("bold, general, strong: b1(b1): found 0, wanted I")


def test_rows_for_programs(call):
    """A list of objects with the columns of the table and the picture of the first tree."""
    outcome = call("orders", "milstein", "--class", "scalar,general", "--json")
    first, *_, last = json.loads(outcome.out)

    assert (first["measure"], first["order"], first["claim"]) == ("strong", 1.0, 1.0)
    assert (first["held"], first["of"], first["trees"]) == (11, 11, [["f", "└─ t"]])
    assert (last["verdict"], last["order"]) == ("not applicable", None)


def test_what_cannot_be_asked_has_codes_of_its_own(call, tmp_path):
    """Nothing applies, or words are wrong."""
    assert call("orders", "mala", "--class", "general").code == 5
    assert call("orders", "milstein", "--class", "odd").code == 2
    assert call("orders", "milstein", "--problem", str(tmp_path / "p.py")).code == 2
