"""Right and wrong schemes on random members of forms: ``python reports/members/run.py [--only PART] [--draws N]``.

``draws`` puts the claims of right schemes to 200 members of each class and writes ``draws.csv``; ``mutations``
changes each coefficient of the shipped schemes by 1 per cent and writes ``mutations.csv``; ``planted`` puts planted
bugs to members and writes ``planted.csv``; ``cost`` writes the CPU seconds of each scheme and class, ``cost.csv``.
All members are drawn by the seed of a default run.
"""

import argparse
import csv
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

import sdaeverify
from sdaeverify import Scheme
from sdaeverify.contracts.finding import Verdict
from sdaeverify.contracts.measure import Measure
from sdaeverify.contracts.settings import Settings
from sdaeverify.errors import FAULTS, ProblemError, one_line
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_measures, select_schemes
from sdaeverify_orders.members.classes import MemberClass, member_classes, member_of
from sdaeverify_orders.members.rows import MEMBERS, member_rows
from sdaeverify_orders.order_tests import answers

if __package__:
    from .mutations import MUTATED, Mutation, loaded, mutations_of
else:
    from mutations import MUTATED, Mutation, loaded, mutations_of

HERE, SEED = Path(__file__).parent, Settings().seed
DRAWS, CHUNK, CORES = 200, 10, 2
WORST_FIRST = ("refuted", "undecided", "verified")
FORMS = {"HolonomicSDAE", "ConstrainedLangevin", "DelaySDAE", "IndexOneSDAE"}
# Right parameters of shipped schemes beside those that are registered.
FURTHER = (
    "half-explicit-euler[truncation=0.05]",
    "semi-implicit-projection-euler[solver=newton]",
    "explicit-projection-euler[solver=newton]",
    "implicit-euler-ggl[guess=V0]",
    "constrained-euler[solver=frozen]",
    "uniformly-accurate[theta=0.5]",
    "uniformly-accurate[solver=frozen]",
    "stochastic-theta[theta=0]",
    "stochastic-theta[theta=1]",
    "lagged-algebraic-theta[theta=0]",
    "lagged-algebraic-theta[theta=0.5]",
)


@lru_cache(maxsize=1)
def measures() -> tuple[Measure, ...]:
    """Return the measures that have an answer about members."""
    return tuple(each for each in select_measures(load_registry(environ={})) if answers(each))


@lru_cache(maxsize=1)
def planted() -> Mapping[str, Any]:
    """Return the planted changes of schemes for the forms, by label."""
    bugs = load_registry(environ={}, lab=True).things("sdaeverify_planted").values()
    return {bug.label: bug for bug in bugs if has_members(bug.scheme)}


@lru_cache(maxsize=1)
def right_schemes() -> Mapping[str, Scheme]:
    """Return the right schemes for the forms: shipped ones, and planted changes that keep all claims."""
    registry = load_registry(environ={})
    shipped = [*select_schemes(registry), *select_schemes(registry, FURTHER)]
    changed = [bug.scheme for bug in planted().values() if bug.equivalent]
    return {each.label: each for each in (*shipped, *changed) if has_members(each)}


def has_members(scheme: Scheme) -> bool:
    """Return whether a scheme solves a form with random members."""
    return any(form.__name__ in FORMS for form in scheme.forms)


@lru_cache(maxsize=1)
def classes() -> Mapping[str, dict[MemberClass, list[Scheme]]]:
    """Return each class, by name, with the right schemes whose claims are put to it."""
    found: dict[str, dict[MemberClass, list[Scheme]]] = {}
    for scheme in right_schemes().values():
        for kind in member_classes(scheme, SEED):
            found.setdefault(kind.name, {}).setdefault(kind, []).append(scheme)
    return found


def claimed(scheme: Scheme, kind: MemberClass) -> list[Measure]:
    """Return the measures whose claims are put to a class."""
    names = {claim.measure for claim in member_classes(scheme, SEED).get(kind, ())}
    return [measure for measure in measures() if measure.name in names]


def verdict_on(scheme: Scheme, measure: Measure, member: Any) -> tuple[str, str]:
    """Return the verdict on the claims of a measure about one member, the worst one, and its reason."""
    with np.errstate(all="ignore"):
        found = [each for each in measure.judge_member(scheme, member) if each.claim is not None]
    words = {Verdict.REFUTED: "refuted", Verdict.VERIFIED: "verified"}
    answers_found = [(words.get(each.verdict, "undecided"), str(each.reason)) for each in found]
    return min(answers_found, key=lambda each: WORST_FIRST.index(each[0]), default=("", ""))


# Draws.


def judge_draws(task: tuple[str, int, int]) -> list[dict[str, Any]]:
    """Return a row for each scheme, measure and member of a stretch of indices of a class."""
    name, first, last = task
    ((kind, schemes),) = classes()[name].items()
    rows = []
    for index in range(first, last):
        try:
            member = member_of(kind, SEED, index)
        except ProblemError as error:
            rows.append({"class": name, "index": index, "verdict": "inconsistent", "reason": one_line(error)})
            continue
        for scheme in schemes:
            for measure in claimed(scheme, kind):
                verdict, reason = verdict_on(scheme, measure, member)
                row = {"class": name, "scheme": scheme.label, "measure": measure.name, "index": index}
                rows.append({**row, "verdict": verdict, "reason": reason})
    return rows


def draws(count: int, out: Path) -> Iterator[dict[str, Any]]:
    """Yield the counts of verdicts of each right scheme, class and measure."""
    tasks = [(name, i, min(i + CHUNK, count)) for name in classes() for i in range(0, count, CHUNK)]
    rows = [row for part in in_parallel(judge_draws, tasks) for row in part]
    write(out / "not_verified.csv", [row for row in rows if row["verdict"] not in {"verified", ""}])
    counts = Counter((r["class"], r.get("scheme", ""), r.get("measure", ""), r["verdict"]) for r in rows)
    for name, scheme, measure in dict.fromkeys(key[:3] for key in counts):
        own = {verdict: counts[name, scheme, measure, verdict] for verdict in ("verified", "undecided", "refuted")}
        if sum(own.values()):
            yield {"class": name, "scheme": scheme, "measure": measure, **own}
    inconsistent = Counter(row["class"] for row in rows if row["verdict"] == "inconsistent")
    for name, number in inconsistent.items():
        yield {"class": name, "scheme": "", "measure": "", "inconsistent": number}


# Mutations.


def judge_mutation(mutation: Mutation) -> dict[str, Any]:
    """Return the row of a mutation: the first measure and class that refutes it, or how many claims are verified."""
    row = {**mutation.row, "verdict": "raises", "by": "", "verified": 0, "undecided": 0, "reason": ""}
    try:
        schemes = loaded(mutation)
        known = {scheme.label: claims_of(scheme) for scheme in schemes}
        found = [(scheme, each) for scheme in schemes for each in answers_on_members(scheme, known[scheme.label])]
    except (*FAULTS, RecursionError) as error:
        return {**row, "reason": one_line(error)}
    return {**row, **summary(found)}


def claims_of(scheme: Scheme) -> list[tuple[MemberClass, Measure]]:
    """Return the classes and measures that the unchanged scheme of the same label is asked about."""
    right = unchanged()[scheme.label]
    return [(kind, measure) for kind in member_classes(right, SEED) for measure in claimed(right, kind)]


@lru_cache(maxsize=1)
def unchanged() -> Mapping[str, Scheme]:
    """Return the unchanged schemes that are mutated, by label."""
    registry = load_registry(environ={})
    return {each.label: each for names in MUTATED.values() for each in select_schemes(registry, names)}


def answers_on_members(
    scheme: Scheme, asked: Sequence[tuple[MemberClass, Measure]]
) -> Iterator[tuple[str, str, str, str]]:
    """Yield class, measure, verdict and reason; the last is the first refutation, as later ones change nothing."""
    for kind, measure in asked:
        verdicts = [verdict_on(scheme, measure, member_of(kind, SEED, index)) for index in range(MEMBERS)]
        refuting = [reason for verdict, reason in verdicts if verdict == "refuted"]
        if len(refuting) == MEMBERS:
            yield kind.name, measure.name, "refuted", refuting[0]
            return
        undecided = [reason for verdict, reason in verdicts if verdict not in {"verified", ""}]
        if any(verdict for verdict, _ in verdicts):
            yield kind.name, measure.name, "undecided" if undecided else "verified", (*undecided, "")[0]


def summary(found: Iterable[tuple[Scheme, tuple[str, str, str, str]]]) -> dict[str, Any]:
    """Return the verdict on a changed scheme: refuted where a claim is, verified where all are, else undecided."""
    rows = [(scheme.label, *each) for scheme, each in found]
    counts = Counter(each[3] for each in rows)
    worst = next((v for v in WORST_FIRST if counts[v]), "not asked")
    first = next((each for each in rows if each[3] == worst), ("",) * 5)
    by = "" if worst == "verified" else f"{first[0]}, {first[1]}: {first[2]}"
    return {
        "verdict": worst,
        "by": by,
        "verified": counts["verified"],
        "undecided": counts["undecided"],
        "reason": first[4],
    }


def mutations(*_: Any) -> Iterator[dict[str, Any]]:
    """Yield a row for each mutation."""
    unchanged()
    yield from in_parallel(judge_mutation, [*mutations_of()], chunk=4)


# Planted bugs.


def judge_planted(label: str) -> dict[str, Any]:
    """Return the row of a planted bug."""
    bug = planted()[label]
    row = {"scheme": bug.scheme.label, "problem": bug.problem, "bug": bug.bug, "equivalent": bug.equivalent}
    rows = []
    for kind in member_classes(bug.scheme, SEED):
        rows += list(member_rows(bug.scheme, kind, measures(), SEED))
    refuted = next((each for each in rows if each.verdict is Verdict.REFUTED), None)
    tier = tier_of_problem(bug)
    found = Counter(each.verdict.value for each in rows)
    verdict = (
        "refuted"
        if refuted
        else "undecided"
        if found[Verdict.INCONCLUSIVE.value]
        else "verified"
        if rows
        else "not asked"
    )
    other = next((each.why for each in rows if each.verdict is Verdict.INCONCLUSIVE), "")
    by = (
        {"by": f"{refuted.kind}: {refuted.measure}", "reason": refuted.why}
        if refuted
        else {"by": "", "reason": other}
    )
    return {**row, "shipped problem": tier, "members": verdict, **by}


def tier_of_problem(bug: Any) -> str:
    """Return the measures by which single steps refute a planted bug on its problem, without paths."""
    found = sdaeverify.verify(bug.scheme, bug.problem, paths=256, levels=4, max_looks=1).verdicts
    refuted = found[(found.verdict == "refuted") & found.decided_by.isin(["T0", "T1"])]
    return ", ".join(sorted({f"{row.measure} {row.decided_by}" for row in refuted.itertuples()}))


def planted_rows(*_: Any) -> Iterator[dict[str, Any]]:
    """Yield a row for each planted bug."""
    yield from in_parallel(judge_planted, [*planted()])


# Cost.


def judge_cost(label: str) -> list[dict[str, Any]]:
    """Return the CPU seconds of a scheme, class by class, and of the members' references, paid once."""
    scheme, rows = right_schemes()[label], []
    for kind in member_classes(scheme, SEED):
        spent = []
        for _ in range(2):
            begin = time.process_time()
            judged = list(member_rows(scheme, kind, measures(), SEED))
            spent.append(time.process_time() - begin)
        if judged:
            rows.append({"scheme": label, "class": kind.name, "first": f"{spent[0]:.2f}", "again": f"{spent[1]:.2f}"})
    return rows


def cost(*_: Any) -> Iterator[dict[str, Any]]:
    """Yield the seconds of each right scheme, in this process."""
    for label in right_schemes():
        yield from judge_cost(label)


def in_parallel(function: Callable[[Any], Any], tasks: Sequence[Any], chunk: int = 1) -> Iterator[Any]:
    """Yield the answers to tasks in their order."""
    with ProcessPoolExecutor(CORES, mp_context=get_context("fork")) as pool:
        yield from pool.map(function, tasks, chunksize=chunk)


def write(file: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write a table with the columns of all rows."""
    columns = list(dict.fromkeys(column for row in rows for column in row))
    with file.open("w", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


PARTS = {"draws": draws, "mutations": mutations, "planted": planted_rows, "cost": cost}


def main() -> None:
    """Run the parts that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=PARTS, action="append", help="a part; all if left out")
    parser.add_argument("--draws", type=int, default=DRAWS)
    parser.add_argument("--out", type=Path, default=HERE, help="folder of the tables")
    given = parser.parse_args()
    for part in given.only or PARTS:
        begin = time.perf_counter()
        rows = list(PARTS[part](given.draws, given.out))
        write(given.out / f"{part}.csv", rows)
        print(f"{part}: {len(rows)} rows, {time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
