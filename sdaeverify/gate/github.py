"""Output for GitHub Actions: job summary, annotations of scheme classes, and fences around other output.

The runner interprets a line that begins with ``::`` as a command. All output of plugins is printed between
``::stop-commands::TOKEN`` and ``::TOKEN::`` with a random token; in annotations it is escaped.
"""

import inspect
import secrets
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from textwrap import shorten

from ..contracts.finding import Status
from ..contracts.scheme import Scheme
from ..report.folders import Key
from ..report.plain import escape, visible
from .gated import WORDS, Gated
from .outcomes import ORDER, Outcome
from .words import LONGEST, gated_command, message, text_report

MOST = 10
# Outcomes in a summary. GitHub limits a summary to 1 MiB, and an outcome rarely takes more than 2 KiB.
MOST_ROWS, FENCE = 200, "~~~~"
DETAILS = "<details><summary>The report</summary>"
# Folders that hold copies of sources, of installed and of built packages.
INSTALLED = frozenset({"site-packages", "dist-packages", "build"})
KINDS = {Status.FAILED: "error", Status.UNMEASURED: "error", Status.XPASSED: "error", Status.UNDECIDED: "warning"}


@contextmanager
def fence(write: Callable[[str], None]) -> Iterator[None]:
    """Disable commands of the runner while untrusted output is written.

    Parameters
    ----------
    write : callable
        Write a line to the stream from which the runner reads commands.
    """
    token = secrets.token_hex(16)
    write(f"::stop-commands::{token}")
    try:
        yield
    finally:
        write(f"::{token}::")


def annotations(gated: Gated, root: Path) -> Iterator[str]:
    """Yield the commands that annotate failed and undecided claims, worst first and ten at most.

    Parameters
    ----------
    gated : Gated
    root : Path
        Folder to which file names are relative. A claim whose source lies outside is annotated without a file.
    """
    told = [outcome for outcome in gated.not_passed if outcome.status in KINDS]
    lines = [*(f"lock file: {line}" for line in gated.violations), *(f"hunt: {line}" for line in gated.hunted)]
    shown = [_command("error", {"title": "sdaeverify lock file"}, visible(line)) for line in lines[: MOST // 2]]
    shown += [_annotation(outcome, gated, root) for outcome in told[: MOST - len(shown)]]
    yield from shown


def property_text(text: str) -> str:
    """Escape a text for the value of a property of a command."""
    return data_text(text).replace(":", "%3A").replace(",", "%2C")


def data_text(text: str) -> str:
    """Escape a text for the message of a command."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _annotation(outcome: Outcome, gated: Gated, root: Path) -> str:
    kind = "error" if gated.is_red(outcome) else KINDS[outcome.status]
    title = f"sdaeverify: {outcome.cell.measure.name} {outcome.status}"
    properties = {**place_of(outcome.cell.scheme, root), "title": title}
    return _command(kind, properties, message(outcome, gated.settings, gated_command(gated, outcome)))


def _command(kind: str, properties: dict[str, str], message: str) -> str:
    listed = ",".join(f"{name}={property_text(visible(text))}" for name, text in properties.items())
    return f"::{kind} {listed}::{data_text(message)}"


def place_of(scheme: Scheme, root: Path) -> dict[str, str]:
    """Return file and line of a scheme's class in a checkout; empty if its source is not in the checkout."""
    try:
        _, line = inspect.getsourcelines(type(scheme))
        file = source_in(root, Path(inspect.getsourcefile(type(scheme)) or ""))
    except (OSError, TypeError, SyntaxError):
        return {}
    return {"file": file, "line": str(line)} if file else {}


def source_in(root: Path, file: Path) -> str:
    """Return the path of a module's source relative to a checkout, or an empty string.

    An installed module is a copy of its source. The source is the file of the checkout, or of its folder ``src``,
    with the same content and the longest common end of the path.

    Parameters
    ----------
    root : Path
        Folder of the checkout.
    file : Path
        File from which the module was imported.
    """
    root, names = root.resolve(), file.resolve().parts
    ends = (names[first:] for first in range(1, len(names)))
    copies = (Path(*folder, *end) for end in ends if INSTALLED.isdisjoint(end) for folder in ((), ("src",)))
    same = (copy for copy in copies if (root / copy).is_file() and (root / copy).read_bytes() == file.read_bytes())
    return next((copy.as_posix() for copy in same), "")


def markdown_report(gated: Gated) -> str:
    """Return the summary of a job: changes, claims that did not pass, counts by scheme, full report.

    Parameters
    ----------
    gated : Gated
    """
    # No line of the report begins with text of a plugin, which could close the fenced block.
    report = [FENCE, *text_report(gated, MOST_ROWS), FENCE]
    sign = "❌" if gated.code else "✅"
    head = [f"## {sign} sdaeverify gate: {escape(gated.words)}", "", escape(f"{gated.summary}; {gated.budget}"), ""]
    return "\n".join(
        [*head, *_changed(gated), *_not_passed(gated), *_by_scheme(gated), DETAILS, "", *report, "", "</details>", ""]
    )


def _changed(gated: Gated) -> list[str]:
    if gated.changes is None:
        return []
    if not gated.changes:
        return ["No claim has another status than before.", ""]
    rows = [(*_about(key), before, f"**{now}**") for key, before, now in gated.changes]
    return _table("What changed", ("scheme", "problem", "quantity", "before", "now"), rows)


def _not_passed(gated: Gated) -> list[str]:
    rows = [
        (WORDS[outcome.status], *_about(outcome.key), escape(outcome.claim), escape(_reason(outcome)))
        for outcome in gated.not_passed
    ]
    return _table("What did not pass", ("", "scheme", "problem", "quantity", "claim", "why"), rows)


def _by_scheme(gated: Gated) -> list[str]:
    counts = Counter((outcome.cell.scheme.label, outcome.status) for outcome in gated.outcomes)
    shown = [status for status in (Status.PASSED, *ORDER[:-1]) if any(status is found for _, found in counts)]
    rows = [
        (escape(scheme), *(str(counts[scheme, status] or "") for status in shown))
        for scheme in sorted({scheme for scheme, _ in counts})
    ]
    return _table("Schemes", ("scheme", *(WORDS[status] for status in shown)), rows)


def _about(key: Key) -> tuple[str, str, str]:
    return escape(key.scheme), escape(key.problem), escape(f"{key.measure} {key.quantity}".strip())


def _reason(outcome: Outcome) -> str:
    return shorten(outcome.expected or str(outcome.finding.reason), LONGEST, placeholder=" ...")


def _table(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a Markdown table under its title, or an empty list if it has no rows."""
    if not rows:
        return []
    lines = (f"| {' | '.join(cells)} |" for cells in (headings, ["---"] * len(headings), *rows[:MOST_ROWS]))
    more = [f"and {len(rows) - MOST_ROWS} more, see gate.json", ""] if len(rows) > MOST_ROWS else []
    return [f"### {title}", "", *lines, "", *more]
