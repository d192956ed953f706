"""Hunts of wrong schemes and of all shipped ones: ``python reports/hunt/run.py wrong`` or ``shipped``, with a time.

``wrong`` hunts planted bugs on two cores, two minutes each by default, and writes ``wrong.csv``: examples and seconds
until each was refuted, what that shrank to, and the verdict on the right scheme there; with labels of schemes behind
the time, these are hunted again and their rows replaced. ``shipped`` hunts each claim of every registered scheme by
examples of each form, ten minutes a form by default, and writes ``shipped.csv``.
"""

import csv
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import fields
from itertools import zip_longest
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import sdaeverify
from sdaeverify import Scheme, UsageError
from sdaeverify.errors import FAULTS
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_schemes
from sdaeverify.testing.hunting.report import Attack
from sdaeverify.testing.strategies import EXAMPLES

HERE = Path(__file__).parent
MINUTES = {"wrong": 2.0, "shipped": 10.0}
SHRINKING, CORES = 15.0, 2
# What one step tells of comes first: a bug is hunted by the first two that its scheme claims, half of the time each.
PREFERRED = ("strong", "weak", "limits", "invariant")
# Of the many bugs of Euler-Maruyama and others without constraints: those that conditions on trees do not see.
WORDS = ("Within", "Cut", "Clipped", "Stale", "Hidden", "Batch", "Window", "Region")


def hunted_bugs() -> Iterator[Any]:
    """Yield the planted bugs: of forms that have no trees all, of equations without constraints some."""
    for bug in load_registry(environ={}, lab=True).things("sdaeverify_planted").values():
        kinds = {cls.__name__ for cls in type(bug.scheme).__mro__}
        if form_of(bug.scheme) != "SDE" or any(word in kind for word in WORDS for kind in kinds):
            yield bug


def in_turns(bugs: Iterable[Any]) -> list[Any]:
    """Return bugs so that their forms take turns: a table that is not finished has some of each."""
    by_form: dict[str, list[Any]] = {}
    for bug in bugs:
        by_form.setdefault(form_of(bug.scheme), []).append(bug)
    return [bug for row in zip_longest(*by_form.values()) for bug in row if bug is not None]


def form_of(scheme: Scheme) -> str:
    """Return the first form that a scheme solves, by name."""
    return scheme.forms[0].__name__


def right_scheme(scheme: Scheme) -> Scheme | None:
    """Return the shipped scheme that a wrong one is made from, with those of its parameters that it has."""
    shipped = next((cls for cls in type(scheme).__mro__ if cls.__module__.startswith("sdaeverify_schemes")), None)
    if shipped is None:
        return None
    return shipped(**{field.name: getattr(scheme, field.name) for field in fields(shipped)})


def verdict_of_right(scheme: Scheme, attack: Attack) -> tuple[str, str]:
    """Return the right scheme and the verdict on it where a wrong one was refuted."""
    right = right_scheme(scheme)
    if right is None or attack.example is None:
        return "", ""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "counterexample.py"
        file.write_text(attack.example.source, encoding="utf-8")
        try:
            rows = sdaeverify.verify(right, "counterexample", attack.measure, plugins=[file]).verdicts
        except (UsageError, *FAULTS) as error:
            return right.label, str(error)
    verdicts = set(rows[rows.scheme == right.label]["verdict"])
    return right.label, "refuted" if "refuted" in verdicts else " and ".join(sorted(verdicts))


def row_of(attack: Attack, **more: object) -> dict[str, object]:
    """Return what became of a hunt as a row of a table."""
    example = attack.example
    known = {} if example is None else {
        "claim": attack.claim,
        "found after": attack.found_after,
        "seconds": round(attack.seconds, 1),
        "confirmed": attack.confirmed,
        "paths alone": attack.by_paths,
        "dimension": example.dimension,
        "terms": example.terms,
        "most terms": max((len(field) for field in example.fields), default=0),
        "kind": example.kind,
        "reason": attack.reason,
    }  # fmt: skip
    names = (
        "claim",
        "found after",
        "seconds",
        "confirmed",
        "paths alone",
        "dimension",
        "terms",
        "most terms",
        "kind",
    )
    told = {name: known.get(name, "") for name in (*names, "reason")}
    counted = {"examples": attack.looked_at, "verified": attack.verified, "doubtful": attack.doubtful}
    return {**more, "scheme": attack.scheme, "measure": attack.measure, "form": attack.form, **counted, **told}


def wrong(minutes: float, names: Sequence[str]) -> Iterator[dict[str, object]]:
    """Hunt planted bugs, all or some."""
    # A hunt draws its own problems: the same scheme planted for several is hunted once.
    known = {bug.scheme.label: f"{bug.scheme.label} {bug.bug}" for bug in in_turns(hunted_bugs())}
    some = [known[label] for label in names or known]
    with ProcessPoolExecutor(CORES, mp_context=get_context("spawn")) as pool:
        for done in as_completed([pool.submit(hunted, key, minutes) for key in some]):
            yield done.result()


def hunted(key: str, minutes: float) -> dict[str, object]:
    """Return the row of a planted bug."""
    bug = next(bug for bug in hunted_bugs() if f"{bug.scheme.label} {bug.bug}" == key)
    begun = time.process_time()
    measures = measures_of(bug.scheme)
    for measure in measures:
        attack = attack_by(bug.scheme, measure, minutes / len(measures))
        if attack.example is not None:
            break
    right, verdict = verdict_of_right(bug.scheme, attack)
    row = row_of(attack, bug=bug.bug, equivalent=bool(bug.equivalent))
    return {
        **row,
        "CPU seconds": round(time.process_time() - begun, 1),
        "minutes": minutes,
        "right scheme": right,
        "its verdict": verdict,
    }


def measures_of(scheme: Scheme) -> list[str]:
    """Return the measures that a scheme is hunted by, one after another: of its claims without a condition."""
    claimed = {claim.measure for claim in scheme.promises if not claim.when}
    claimed = claimed or {claim.measure for claim in scheme.promises}
    return [*(name for name in PREFERRED if name in claimed), *sorted(claimed - {*PREFERRED})][:2]


def attack_by(scheme: Scheme, measure: str, minutes: float) -> Attack:
    """Hunt what a scheme claims of one measure."""
    report = sdaeverify.hunt(scheme, measures=measure, forms=[form_of(scheme)], minutes=minutes, shrinking=SHRINKING)
    return report.attacks[0]


def shipped(minutes: float, _: Sequence[str]) -> Iterator[dict[str, object]]:
    """Hunt all claims of all registered schemes."""
    schemes = select_schemes(load_registry([]), ())
    for form in (*EXAMPLES, "registered"):
        own = [scheme for scheme in schemes if form in ("registered", *(each.__name__ for each in scheme.forms))]
        begun = time.process_time()
        report = sdaeverify.hunt(own, forms=[form], minutes=minutes, shrinking=SHRINKING)
        for attack in report.attacks:
            yield row_of(attack)
        print(f"{form}: {time.process_time() - begun:.0f} s of CPU", file=sys.stderr)


def kept(file: Path, names: Sequence[str]) -> list[dict[str, object]]:
    """Return the rows that a table has; none if all are hunted."""
    if not names or not file.exists():
        return []
    with file.open(newline="", encoding="utf-8") as old:
        return [dict(row) for row in csv.DictReader(old)]


def main(what: str, minutes: float, names: Sequence[str]) -> None:
    """Hunt, and write the table anew as soon as a row is known."""
    file = HERE / f"{what}.csv"
    rows = kept(file, names)
    for row in {"wrong": wrong, "shipped": shipped}[what](minutes, names):
        rows = [each for each in rows if (each["scheme"], what) != (row["scheme"], "wrong")]
        rows = sorted([*rows, row], key=lambda each: (str(each["form"]), str(each["scheme"]), str(each["measure"])))
        with file.open("w", newline="", encoding="utf-8") as table:
            writer = csv.DictWriter(table, list(row), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else MINUTES[sys.argv[1]], sys.argv[3:])
