"""A page for each mistake the conformance kit finds: planted faults of its tests, put to it, and what it says."""

import inspect
import re
from collections.abc import Iterator
from typing import Any

from markup import page, prose, table, toctree, verbatim
from repairs import REPAIRS

from sdaeverify.testing import checks
from testing import test_problem_checks, test_scheme_checks
from testing.asking import of_problem, of_scheme

MODULES = {"scheme": test_scheme_checks, "problem": test_problem_checks}
LEGEND = "`p` is the problem, `x` the state, `n` the noise; `euler` makes a right step, `ruled` a scheme of a rule."
WHERE = re.compile(r"\s*\(h = [^()]*\)$")


def mistake_pages() -> dict[str, str]:
    """Return the pages by name."""
    found = {kind: dict(_pages(kind)) for kind in MODULES}
    index = [
        block
        for kind, pages in found.items()
        for block in (
            f"## Of a {kind}",
            table(
                ["check", "message"],
                ([f"`{name}`", f"[{title}](mistakes/{kind}-{name}.md)"] for name, (title, _) in pages.items()),
            ),
            toctree(f"{name} <mistakes/{kind}-{name}>" for name in pages),
        )
    ]
    told = (
        "`sdaeverify check NAME` runs the conformance checks on a scheme or a problem. Each check has a page: the "
        "message, what it means, how to repair it, and the smallest example. The message was printed for that "
        "example while the page was made."
    )
    pages = {f"mistakes/{kind}-{name}.md": text for kind, own in found.items() for name, (_, text) in own.items()}
    return {"mistakes.md": page("Mistakes that the kit finds", told, *index), **pages}


def _pages(kind: str) -> Iterator[tuple[str, tuple[str, str]]]:
    known = {check.name: check for check in checks(kind)}
    for name, faults in MODULES[kind].FAULTS.items():
        subject = (faults[0] if isinstance(faults, list) else faults)[0]
        outcome = of_scheme(subject, name, "ou") if kind == "scheme" else of_problem(subject, name)
        title = prose(WHERE.sub("", outcome["reason"]))
        text = page(
            title,
            "## What it means",
            f"The check `{name}` of a {kind} failed. " + prose(inspect.cleandoc(known[name].function.__doc__ or "")),
            "## How to repair it",
            REPAIRS[kind][name],
            *_planted(subject, name, kind),
            f"To run this check in Python: `check_{kind}(...)`, row `{name}`. All checks: [](../mistakes.md).",
        )
        yield name, (title, text)


def _planted(subject: Any, name: str, kind: str) -> Iterator[str]:
    source = _source(subject, name, kind)
    if source:
        yield "## The smallest example"
        yield "The mistake is planted here. " + LEGEND * (kind == "scheme")
        yield verbatim(source, "python")


def _source(subject: Any, name: str, kind: str) -> str:
    """Return the code of the subject: its class or function, or else its line in the table of faults."""
    module = MODULES[kind]
    thing = subject if inspect.isfunction(subject) else type(subject)
    if vars(module).get(thing.__name__) is thing:
        return inspect.cleandoc(inspect.getsource(thing))
    lines = inspect.getsource(module).splitlines()
    start = next(n for n, line in enumerate(lines) if line.startswith("FAULTS"))
    at = next(n for n, line in enumerate(lines[start:], start) if line.strip().startswith(f'"{name}":'))
    end = next(n for n, line in enumerate(lines[at + 1 :], at + 1) if re.match(r'    "|}', line))
    return inspect.cleandoc("\n".join(lines[at:end]))
