"""The end of a run: at most 40 lines, the counts first, no name and no number broken."""

import re
from pathlib import Path

import pytest

from facade import read_verdicts
from report.rows import read, verdict, weak
from sdaeverify.report.plain import wrap_text
from sdaeverify.report.sentences import counts_of, ending, estimate_in_words, quantity_lines

REFERENCE = Path(__file__).resolve().parents[2] / "reports" / "reference"
WIDTHS = [60, 132]


def test_what_is_left_out_is_the_middle():
    """A text that is too long keeps its last clause, which often says what to do; without clauses its beginning."""
    lines = wrap_text(f"a reason {'of many words ' * 20}; take smaller steps", 40, "    ", 4)
    assert len(lines) == 4
    assert lines[0].startswith("a reason of many words")
    assert lines[-1] == "    … take smaller steps"
    assert wrap_text("word " * 100, 40, "", 3)[-1].endswith(" …")
    assert wrap_text(f"a; {'word ' * 100}", 40, "", 3)[0].startswith("a; word")


def end_of(rows, width=80, notes=("exit code 0: no claim is refuted",)):
    """Return the lines of the end of a run."""
    return [line.plain for line in ending(counts_of(read(*rows), []), read(*rows), notes, width)]


def words_of(lines):
    """Return the words that stand in lines."""
    return {word.strip(":,;") for word in " ".join(lines).split()}


def quantities(rows, width):
    """Return all lines on quantities."""
    return [line.plain for row in read(*rows) for line in quantity_lines(row, width)]


@pytest.fixture(scope="module")
def reference():
    """Return the rows of the committed reference run."""
    return read_verdicts(REFERENCE).verdicts


@pytest.mark.parametrize("width", WIDTHS)
def test_the_default_run_ends_in_forty_lines(reference, width):
    """The whole matrix, at every width; no line is wider than the terminal."""
    lines = end_of(reference, width)
    assert len(lines) <= 40
    assert max(map(len, lines)) <= width
    assert lines[0].startswith(f"{len(reference)} quantities: ")
    assert lines[-1] == "exit code 0: no claim is refuted"


@pytest.mark.long
@pytest.mark.parametrize("width", WIDTHS)
def test_no_word_is_broken(reference, width):
    """Names, numbers and intervals stand whole in a line: each word is one of those that are there at any width."""
    told = words_of(quantities(reference, width)) | words_of(end_of(reference, width))
    known = words_of(quantities(reference, 10_000)) | words_of(end_of(reference, 10_000))
    # What is left out is told by an ellipsis or a number; which schemes are counted depends on the lines left.
    rest = words_of(
        ["and more of them; show --open has all", "more schemes; show has all", *(row["scheme"] for row in reference)]
    )
    assert {word for word in told - known - rest if not re.fullmatch(r"…|[✓✗?!○]?\d+", word)} == set()


def test_what_is_wrong_is_told_with_claim_margin_estimate_and_reason():
    """One line says all that is needed of a refuted claim, before what is merely undecided."""
    rows = [
        verdict(scheme="b", verdict="inconclusive", reason="too few paths"),
        verdict(scheme="a", verdict="refuted", reason="local order 0.1"),
    ]
    lines = end_of(rows, 200)
    assert lines[1] == (
        "✗ refuted: a on gbm, strong x: order ≥ 0.5 (sampled: ≥ 0.3), "
        "found 0.39 [0.36, 0.43] along paths. local order 0.1"
    )
    assert lines[2].startswith("? inconclusive: b on gbm, strong x: ")


def test_many_of_a_kind_are_told_together():
    """Schemes that share problem, claim and the kind of the reason share a line, others do not."""
    told = {"verdict": "inconclusive", "reason_kind": "paths that would decide"}
    rows = [verdict(scheme=f"s{n}", reason=f"about {n}00 paths", **told) for n in range(1, 6)]
    (line,) = [line for line in end_of(rows, 200) if line.startswith("?")]
    assert line.startswith("? inconclusive: s1, s2, s3 and 2 more on gbm, strong x: ")
    alone = [{**row, "reason_kind": ""} for row in rows]
    assert sum(line.startswith("?") for line in end_of(alone, 200)) == 5


def test_what_is_wrong_with_a_scheme_as_a_whole_is_told_once():
    """An error that all measures share is one line, and no control character of it reaches the terminal."""
    lost = {"verdict": "error", "reason": "\x1b[2J", "path_order": "", "local_order": "", "claim": "", "margin": ""}
    rows = [verdict(**lost, measure="drift", quantity=""), verdict(**lost)]
    assert "! in error: some-euler on gbm, drift, strong x: no claim. \\x1b[2J" in end_of(rows, 200)


def test_what_does_not_fit_is_counted():
    """More findings than there is room for are a number and the way to them."""
    rows = [verdict(problem=f"p{n}", verdict="refuted", reason=chr(97 + n)) for n in range(26)]
    rows += [verdict(scheme=f"scheme-{n:02}") for n in range(40)]
    lines = end_of(rows)
    assert len(lines) <= 40
    assert any(re.fullmatch(r"and \d+ more of them; show --open has all", line) for line in lines)
    assert any(re.fullmatch(r"and \d+ more schemes; show has all", line) for line in lines)


def test_a_quantity_without_information_tells_its_local_order_and_why():
    """Noise along paths is not told; what one step shows is."""
    (row,) = read(weak())
    assert estimate_in_words(row) == "1.00 in one step"
    _, why = quantity_lines(row, 200)
    assert "no order along paths: a mean difference is 0.2 standard errors" in why.plain


def test_ascii_is_enough():
    """Where only ASCII can be shown, verdicts are letters."""
    rows = [verdict(), verdict(scheme="b", verdict="refuted")]
    lines = ending(counts_of(read(*rows), []), read(*rows), [], 80, plain=True)
    assert "".join(line.plain for line in lines).isascii()
