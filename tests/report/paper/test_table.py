"""Tables for a paper: LaTeX that compiles, Markdown that stays a table."""

import re

import pytest

from report.rows import RUN, read, verdict, weak
from sdaeverify import Settings, UsageError
from sdaeverify.report.paper.citation import AUTHOR, TITLE, URL, YEAR, bibtex, method_sentence, sources
from sdaeverify.report.paper.latex import LINE, column_types, escape_latex, set_indices
from sdaeverify.report.paper.table import PAGE, SIGNS, PaperTable
from sdaeverify.report.sentences import SYMBOLS

CAPTION = "By sdaeverify 0.9."


def table(*rows):
    """Return the table of rows."""
    return PaperTable.of(read(*rows), CAPTION)


def test_latex_is_a_booktabs_table():
    """Signs, claims with their relation as a formula, intervals; columns that are empty throughout are left out."""
    told = table(verdict(), weak(), verdict(verdict="refuted", scheme="a_b")).to_latex()
    assert r"$\checkmark$ & some-euler & strong x & order $\geq$ 0.5 & 0.48 & 0.39 [0.36, 0.43] & T1 \\" in told
    assert r"$\times$ & a\_\allowbreak{}b" in told
    assert (
        r"\caption{By sdaeverify 0.9. Problem: gbm. $\times$ refuted, $\checkmark$ verified, $\circ$ no claim.}"
        in told
    )
    assert r" & scheme & quantity & claim & one step & along paths & tier \\" in told
    for rule in (r"\toprule", r"\midrule", r"\bottomrule", r"\begin{tabular}{cllllll}", r"\end{tabular}"):
        assert told.count(rule) == 1


def test_each_line_of_latex_has_as_many_cells():
    """An ampersand in a label is no border of a cell."""
    told = table(verdict(scheme="a & b", quantity="50% of {x}_1 # ~^\\"), verdict(problem="ou")).to_latex()
    lines = [line for line in told.splitlines() if line.endswith(r"\\")]
    assert {len(re.findall(r"(?<!\\)&", line)) for line in lines} == {7}
    assert r"a \& b" in told
    assert r"50\% of \{x\}\textsubscript{1} \# \textasciitilde{}\textasciicircum{}\textbackslash{}" in told


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("50 & 3", r"50 \& 3"),
        ("a_b^c", r"a\_b\textasciicircum{}c"),
        ("\\input{x}", r"\textbackslash{}input\{x\}"),
        ("$x$ # 1 %", r"\$x\$ \# 1 \%"),
        ("Rößler ≥ 1", r"Rößler $\geq$ 1"),
        ("中", r"\texttt{U+4E2D}"),
        ("a\nb", r"a\textbackslash{}nb"),
    ],
)
def test_no_text_is_a_command_of_latex(text, written):
    """What has a meaning to LaTeX is escaped, what its fonts lack is shown by its number."""
    assert escape_latex(text) == written


@pytest.mark.parametrize(
    ("quantity", "written"),
    [
        ("weak |v|^2", r"weak \textbar{}v\textbar{}\textsuperscript{2}"),
        ("x_10@T", r"x\textsubscript{10}@T"),
        ("c_g^2", r"c\_g\textsuperscript{2}"),
        ("a^b", r"a\textasciicircum{}b"),
        ("second moment", "second moment"),
    ],
)
def test_numbers_of_a_quantity_are_indices(quantity, written):
    """Components and powers are set as they are printed, other underscores as they are."""
    assert set_indices(quantity) == written


def test_scheme_and_problem_stand_where_they_change():
    """In a table of one page; the caption has the name that all rows share."""
    told = table(verdict(quantity="x"), verdict(quantity="y"), verdict(scheme="b", quantity="x")).to_latex()
    lines = [line.split(" & ")[1] for line in told.splitlines() if line.startswith("$")]
    assert lines == ["some-euler", "", "b"]
    assert "Problem: gbm." in told
    assert " & gbm & " not in told


def test_columns_fit_a_line():
    """Columns that fit are not broken; words of others are, and the font is smaller if that is not enough."""
    short, long = ["scheme", "euler"], ["scheme", "semi-implicit-projection-euler[noise_projector=new]"]
    numbers = ["along paths", "1.00 [0.90, 1.10]"]
    assert column_types([short, numbers], [True, False])[1] == "ll"
    font, columns = column_types([long, long, numbers], [True, True, False])
    widths = [float(width) for width in re.findall(r"p\{(\d+)pt\}", columns)]
    assert "footnotesize" in font
    assert len(widths) == 2
    assert sum(widths) + 4.25 * len(numbers[1]) + 4 * 8.0 <= LINE
    assert "scriptsize" in column_types([long, long, *[numbers] * 3], [True, True, False, False, False])[0]


def test_every_verdict_has_a_sign():
    """In LaTeX as on the screen, and each sign means one thing in a legend."""
    assert {*SIGNS} == {*SYMBOLS}
    told = table(*(verdict(verdict=each) for each in SYMBOLS)).to_markdown()
    assert told.count("! failed") == 1


def test_a_long_table_breaks_over_pages():
    """More rows than a page has are no float."""
    told = table(*[verdict()] * (PAGE + 1)).to_latex()
    assert r"\begin{longtable}" in told
    assert r"\endhead" in told
    assert r"\begin{table}" not in told


def test_markdown_stays_a_table():
    """Every line has the same number of cells, whatever a label holds."""
    told = table(verdict(scheme="a|b"), weak()).to_markdown()
    lines = [line for line in told.splitlines() if line.startswith("|")]
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in lines} == {8}
    assert "| ✓ | a\\|b | strong x | order ≥ 0.5 |" in told
    assert told.endswith("By sdaeverify 0.9. Problem: gbm. ✓ verified, ○ no claim.\n")


def test_a_value_is_told_with_its_meaning():
    """An order that is bounded below alone is told with its sign, another value with what it is."""
    lower = weak(local_order="", value="2.0", value_low="1.8", value_high="inf", value_of="order")
    radius = weak(local_order="", value="0.25", value_of="largest stable h")
    assert "| ≥ 1.80 |" in table(lower).to_markdown()
    assert "| 0.25 (largest stable h) |" in table(radius).to_markdown()


def test_no_row_is_no_table():
    """Nothing to show is an error of the user."""
    with pytest.raises(UsageError, match="no table"):
        table()


def test_the_sentence_names_version_tiers_and_error():
    """Program, counts, tiers, paths, steps, seed, probability of a false refutation."""
    run = {**RUN, "versions": {"sdaeverify": "1.2.3"}}
    told = method_sentence(read(verdict(), verdict(decided_by="T3")), Settings(paths=256, seed=7), run)
    assert told.startswith("Verdicts of sdaeverify 1.2.3 on 2 quantities: 2 verified, none refuted. Decided: 1 from ")
    assert "1 along sampled paths (T3). At most 256 paths, " in told
    assert told.endswith("seed 7; in the whole run, the probability of any false refutation is at most 0.01.")


def test_the_entry_for_bibtex_is_that_of_the_citation_file(request):
    """Author, title, year and address are those of CITATION.cff; the version is that of the run."""
    file = (request.config.rootpath / "CITATION.cff").read_text(encoding="utf-8")
    assert f'title: "{TITLE}"' in file
    assert f"name: {AUTHOR}" in file
    assert f"repository-code: {URL}" in file
    assert f"date-released: {YEAR}-" in file
    told = bibtex({"versions": {"sdaeverify": "1.2.3"}})
    assert "version = {1.2.3}" in told
    assert told.count("{") == told.count("}")
    assert r"version = {1.2.3+a\_b}" in bibtex({"versions": {"sdaeverify": "1.2.3+a_b"}})


def test_sources_are_told_once_by_scheme():
    """A line for each scheme that claims something."""
    rows = [{"scheme": "b", "claim_source": "X"}, {"scheme": "a", "claim_source": "Y"},
            {"scheme": "b", "claim_source": "Z"}, {"scheme": "b", "claim_source": "X"}, {"scheme": "c"}]  # fmt: skip
    assert [*sources(rows)] == ["a: Y", "b: X; Z"]
