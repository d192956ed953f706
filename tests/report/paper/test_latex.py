"""A LaTeX document with tables and figures of a result compiles."""

import re
import shutil
import subprocess

import pytest

from report.rows import level, read, verdict, weak
from sdaeverify import UsageError
from sdaeverify.report.paper.latex import FONTS
from sdaeverify.report.paper.table import PAGE, PaperTable
from sdaeverify.report.plots import Plots
from sdaeverify.report.sentences import SYMBOLS

plt = pytest.importorskip("matplotlib.pyplot", reason="needs the extra plot")
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(
        shutil.which("pdflatex") is None, reason="needs pdflatex: texlive-latex-recommended, -pictures"
    ),
]
# Only what the table and the head of the PGF file ask for.
PREAMBLE = r"""\documentclass{article}
\usepackage[T1]{fontenc}
\usepackage{array,amssymb,booktabs,longtable,pgf,graphicx}
\begin{document}
"""
ODD = "semi-implicit-projection-euler[noise_projector=new,theta=0.5]"
CAPTION = "By sdaeverify 0.9: 50% & more_or_less #1."


def compiled(folder, body):
    """Compile a document and return its log, with lines joined that LaTeX has broken."""
    (folder / "paper.tex").write_text(f"{PREAMBLE}{body}\n\\end{{document}}\n", encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "paper.tex"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace", check=False)
    assert done.returncode == 0, done.stdout[done.stdout.find("\n!") :][:500]
    return done.stdout.replace("\n", " ")


def rows():
    """Return rows with every verdict, long labels, every letter that LaTeX knows as a command, and other values."""
    signs = [verdict(verdict=each, scheme=ODD) for each in SYMBOLS]
    odd = verdict(scheme=r"a&b_c{d}~^\\$#%", quantity='50% of "x"_1 <|v|^2> ≥ Rößler 中')
    value = weak(local_order="", value="0.25", value_of="largest stable h", problem="sphere-langevin[m_2=2]")
    return read(*signs, odd, value)


@pytest.fixture
def axes():
    """Return a figure of two schemes whose labels hold underscores."""
    h = [2.0**-k for k in range(3, 7)]
    names = ("euler[a_b=1]", "milstein")
    levels = [level(scheme=name, h=str(x), estimate=str(x / 2), std_error=str(x / 20)) for name in names for x in h]
    plots = Plots(read(*(verdict(scheme=name) for name in names)), levels)
    yield plots, plots.convergence(style="paper")
    plt.close("all")


@pytest.mark.parametrize("copies", [1, PAGE])
def test_a_table_compiles_and_fits_the_line(tmp_path, copies):
    """A float and a table of several pages; no word reaches the next column, and the table is as wide as the text."""
    log = compiled(tmp_path, PaperTable.of([*rows()] * copies, CAPTION).to_latex())
    over = {
        kind: float(width) for width, kind in re.findall(r"Overfull \\hbox \(([0-9.]+)pt too wide\) in (\w+)", log)
    }
    assert "alignment" not in over
    assert over.get("paragraph", 0.0) < min(font.between for font in FONTS)


def test_figures_compile(tmp_path, axes):
    """PDF and PGF in one document, which loads no package for the PGF file but pgf."""
    plots, ax = axes
    plots.save(ax, tmp_path / "errors.pdf", tmp_path / "errors.pgf")
    log = compiled(tmp_path, r"\noindent\includegraphics{errors.pdf}\par\noindent\input{errors.pgf}")
    assert "Output written on paper.pdf (1 page" in log


def test_a_text_that_latex_cannot_set_is_told(tmp_path, axes):
    """A figure of the user's own with an undefined command costs one line."""
    plots, ax = axes
    ax.set_ylabel(r"$\nosuchcommand$")
    with pytest.raises(UsageError, match=r"LaTeX cannot set the texts of .*errors\.pgf"):
        plots.save(ax, tmp_path / "errors.pgf")
