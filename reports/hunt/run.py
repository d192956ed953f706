"""Hunts of wrong schemes and of all shipped ones: ``python reports/hunt/run.py wrong`` or ``shipped``, with a time.

``wrong`` hunts planted bugs, ten minutes each by default, and writes ``wrong.csv``: examples and seconds until each
was refuted, what that shrank to, and the verdict on the right scheme there; with labels of schemes behind the time,
these are hunted again and their rows replaced. ``shipped`` hunts each claim of every registered scheme by examples of
each form, or of the forms that are named behind the time, ten minutes a form by default, and adds rows to
``shipped.csv``: each call draws with the next seed, so that hunts of many days add up; all rows of a form and a seed
have the CPU seconds that the hunts of this form took together. What is found is written to the folder ``found``.
"""

import csv
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import fields, replace
from itertools import zip_longest
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import sdaeverify
import sdaeverify_hunt
from sdaeverify import Scheme, UsageError
from sdaeverify.errors import FAULTS
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_schemes
from sdaeverify_hunt.report import Attack
from sdaeverify_hunt.strategies import EXAMPLES

HERE = Path(__file__).parent
MINUTES, SHRINKING, CORES = 10.0, 60.0, 2
# Constraints come first, as few paths show them, then what one step tells of, and last what takes long runs.
PREFERRED = ("drift", "multipliers", "uniformity", "strong", "weak", "limits", "intervals", "stability")
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
        "most terms": example.longest,
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
    attack = attack_by_turns(bug.scheme, minutes)
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
    """Return the measures of which a scheme claims something, in the order in which it is hunted by them."""
    claimed = {claim.measure for claim in scheme.promises}
    return [*(name for name in PREFERRED if name in claimed), *sorted(claimed - {*PREFERRED})]


def attack_by_turns(scheme: Scheme, minutes: float) -> Attack:
    """Hunt what a scheme claims, measure by measure until something is found; each has its share of the time left.

    What is claimed of no drawn example, as stability, is put to registered problems with other numbers at the end.
    """
    begun, met = time.monotonic(), list[Attack]()
    for form, end in ((form_of(scheme), 0.8), ("registered", 1.0)):
        tried = {attack.measure for attack in met if attack.tried}
        measures = [measure for measure in measures_of(scheme) if measure not in tried]
        for place, measure in enumerate(measures):
            left = max(end * minutes - (time.monotonic() - begun) / 60.0, 0.02)
            met.append(attack_by(scheme, measure, form, left / (len(measures) - place)))
            if met[-1].example is not None:
                return met[-1]
    return together(met)


def together(met: Sequence[Attack]) -> Attack:
    """Return attacks that found nothing as one, whose numbers are their sums."""
    tried, measures = Counter[tuple[str, str]](), dict.fromkeys(attack.measure for attack in met)
    for attack in met:
        tried.update(attack.tried)
    sums = {name: sum(getattr(attack, name) for attack in met) for name in ("verified", "doubtful")}
    return replace(met[0], measure=" ".join(measures), tried=tried, **sums)


def attack_by(scheme: Scheme, measure: str, form: str, minutes: float) -> Attack:
    """Hunt what a scheme claims of one measure."""
    report = sdaeverify_hunt.hunt(scheme, measures=measure, forms=[form], minutes=minutes, shrinking=SHRINKING)
    return report.attacks[0]


def shipped(
    minutes: float, names: Sequence[str], rows: Sequence[Mapping[str, object]]
) -> Iterator[dict[str, object]]:
    """Hunt all claims of all registered schemes, or of those that solve the forms that are named."""
    schemes = select_schemes(load_registry([]), ())
    for form in names or (*EXAMPLES, "registered"):
        own = [scheme for scheme in schemes if form in ("registered", *(each.__name__ for each in scheme.forms))]
        seed = 1 + max((int(str(row["seed"])) for row in rows if row["form"] == form), default=0)
        begun = time.process_time()
        # No scheme is made for some forms, as index 1, that others have a view of.
        report = sdaeverify_hunt.hunt(own or schemes, forms=[form], minutes=minutes, shrinking=SHRINKING, seed=seed)
        seconds = round(time.process_time() - begun)
        for attack in report.attacks:
            write_example(attack, seed)
            yield row_of(attack, seed=seed, **{"CPU seconds of the form": seconds})


def write_example(attack: Attack, seed: int) -> None:
    """Write what refutes a shipped scheme as a plugin file."""
    if attack.example is not None:
        (HERE / "found").mkdir(exist_ok=True)
        file = HERE / "found" / f"{attack.scheme}-{attack.measure}-{attack.form}-{seed}.py"
        file.write_text(attack.example.source, encoding="utf-8")


def kept(file: Path) -> list[dict[str, object]]:
    """Return the rows that a table has."""
    if not file.exists():
        return []
    with file.open(newline="", encoding="utf-8") as old:
        return [dict(row) for row in csv.DictReader(old)]


def hunt_wrong(minutes: float, names: Sequence[str]) -> None:
    """Hunt planted bugs, and write the table anew as soon as a row is known."""
    rows = kept(HERE / "wrong.csv") if names else []
    for row in wrong(minutes, names):
        rows = [*(each for each in rows if each["scheme"] != row["scheme"]), row]
        write(HERE / "wrong.csv", rows, ("form", "scheme", "measure"))


def hunt_shipped(minutes: float, names: Sequence[str]) -> None:
    """Hunt shipped schemes, and add rows to the table as soon as they are known."""
    rows = kept(HERE / "shipped.csv")
    for row in shipped(minutes, names, tuple(rows)):
        rows.append(row)
        write(HERE / "shipped.csv", rows, ("form", "scheme", "measure", "seed"))


def write(file: Path, rows: Sequence[Mapping[str, object]], order: Sequence[str]) -> None:
    """Write a table, sorted by some of its columns."""
    with file.open("w", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, list(rows[-1]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda row: [str(row[name]) for name in order]))


if __name__ == "__main__":
    MAKERS = {"wrong": hunt_wrong, "shipped": hunt_shipped}
    MAKERS[sys.argv[1]](float(sys.argv[2]) if len(sys.argv) > 2 else MINUTES, sys.argv[3:])
