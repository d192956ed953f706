"""What is said of one-line mistakes: ``python reports/mistakes/run.py`` (four CPU minutes).

``planted.csv`` has a mistake a row: a text in the file of a shipped scheme, and what stands in its place. Each was
written without a look at the dictionary of mistakes; ``says`` is what a right sentence contains, empty where no entry
of the dictionary is the mistake. Every wrong scheme is put to problems of several kinds, linear ones among them, on
which mistakes look alike, and to all classes of equations.

Writes ``sentences.csv``, a row for each wrong scheme and sentence, and ``summary.txt``. A sentence that does not
contain what a right one does is *wrong*; the program ends with 1 if there is one, or one about a shipped scheme.
"""

import csv
import importlib
import inspect
import sys
import types
import warnings
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from sdaeverify import Problem, Scheme
from sdaeverify.contracts.finding import Verdict
from sdaeverify.probe.local.solved_instead import solved_instead
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_problems, select_schemes
from sdaeverify_orders.trees.classes import tree_classes_of
from sdaeverify_orders.trees.modified.equation import is_slow
from sdaeverify_orders.trees.report import rows_of

HERE = Path(__file__).parent
PROBLEMS = "gbm,ou,linear-test,double-well,spiral,noncommuting,hyperbolic,levy-area,harmonic-langevin,angle-pendulum"
CLASS = "class "


class Planted(NamedTuple):
    """A one-line mistake; the columns of ``planted.csv``."""

    module: str
    scheme: str
    mistake: str
    says: str
    old: str
    new: str

    def build(self) -> Scheme:
        """Return the wrong scheme.

        Raises
        ------
        ValueError
            If the file does not have the text.
        """
        source = inspect.getsource(importlib.import_module(f"sdaeverify_schemes.{self.module}"))
        if self.old not in source:
            raise ValueError(f"{self.module} does not have {self.old!r}")
        name = f"sdaeverify_schemes.{self.module}_mistaken"
        made = types.ModuleType(name)
        made.__package__ = name.rpartition(".")[0]
        sys.modules[name] = made
        exec(compile(source.replace(self.old, self.new, 1), name, "exec"), made.__dict__)
        scheme = getattr(made, self.scheme)()
        assert isinstance(scheme, Scheme)
        return scheme

    def outcome(self, sentence: str) -> str:
        """Return whether a sentence is right or wrong."""
        return "right" if any(part and part in sentence for part in self.says.split(" | ")) else "wrong"


@cache
def problems() -> dict[str, Problem]:
    """Return the problems by label."""
    return {spec.label: spec.build() for spec in select_problems(load_registry(environ={}), PROBLEMS)}


def sentences(scheme: Scheme) -> dict[str, list[str]]:
    """Return what is said of a scheme, each sentence with the problems and classes on which it is."""
    found: dict[str, list[str]] = {}
    for place, sentence in (*_on_problems(scheme), *_on_classes(scheme)):
        if sentence:
            found.setdefault(sentence, []).append(place)
    return found


def _on_problems(scheme: Scheme) -> Iterator[tuple[str, str]]:
    for label, problem in problems().items():
        view = scheme.view_of(problem)
        if view is not None and not scheme.why_not(view):
            yield label, solved_instead(scheme, view, paths=any(each.measure == "strong" for each in scheme.promises))


def _on_classes(scheme: Scheme) -> Iterator[tuple[str, str]]:
    for kind in tree_classes_of(scheme):
        if not is_slow(kind):
            for row in rows_of(scheme, [kind], None):
                if row.verdict is Verdict.REFUTED:
                    yield f"{CLASS}{kind.name}", row.mistake.removeprefix("it solves another equation: ")


def planted() -> list[Planted]:
    """Return the mistakes."""
    with (HERE / "planted.csv").open(newline="") as table:
        return [Planted(**row) for row in csv.DictReader(table)]


def shipped() -> Iterator[tuple[Any, ...]]:
    """Yield a row for each sentence about a shipped scheme: there is to be none."""
    for scheme in select_schemes(load_registry(environ={}), "*"):
        for sentence, places in sentences(scheme).items():
            yield scheme.label, "", "", "wrong", sentence, ", ".join(places)


def summary(rows: Sequence[tuple[Any, ...]], about: Sequence[tuple[Any, ...]]) -> Iterator[str]:
    """Yield the number of mistakes that are named rightly, not at all, and wrongly."""
    outcomes: dict[tuple[str, str], set[str]] = {}
    for scheme, mistake, _, outcome, *_ in rows:
        outcomes.setdefault((scheme, mistake), set()).add(outcome)
    known = {(scheme, mistake) for scheme, mistake, says, *_ in rows if says}
    wrong = [key for key, found in outcomes.items() if "wrong" in found]
    named = [key for key, found in outcomes.items() if "right" in found and key not in wrong]
    yield f"one-line mistakes: {len(outcomes)}; named rightly: {len(named)}; named wrongly: {len(wrong)}"
    yield f"entries of the dictionary among them: {len(known)}, of which no sentence: {len(known - {*named, *wrong})}"
    yield f"sentences about shipped schemes: {len(about)}"
    yield from (f"wrong: {scheme}, {mistake}" for scheme, mistake in wrong)


def main() -> int:
    """Write the tables, and return 1 if a sentence is wrong."""
    warnings.simplefilter("ignore")
    rows: list[tuple[Any, ...]] = []
    for each in planted():
        found = sentences(each.build())
        told = [(each.outcome(sentence), sentence, ", ".join(places)) for sentence, places in found.items()]
        rows += [(each.scheme, each.mistake, each.says, *one) for one in told or [("none", "", "")]]
    about = [*shipped()]
    with (HERE / "sentences.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("scheme", "mistake", "says", "outcome", "sentence", "where"))
        table.writerows((*rows, *about))
    lines = [*summary(rows, about)]
    (HERE / "summary.txt").write_text("\n".join([*lines, ""]), encoding="utf-8")
    print(*lines, sep="\n")
    return int(any(row[3] == "wrong" for row in (*rows, *about)))


if __name__ == "__main__":
    sys.exit(main())
