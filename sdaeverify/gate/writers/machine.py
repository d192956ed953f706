"""A gate for programs: JSON, a badge, and JUnit XML of the family xunit2.

In the last there is a suite for each problem and a case for each quantity. A case of that family has no properties
and no errors: what was measured is in its ``system-out``, and what could not be measured is a failure of type
``unmeasured``.
"""

from collections import Counter
from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ...report.plain import visible
from ..gated import WORDS, Gated
from ..outcomes import ORDER, Outcome, Status
from .messages import headline, message, remark

SCHEMA = 1
GOOD, OPEN, BAD = "brightgreen", "yellow", "red"
LOCK = "lock file"
SKIPPED = frozenset({Status.UNDECIDED, Status.XFAILED})


def json_report(gated: Gated) -> dict[str, object]:
    """Return the contents of ``gate.json``; a number that is not finite is null.

    Parameters
    ----------
    gated : Gated

    Returns
    -------
    dict
    """
    return {
        "schema_version": SCHEMA,
        "exit_code": int(gated.code),
        "meaning": gated.words,
        "tier": gated.policy.tier,
        "seed": gated.settings.seed,
        "alpha": gated.policy.alpha,
        "paths": gated.settings.paths,
        "steps": list(gated.settings.steps),
        "counts": {str(status): count for status, count in sorted(gated.counts.items())},
        "lock_violations": [visible(line) for line in gated.lock.violations],
        "warnings": [visible(line) for line in gated.warnings],
        "notes": [visible(line) for line in (*gated.lock.notes, *gated.notes)],
        "outcomes": [_row(outcome, gated) for outcome in gated.outcomes],
    }


def _row(outcome: Outcome, gated: Gated) -> dict[str, object]:
    cell, finding = outcome.cell, outcome.finding
    texts = {
        "scheme": cell.scheme.label,
        "problem": cell.spec.label,
        "measure": cell.measure.name,
        "quantity": finding.quantity,
        "status": str(outcome.status),
        "verdict": str(finding.verdict),
        "claim": outcome.claim,
        "source": finding.claim.source if finding.claim else "",
        "reason": str(finding.reason),
        "method": str(finding.method or ""),
        "expected": outcome.expected,
        "reproduce": gated.command(outcome),
    }
    numbers = {"estimate": finding.estimate, "ci_low": finding.low, "ci_high": finding.high}
    return {
        **{name: visible(text) for name, text in texts.items()},
        **{name: float(number) if isfinite(number) else None for name, number in numbers.items()},
        "red": gated.is_red(outcome),
        "paths": outcome.paths,
    }


# A badge as shields.io reads it from an address: JSON with a label, a message and a colour.


def badge(gated: Gated) -> dict[str, object]:
    """Return a badge that is never green while a claim is undecided or expected to fail.

    Parameters
    ----------
    gated : Gated

    Returns
    -------
    dict
    """
    counts = gated.counts
    others = [f"{counts[s]} {WORDS[s]}" for s in ORDER if counts[s] and s is not Status.PASSED]
    message = f"verified {counts[Status.PASSED]}/{len(gated.outcomes)}"
    colour = BAD if gated.code else OPEN if others else GOOD
    return {"schemaVersion": 1, "label": "sdaeverify", "message": ", ".join([message, *others]), "color": colour}


class _Case(NamedTuple):
    """A test case: what it is called, what became of it (nothing, ``failure`` or ``skipped``) and what it says."""

    classname: str
    name: str
    seconds: float = 0.0
    tag: str = ""
    kind: str = ""
    message: str = ""
    text: str = ""


def junit_xml(gated: Gated) -> str:
    """Return the text of a JUnit file.

    Parameters
    ----------
    gated : Gated

    Returns
    -------
    str
        Control characters, which XML cannot hold, are shown as escapes.
    """
    root = Element("testsuites", name="sdaeverify gate")
    together = Counter((o.cell.spec.label, o.cell.scheme.label) for o in gated.outcomes)
    suites: dict[str, list[_Case]] = {}
    for outcome in gated.outcomes:
        place = outcome.cell.spec.label, outcome.cell.scheme.label
        suites.setdefault(place[0], []).append(_case(outcome, gated, outcome.seconds / together[place]))
    if gated.lock.violations:
        suites[LOCK] = [_Case(LOCK, line, tag="failure", kind="lock", message=line) for line in gated.lock.violations]
    totals = Counter[str]()
    for name, cases in suites.items():
        totals += _add_suite(root, name, cases, gated)
    for name in ("tests", "failures", "errors"):
        root.set(name, str(totals[name]))
    indent(root)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{tostring(root, encoding="unicode")}\n'


def _case(outcome: Outcome, gated: Gated, seconds: float) -> _Case:
    cell = outcome.cell
    tag = "failure" if gated.is_red(outcome) else "skipped" if outcome.status in SKIPPED else ""
    text = message(outcome, gated.settings, gated.command(outcome))
    name = f"{cell.measure.name} {outcome.finding.quantity}".strip()
    measured = f"{text}\n  paths: {outcome.paths}\n  seed: {gated.settings.seed}"
    first = f"{headline(outcome)}: {remark(outcome)}"
    return _Case(cell.scheme.label, name, seconds, tag, str(outcome.status), first, measured)


def _add_suite(root: Element, name: str, cases: Sequence[_Case], gated: Gated) -> Counter[str]:
    counts = Counter(case.tag for case in cases)
    numbers = {"tests": len(cases), "failures": counts["failure"], "errors": 0, "skipped": counts["skipped"]}
    seconds = sum(case.seconds for case in cases)
    texts = {"name": visible(name), **{key: str(number) for key, number in numbers.items()}}
    suite = SubElement(root, "testsuite", {**texts, "time": f"{seconds:.3f}"})
    properties = SubElement(suite, "properties")
    for key, value in _properties(gated).items():
        SubElement(properties, "property", name=key, value=visible(str(value)))
    for case in cases:
        _add_case(suite, case)
    return Counter(numbers)


def _add_case(suite: Element, case: _Case) -> None:
    texts = {"classname": visible(case.classname), "name": visible(case.name), "time": f"{case.seconds:.3f}"}
    element = SubElement(suite, "testcase", texts)
    if case.tag:
        why = SubElement(element, case.tag, type=case.kind, message=visible(case.message))
        why.text = case.text if case.tag == "failure" else None
    if case.text:
        SubElement(element, "system-out").text = case.text


def _properties(gated: Gated) -> dict[str, object]:
    settings = gated.settings
    return {
        "tier": gated.policy.tier,
        "seed": settings.seed,
        "alpha": gated.policy.alpha,
        "paths": settings.paths,
        "steps": f"{settings.steps[0]}..{settings.steps[-1]}",
        "looks": settings.looks,
        "family": settings.family,
    }
