"""``claims``: summarize the findings of a run for each claim of a scheme."""

import shlex
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import click

from ...contracts.labels import is_meant
from ...contracts.spelling import counted, did_you_mean
from ...errors import UsageError
from ...report.folders import RUN, read_verdicts
from ...report.plain import visible
from ...report.saved import claims_of, read_attacks
from ...report.sentences import wrap_styled
from ...report.tables.claims import REFUTED, UNDECIDED, UNMEASURED, UNTESTED, VERIFIED, KnownClaim, known_claims
from ...report.verdict_row import VerdictRow
from .. import options
from ..completion import names_of
from ..console import complain, conclude, output, print_json, print_texts
from ..exit_codes import ExitCode, codes_in_words

# Verdict whose style is used for a claim, by the worst outcome of the claim.
LOOKS = {
    REFUTED: "refuted",
    UNMEASURED: "error",
    UNDECIDED: "inconclusive",
    VERIFIED: "verified",
    UNTESTED: "not_run",
}


@click.command(epilog=codes_in_words(), short_help="List the findings of a run on each claim of a scheme.")
@click.argument("scheme", metavar="SCHEME", shell_complete=names_of("schemes"))
@click.argument("folder", type=options.PLACE, metavar="[RUN]", default=Path("reports", "latest"))
@click.option("-m", "--measures", multiple=True, metavar="PATTERN", help="Claims about measures: names or globs.")
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each claim.")
def claims(scheme: str, folder: Path, measures: Sequence[str], as_json: bool) -> ExitCode:
    """Print one line for each claim of SCHEME, a label or a glob, with its findings in the run of a folder.

    The line counts the findings on problems, for classes of equations and of hunts: verified, refuted, undecided, not
    measured. A claim without findings is tested nowhere. The default folder is reports/latest.
    """
    if (Path(scheme) / RUN).is_file():
        raise UsageError(
            f"expected SCHEME, got the folder of a run; sdaeverify claims '*' {shlex.quote(scheme)} shows it"
        )
    tables = read_verdicts(folder)
    rows = map(VerdictRow.from_row, (*tables.verdicts, *tables.classes))
    attacks, why = read_attacks(folder)
    if why:
        complain("warning", why)
    every = known_claims(rows, claims_of(tables.run, folder), attacks)
    patterns = ",".join(measures)
    known = [each for each in every if is_meant(each.scheme, scheme) and is_meant(each.measure, patterns)]
    if not known:
        about = "".join(f", about {each}" for each in measures)
        of_measures = (_hint(each, (one.measure for one in every)) for each in measures)
        hints = (_hint(scheme, (one.scheme for one in every)), *of_measures)
        raise UsageError(f"no claim in {folder} is of {scheme}{about}{next(filter(None, hints), '')}")
    if as_json:
        print_json([each.record for each in known])
        return code_of_claims(known)
    console = output()
    for each in known:
        print_texts(console, wrap_styled(visible(each.sentence), console.width, "    ", LOOKS[each.worst]))
    print_texts(console, wrap_styled(_counts(known), console.width))
    return conclude(code_of_claims(known))


def code_of_claims(known: Sequence[KnownClaim]) -> ExitCode:
    """Return the exit code of the worst outcome; `NOTHING` if the worst is a claim that is tested nowhere.

    Parameters
    ----------
    known : sequence of KnownClaim
    """
    worst = {each.worst for each in known}
    codes = {REFUTED: ExitCode.REFUTED, UNMEASURED: ExitCode.NOT_MEASURED, UNTESTED: ExitCode.NOTHING}
    return next((code for outcome, code in codes.items() if outcome in worst), ExitCode.OK)


def _hint(word: str, names: Iterable[str]) -> str:
    """Return a suggestion for a pattern that matches no name, or an empty string if it matches."""
    known = {*names}
    return "" if any(is_meant(name, word) for name in known) else did_you_mean(word, known)


def _counts(known: Sequence[KnownClaim]) -> str:
    """Return a sentence with the number of claims by worst outcome."""
    found = Counter(each.worst for each in known)
    return f"{counted(len(known), 'claim')}: {', '.join(f'{count} {outcome}' for outcome, count in found.items())}"
