"""Citation of a result: table, sentence on method and version, BibTeX entry, sources of the claims."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from ...contracts.labels import is_meant
from ...contracts.settings import Settings
from ..cells import Row, text
from ..sentences import counts_in_words
from ..tables.rows import Rows
from ..verdict_row import VerdictRow
from .latex import escape_latex
from .table import PaperTable

# Copies of CITATION.cff, which is not in the wheel; tests compare them.
TITLE = "sdaeverify: verification of numerical schemes for stochastic differential-algebraic equations"
AUTHOR, YEAR = "The authors of sdaeverify", "2026"
URL = "https://github.com/sdaeverify/sdaeverify"
TIERS = {
    "T0": "by the contract of a step",
    "T1": "from the moments of one step, without sampling",
    "T2": "from the operator of the scheme, without sampling",
    "T3": "along sampled paths",
}


def method_sentence(rows: Sequence[VerdictRow], settings: Settings, run: Mapping[str, Any]) -> str:
    """Return how verdicts were found: version, counts, tiers, paths, steps, seed, error probability.

    Parameters
    ----------
    rows : sequence of VerdictRow
    settings : Settings
    run : mapping
        Contents of ``run.json``.
    """
    decided = Counter(row.decided_by for row in rows if row.decided_by in TIERS)
    tiers = ", ".join(f"{decided[tier]} {TIERS[tier]} ({tier})" for tier in TIERS if tier in decided)
    steps, version = settings.steps, run.get("versions", {}).get("sdaeverify", "")
    return (
        f"Verdicts of {f'sdaeverify {version}'.strip()} on {counts_in_words(row.verdict for row in rows)}."
        + (f" Decided: {tiers}." if tiers else "")
        + f" At most {settings.paths} paths, {steps[0]} to {steps[-1]} steps a path, seed {settings.seed}; in the"
        f" whole run, the probability of any false refutation is at most {1.0 - settings.confidence:.2g}."
    )


def bibtex(run: Mapping[str, Any]) -> str:
    """Return the BibTeX entry of the program in the version that made a run."""
    fields = {
        "author": f"{{{AUTHOR}}}",
        "title": f"{{{TITLE}}}",
        "year": YEAR,
        "version": escape_latex(run.get("versions", {}).get("sdaeverify", "")),
        "url": URL,
    }
    lines = ",\n".join(f"  {name} = {{{value}}}" for name, value in fields.items() if value)
    return f"@software{{sdaeverify,\n{lines}\n}}"


def sources(details: Iterable[Row]) -> Iterator[str]:
    """Yield the sources of the claims, one line for each scheme.

    Parameters
    ----------
    details : iterable of mapping
        Rows of the details of all measures.
    """
    found: dict[str, dict[str, None]] = {}
    for row in details:
        if source := text(row, "claim_source"):
            found.setdefault(text(row, "scheme"), {})[source] = None
    yield from (f"{scheme}: {'; '.join(known)}" for scheme, known in sorted(found.items()))


class ForPapers:
    """Methods of a result for papers.

    Attributes
    ----------
    rows : Rows
    settings : Settings
    run : dict
        Contents of ``run.json``.
    """

    rows: Rows
    settings: Settings
    run: dict[str, Any]

    def to_latex(self, schemes: str = "", problems: str = "", measures: str = "") -> str:
        """Return the verdicts as a LaTeX table with booktabs; the caption describes the method.

        Parameters
        ----------
        schemes, problems, measures : str, optional
            Labels or globs, separated by commas; all if left out.

        Raises
        ------
        UsageError
            If no row of the result matches.
        """
        return self._table(schemes, problems, measures).to_latex()

    def to_markdown(self, schemes: str = "", problems: str = "", measures: str = "") -> str:
        """Return the verdicts as a Markdown table, with a paragraph on the method.

        Parameters
        ----------
        schemes, problems, measures : str, optional
            See `to_latex`, which raises the same errors.
        """
        return self._table(schemes, problems, measures).to_markdown()

    def cite(self) -> str:
        """Return how to cite the result: a sentence on method and version, a BibTeX entry, sources of the claims."""
        told = [method_sentence(self.rows.verdicts, self.settings, self.run), "", bibtex(self.run), ""]
        known = [*sources(row for rows in self.rows.details.values() for row in rows)]
        return "\n".join([*told, *(["Sources of the claims:"] if known else []), *known])

    def _table(self, schemes: str, problems: str, measures: str) -> PaperTable:
        asked = {"scheme": schemes, "problem": problems, "measure": measures}
        rows = [
            row
            for row in self.rows.verdicts
            if all(is_meant(getattr(row, kind), patterns) for kind, patterns in asked.items())
        ]
        return PaperTable.of(rows, method_sentence(rows, self.settings, self.run))
